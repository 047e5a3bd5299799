"""A question of the agent in the viewer: its options, and what became of it, in words."""

from arl_tui.games.registry import screens_of
from arl_tui.viewer.reading import Viewing
from arl_tui.viewer.rows import BOLD, DIM, Run
from core.events import QuestionAnswered
from core.numerics.clock import NS_PER_S
from core.system.foreign_text import printable
from studies.session_view.questions import question_near
from studies.session_view.session import Moment

AFTERWARDS_NS = NS_PER_S
"""How long an answer stays, so that it is seen at the usual speed."""


def question_lines(viewing: Viewing, moment: Moment) -> list[list[Run]]:
    """Return the question that is open at a moment or has just been answered, in five lines; [] for none.

    The chosen option has a sign, and the line under the options says when the answer came, and whose it is.
    """
    session, protocol = viewing.session, viewing.session.protocol
    found = question_near(session, moment.time_ns)
    if found is None or protocol is None:
        return []
    posed, answer = found
    is_over = answer is not None and moment.time_ns > answer.time_ns + AFTERWARDS_NS
    if is_over or (answer is None and moment.covered != "question"):
        return []
    screens, asking = screens_of(protocol), protocol.agent.asking
    chosen = answer.chosen if answer is not None and answer.answer == "chosen" else None
    lines: list[list[Run]] = [
        [(f"Question {posed.question + 1}", BOLD), (f"  before step {posed.step}", DIM)],
    ]
    for key, action, detail in zip(asking.keys, posed.options, posed.details, strict=False):
        is_chosen = action == chosen
        style = BOLD if is_chosen else None
        lines.append([(f" {key}  {screens.option(detail, protocol)}{' ◀' if is_chosen else ''}", style)])
    whose = f"  {printable(viewing.name_of(answer.person), longest=20)}" if answer and session.people else ""
    return [*lines, [(_answer_words(answer), BOLD), (whose, DIM)]]


def _answer_words(answer: QuestionAnswered | None) -> str:
    if answer is None:
        return "The recording ends before an answer"
    if answer.answer == "time-limit":
        return "No answer within the limit"
    after_s = (answer.time_ns - answer.shown_ns) / NS_PER_S
    what = "Answered" if answer.answer == "chosen" else "None of these"
    return f"{what} after {after_s:.2f} s"
