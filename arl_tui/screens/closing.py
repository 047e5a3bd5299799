"""The last screen: thanks, what happened, and how much is recorded; or what went wrong."""

from collections.abc import Iterable
from typing import ClassVar, cast

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.outcome import SessionControls, SessionOutcome
from arl_tui.app.tally import beginning_and_end
from arl_tui.feedback_words import told
from arl_tui.language import later, tr, trn
from arl_tui.screens.page import PageScreen
from arl_tui.words import Words
from core.session.protocol import Protocol

FEWEST_COMPARED = 4
"""With fewer games the list of their figures says as much as two means."""


class ClosingScreen(PageScreen):
    """Says how the session ended."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(
            "enter,q,escape,ctrl+q,ctrl+c", "leave", "Leave", id="closing.leave", tooltip="Close the program"
        )
    ]

    VERTICAL_BREAKPOINTS = [(0, "-short"), (34, "-tall")]  # noqa: RUF012 - as Textual declares it

    def __init__(
        self,
        outcome: SessionOutcome,
        words: Words,
        *,
        show_weight: bool = False,
        in_study: bool = False,
        practice: bool = False,
        protocol: Protocol | None = None,
    ) -> None:
        """Prepare.

        Args:
            outcome: what is left of the session.
            words: of its game.
            show_weight: whether the participant may see the weight that their feedback had.
            in_study: the next part of a study follows, or its last page.
            practice: nothing counted.
            protocol: which keys there were, and whose; without it two of one participant.
        """
        super().__init__()
        self.outcome = outcome
        self._show_weight = show_weight
        self._protocol = protocol
        self._words = words
        self._in_study = in_study
        self._practice = practice
        self.HEADING = later("That was the practice") if practice else later("Thank you!")
        if outcome.trouble is not None:
            self.HEADING = later("The session had to end early")

    def body(self) -> Iterable[Widget]:
        """Return what happened, how much is recorded, and what went wrong."""
        outcome = self.outcome
        if outcome.trouble is not None:
            headline, _, details = outcome.trouble.partition("\n")
            yield Static(Text(headline), classes="trouble")
            # The end of a traceback says most.
            yield Static(Text("\n".join(details.strip().splitlines()[-10:])), id="trace")
        yield Static(self._what_happened())
        # Where something failed, the room is for what to do about it; of several people, for their lines.
        several = self._protocol is not None and bool(self._protocol.people)
        if outcome.trouble is None and len(outcome.tally.practised) >= 2 and not several:
            from arl_tui.widgets.learning_curve import LearningCurve  # here: nobody needs it before the end

            yield Static("\n" + tr("In practice, {unit} per game, block by block:", unit=self._words.unit))
            yield LearningCurve(outcome.tally.practised)
        if outcome.recording is not None:
            yield Static(Text(how_much_recorded(outcome)), classes="path")
        call = tr("Press {key_enter} to go on") if self._goes_on() else tr("Press {key_enter} to leave")
        yield Static(call, classes="call")

    def _goes_on(self) -> bool:
        """Whether something follows: the session after a practice, in a study the next part or last page."""
        outcome = self.outcome
        finished = outcome.trouble is None and outcome.stopped in (None, "practised")
        return finished and (self._practice or self._in_study)

    def _what_happened(self) -> str:
        tally = self.outcome.tally
        if not tally.steps:
            return tr("No game was shown.")
        games = len(tally.performances)
        lines = ", ".join(f"{performance:.4g}" for performance in tally.performances) or "-"
        what_was_told = self._told()
        if tally.taken_back:
            what_was_told += " " + tr("({taken_back} taken back)", taken_back=tally.taken_back)
        steps = f"{tally.steps} {tr(self._words.steps)}"
        said = [
            trn("You watched {n} game ({steps}).", "You watched {n} games ({steps}).", games, steps=steps),
            f"{tr(self._words.performance)}: {lines}",
            *self._change(),
            tr("What you told the computer: {told}", told=what_was_told),
        ]
        if tally.unseen:
            said.append(
                trn("On its own it practised {n} game.", "On its own it practised {n} games.", tally.unseen)
            )
        return "\n".join([*said, self._weight()]).rstrip()

    def _told(self) -> str:
        """Return how often each key was pressed, of several participants a line for each."""
        protocol, tally = self._protocol, self.outcome.tally
        if protocol is None:
            return tr("good {good}, bad {bad}", good=tally.good, bad=tally.bad)
        of_each = [
            told({value: n for (who, value), n in tally.said.items() if who == person}, keys)
            for person, keys in enumerate(protocol.keys_of_people)
        ]
        if not protocol.people:
            # Five grades have a line of their own: broken in two, they are read badly.
            return f"\n  {of_each[0]}" if protocol.keys.graded else of_each[0]
        return "".join(
            f"\n  {person.name}: {text}" for person, text in zip(protocol.people, of_each, strict=True)
        )

    def _change(self) -> list[str]:
        """Return how the agent played at the beginning and at the end, where there are games to compare."""
        performances = self.outcome.tally.performances
        if len(performances) < FEWEST_COMPARED:
            return []
        first, last = beginning_and_end(performances)
        return [
            tr(
                "At the beginning {first} per game, at the end {last}.",
                first=self._words.told(first),
                last=self._words.told(last),
            )
        ]

    def _weight(self) -> str:
        weight = self.outcome.tally.weight
        if not self._show_weight or weight is None:
            return ""
        return tr("Weight of your feedback in the last game: {weight:.2g}", weight=weight)

    def action_leave(self) -> None:
        """Close the program."""
        cast(SessionControls, self.app).exit(self.outcome)


def how_much_recorded(outcome: SessionOutcome) -> str:
    """Return how much of the session is recorded and known to be on the disk, in words.

    The terminal names the file afterwards: names of files and folders may tell the condition.
    """
    kept = outcome.kept
    if kept is not None and kept.written < kept.recorded:
        told = tr("What could be written is recorded.")
    elif outcome.trouble is None:
        told = tr("The session is recorded.")
    else:
        told = tr("Everything up to this moment is recorded.")
    if kept is None:
        return told
    if kept.synced >= kept.recorded:
        return told + "\n" + tr("All {events} events are on the disk.", events=kept.recorded)
    missing = kept.recorded - kept.written
    if not missing:
        return f"{told}\n" + tr(
            "{synced} of {events} events are known to be on the disk.",
            synced=kept.synced,
            events=kept.recorded,
        )
    return f"{told}\n" + tr(
        "{synced} of {events} events are known to be on the disk, {missing} could not be written to it.",
        synced=kept.synced,
        events=kept.recorded,
        missing=missing,
    )
