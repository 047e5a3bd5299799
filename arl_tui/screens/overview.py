"""F2 on the first page: what this session will do, the participant's weight in each game included.

For the experimenter. The participant's pages do not name the key, and no page of a study has it: there the
experimenter may be blind, too (docs/decisions/weight-at-the-start.md).
"""

from collections.abc import Iterable
from typing import ClassVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.link import Ready
from arl_tui.app.session_setup import SessionSetup
from arl_tui.screens.page import PageScreen
from core.feedback.delays import describe
from core.session.plan import plan

TOPICS = ("Games", "Presses", "Asking", "Time", "Weight")
KEY = "f2"
"""Opens and closes the page."""


def topics_of(setup: SessionSetup, ready: Ready | None) -> dict[str, str]:
    """Return what a session will do, in sentences by topic.

    Args:
        setup: of the session, its credit rule settled.
        ready: what the worker said; None while it gets ready.
    """
    protocol = setup.protocol
    found = plan(protocol)
    topics = {topic: found[topic] for topic in TOPICS if topic in found}
    asked = setup.source.get("credit_asked_by", "protocol")
    rule = setup.source.get("credit", "rule")
    topics["Credit"] = f"{describe(protocol.agent.credit.delay)} ({rule}, asked for by the {asked})"
    if protocol.people:
        topics["Credit"] = found["Credit"]
    if ready is None:
        topics["Reach"] = "not worked out yet: the first page says it when it is"
    elif ready.reach is not None:
        topics["Reach"] = f"{ready.reach:.0%} of a press reaches the step it was meant for"
    return topics


class OverviewPage(PageScreen):
    """What the session will do, topic by topic; in English, as all that is said to experimenters."""

    HEADING = "For the experimenter: what this session will do"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(f"{KEY},escape,enter,space", "back", "", id="overview.back")
    ]

    def __init__(self, topics: dict[str, str]) -> None:
        """Prepare the page.

        Args:
            topics: sentences by topic.
        """
        super().__init__()
        self._topics = topics

    def body(self) -> Iterable[Widget]:
        """Return a line for each topic."""
        for topic, sentence in self._topics.items():
            yield Static(Text.assemble((f"{topic}  ", "bold"), sentence))
        yield Static(
            "\nThe participant should not read this page. F2 closes it.", classes="call", markup=False
        )

    def action_back(self) -> None:
        """Go back to the first page."""
        self.leave(True)
