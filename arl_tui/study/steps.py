"""Single steps of a sitting: a new participant's code, the consent, and what is left of a step that plays
games.
"""

import hashlib
from collections.abc import Callable, Sequence
from typing import Literal, assert_never

from textual.screen import Screen

from arl_tui.games.registry import words_of
from arl_tui.language import tr
from arl_tui.participants import wrong_code
from arl_tui.study import words
from arl_tui.study.pages import ConsentPage, TextPage
from arl_tui.study.presenter import Played, Presenter
from core.numerics.clock import Clock, wall_time_utc
from studies.lab.blocks import BlockSoFar
from studies.lab.config import ASSIGNED, Block, Calibration, Consent, Practice, Step, Study, kind_of
from studies.lab.config import TextPage as TextStep
from studies.lab.enrolment import Attempt, NotNow
from studies.lab.ledger import Ledger
from studies.lab.progress import progress
from studies.lab.read import LoadedStudy
from studies.lab.sitting_log import ConsentAnswered, SittingLine, StepBegun, StepEnded


def ask_consent(
    loaded: LoadedStudy, code: str, presenter: Presenter, clock: Clock, lines: list[SittingLine]
) -> Literal["declined", "nothing"] | None:
    """Show everything up to the first consent; fill `lines` where it was given. Nothing is written."""
    for number, step in enumerate(loaded.study.sittings[0].steps):
        assert isinstance(step, TextStep | Consent), "a study file records nothing before consent"
        lines.append(StepBegun(step=number, kind=kind_of(step), time_ns=clock.now_ns()))
        results, closed = presenter.pages([page_of(loaded, step, code)])
        if closed or not results or results[-1] is None:
            return "nothing"
        if results[-1] is False:
            return "declined"
        if isinstance(step, Consent):
            lines.append(consent_line(loaded, step, number, results[-1], clock))
        lines.append(StepEnded(step=number, time_ns=clock.now_ns(), how="finished"))
        if isinstance(step, Consent):
            return None
    raise AssertionError("a study file has a consent before anything that records")


def page_of(
    loaded: LoadedStudy, step: TextStep | Consent, code: str, part: str = ""
) -> Callable[[], Screen[object]]:
    """Return what makes the page of a text or of a consent."""
    text = loaded.texts[step.text]
    if isinstance(step, Consent):
        return lambda: ConsentPage(text, step.statements, step.optional, code=code, part=part)
    return lambda: TextPage(text, code=code, part=part, heading=loaded.study.title)


def consent_line(
    loaded: LoadedStudy, step: Consent, number: int, answers: object, clock: Clock
) -> ConsentAnswered:
    """Return the record of a consent that was given."""
    assert isinstance(answers, dict), "a consent page is left with answers, or not at all"
    text = loaded.texts[step.text]
    return ConsentAnswered(
        step=number,
        text=text,
        text_version=step.version,
        text_sha256=hashlib.sha256(text.encode()).hexdigest(),
        answers=answers,
        at_utc=wall_time_utc(),
        time_ns=clock.now_ns(),
    )


def recorded_kind(step: Block | Practice | Calibration) -> Literal["block", "practice", "calibration"]:
    """Return which kind of recording a step leaves."""
    match step:
        case Block():
            return "block"
        case Practice():
            return "practice"
        case Calibration():
            return "calibration"
        case other:
            assert_never(other)


def played_of(block: BlockSoFar) -> Played:
    """Return what is left of a block that is finished."""
    return Played(
        how="finished",
        file=block.path.name,
        games=block.performances,
        presses=block.summary.presses_counted,
        taken_back=block.summary.presses_taken_back,
        unit=words_of(block.summary.game).unit,
    )


def block_of_visit(steps: Sequence[Step], number: int) -> str:
    """Return which block of a visit a step is, in words; nothing for calibrations."""
    if isinstance(steps[number], Practice):
        return tr(words.PRACTICE)
    if not isinstance(steps[number], Block):
        return ""
    blocks = [place for place, step in enumerate(steps) if isinstance(step, Block)]
    return tr(words.BLOCK, number=blocks.index(number) + 1, count=len(blocks))


def condition_of(study: Study, attempt: Attempt, number: int, step: Step) -> str:
    """Return the name of a block's condition; nothing for steps of another kind."""
    if not isinstance(step, Block):
        return ""
    if step.condition != ASSIGNED:
        return step.condition
    here = (attempt.sitting, number)
    earlier = [
        other
        for sitting, place, other in study.steps
        if isinstance(other, Block) and other.condition == ASSIGNED and (sitting, place) < here
    ]
    return attempt.condition(len(earlier))


def check_new_code(ledger: Ledger, code: str) -> None:
    """Check the code of a participant who is to be enrolled, before they read anything.

    Codes of earlier participants are taken as they are, so that they can go on.

    Raises:
        NotNow: it is no code, or differs from another participant's only in upper and lower case.
    """
    if reason := wrong_code(code):
        raise NotNow(reason)
    for other in progress(ledger.lines()).participants:
        if other.casefold() == code.casefold():
            raise NotNow(
                f"{other} takes part already, and {code} differs from it only in upper and lower case, which "
                f"some disks do not tell apart. Give --participant {other} to go on, or another code"
            )
