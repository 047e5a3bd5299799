"""Leads a participant through a sitting: every step in turn, everything recorded, from consent to thanks."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, assert_never

from textual.screen import Screen

from arl_tui.language import tr
from arl_tui.study import words
from arl_tui.study.own_numbers import Numbers, own_numbers
from arl_tui.study.page_app import Results
from arl_tui.study.pages import BreakPage, NoticePage, TextPage
from arl_tui.study.presenter import (
    BlockCall,
    How,
    OnResult,
    Pages,
    Played,
    Presenter,
    do_nothing,
    ignore_result,
)
from arl_tui.study.question_pages import Answered, QuestionPage
from arl_tui.study.steps import (
    ask_consent,
    block_of_visit,
    check_new_code,
    condition_of,
    consent_line,
    page_of,
    played_of,
    recorded_kind,
)
from core.numerics.clock import Clock, MonotonicClock, wall_time_utc
from core.recording.reader import RecordingError
from studies.lab.blocks import BlockSoFar, block_so_far
from studies.lab.config import (
    Block,
    Break,
    Calibration,
    Consent,
    Debriefing,
    Practice,
    Questionnaire,
    Step,
    kind_of,
)
from studies.lab.config import TextPage as TextStep
from studies.lab.enrolment import Attempt, Decision, NotNow, begin_sitting, enrol, session_seed
from studies.lab.folder import participant_folder, sitting_path
from studies.lab.ledger import Declined, Ledger, SittingEnded, StepDone
from studies.lab.progress import progress
from studies.lab.questions import passed
from studies.lab.read import LoadedStudy
from studies.lab.running import only_sitting
from studies.lab.sitting_log import (
    FileRecorded,
    QuestionAnswered,
    SittingHeader,
    SittingLine,
    SittingLog,
    StepBegun,
    StepEnded,
)


class _LeftEarly(Exception):
    """The participant, or the window, ended the sitting."""

    def __init__(self, how: How, trouble: str = "") -> None:
        super().__init__(how)
        self.how = how
        self.trouble = trouble


@dataclass(frozen=True, slots=True)
class SittingResult:
    """How a sitting went, for the experimenter."""

    how: Literal["finished", "stopped", "window-closed", "failed", "declined", "nothing"]
    """nothing: left before consent was given."""
    code: str
    trouble: str = ""
    remarks: tuple[str, ...] = ()
    """For the experimenter, where nothing failed."""


def run_sitting(
    loaded: LoadedStudy,
    ledger: Ledger,
    code: str,
    presenter: Presenter,
    *,
    software: Mapping[str, str],
    simulated: bool = False,
    clock: Clock | None = None,
    any_time: bool = False,
    decision: Decision | None = None,
) -> SittingResult:
    """Lead a participant through their next sitting.

    Args:
        loaded: the study.
        ledger: of the study.
        code: of the participant; a new one is enrolled after consent.
        presenter: shows pages and plays sessions.
        software: versions, for the record.
        simulated: the participant is simulated.
        clock: of the times in the record.
        any_time: do not ask how long ago the sitting before was.
        decision: of the experimenter about a sitting that broke off; None: the study's rule decides.

    Raises:
        NotNow: the participant cannot begin or go on now.
        LedgerError: the ledger cannot be used.
        OSError: the disk takes nothing.
    """
    time = clock or MonotonicClock()
    lines: list[SittingLine] = []
    if code not in progress(ledger.lines()).participants:
        if decision is not None:
            raise NotNow(f"{code} has no sitting that broke off: leave --broken-off out")
        check_new_code(ledger, code)
        before = ask_consent(loaded, code, presenter, time, lines)
        if before is not None:
            if before == "declined":
                ledger.append(Declined())
            return SittingResult(before, code)
        enrol(loaded.study, ledger, code, simulated=simulated)
    with only_sitting(participant_folder(ledger.folder, code), code):
        attempt = begin_sitting(
            loaded.study, ledger, code, any_time=any_time, decision=decision, sha256=loaded.sha256
        )
        return _Sitting(loaded, ledger, attempt, presenter, time, software, simulated=simulated).run(lines)


class _Sitting:
    """One attempt at one sitting of an enrolled participant."""

    def __init__(
        self,
        loaded: LoadedStudy,
        ledger: Ledger,
        attempt: Attempt,
        presenter: Presenter,
        clock: Clock,
        software: Mapping[str, str],
        *,
        simulated: bool,
    ) -> None:
        self._loaded = loaded
        self._study = loaded.study
        self._ledger = ledger
        self._attempt = attempt
        self._presenter = presenter
        self._clock = clock
        self._software = software
        self._simulated = simulated
        self._numbers = Numbers()
        self._folder = participant_folder(ledger.folder, attempt.code)
        self._remarks_for_experimenter: list[str] = []
        self._step = 0

    def run(self, lines_before: Sequence[SittingLine]) -> SittingResult:
        """Do the steps that are left; `lines_before` were earned before the participant had a place."""
        attempt, steps = self._attempt, self._study.sittings[self._attempt.sitting].steps
        path = sitting_path(self._ledger.folder, attempt.code, attempt.sitting, attempt.number)
        how: How = "finished"
        trouble = ""
        with SittingLog(path, self._header(), clock=self._clock) as log:
            self._presenter.on_gone = lambda: self._gone(log)
            done = -1
            for line in lines_before:
                log.write(line)
                if isinstance(line, StepEnded):
                    self._ledger.append(StepDone(code=attempt.code, sitting=attempt.sitting, step=line.step))
                    done = line.step
            try:
                if attempt.anew:
                    self._tell_anew()
                self._count_earlier(min(attempt.first_step, len(steps)))
                for number in range(max(attempt.first_step, done + 1), len(steps)):
                    self._do(log, number, steps[number])
            except _LeftEarly as left:
                how, trouble = left.how, left.trouble
            log.close(how)
            self._presenter.on_gone = do_nothing
        self._ledger.append(SittingEnded(code=attempt.code, sitting=attempt.sitting, how=how))
        if how == "stopped":
            self._say(tr(words.STOPPED, code=attempt.code))
        return SittingResult(how, attempt.code, trouble, tuple(self._remarks_for_experimenter))

    def _gone(self, log: SittingLog) -> None:
        """Write that the window was closed; the process ends in a moment."""
        log.write(StepEnded(step=self._step, time_ns=self._clock.now_ns(), how="window-closed"))
        log.close("window-closed")
        code, sitting = self._attempt.code, self._attempt.sitting
        self._ledger.append(SittingEnded(code=code, sitting=sitting, how="window-closed"))

    def _tell_anew(self) -> None:
        """Tell the participant, and the experimenter, that the sitting begins anew."""
        self._remarks_for_experimenter.append("the sitting began anew; what was recorded before is kept")
        self._pages([lambda: TextPage(tr(words.ANEW), code=self._attempt.code)])

    def _count_earlier(self, first_step: int) -> None:
        """Count the blocks that an earlier attempt at this sitting has finished, for the last page."""
        for number, step in enumerate(self._study.sittings[self._attempt.sitting].steps[:first_step]):
            if isinstance(step, Block) and (earlier := self._earlier(number)) is not None:
                self._count(played_of(earlier))

    def _count(self, played: Played) -> None:
        if played.games:
            self._numbers.blocks.append(played.games)
        self._numbers.presses += played.presses
        self._numbers.taken_back += played.taken_back
        self._numbers.unit = played.unit or self._numbers.unit

    def _earlier(self, number: int) -> BlockSoFar | None:
        """Return what an earlier attempt at this sitting has recorded of a block.

        Raises:
            _LeftEarly: a recording is damaged; the experimenter decides.
        """
        if not self._attempt.resumed:
            return None
        try:
            return block_so_far(self._folder, self._attempt.sitting, number, self._attempt.run)
        except (RecordingError, OSError) as error:
            raise _LeftEarly("failed", str(error)) from error

    def _header(self) -> SittingHeader:
        attempt = self._attempt
        return SittingHeader(
            study=self._study.name,
            study_version=self._study.version,
            study_sha256=self._loaded.sha256,
            participant=attempt.code,
            simulated=self._simulated,
            place=attempt.place,
            order=attempt.order,
            sitting=attempt.sitting,
            attempt=attempt.number,
            at_utc=wall_time_utc(),
            started_ns=self._clock.now_ns(),
            software=dict(self._software),
        )

    def _do(self, log: SittingLog, number: int, step: Step) -> None:
        """Do one step, and write that it is over.

        Raises:
            _LeftEarly: the participant stopped, the window was closed, or the step failed.
        """
        self._step = number
        log.write(StepBegun(step=number, kind=kind_of(step), time_ns=self._clock.now_ns()))
        try:
            self._show(log, number, step)
        except _LeftEarly as left:
            log.write(StepEnded(step=number, time_ns=self._clock.now_ns(), how=left.how))
            raise
        log.write(StepEnded(step=number, time_ns=self._clock.now_ns(), how="finished"))
        self._ledger.append(StepDone(code=self._attempt.code, sitting=self._attempt.sitting, step=number))

    def _show(self, log: SittingLog, number: int, step: Step) -> None:
        code, part = self._attempt.code, self._part(number)
        match step:
            case TextStep():
                self._pages([page_of(self._loaded, step, code, part)])
            case Consent():
                answers = self._pages([page_of(self._loaded, step, code, part)])[-1]
                log.write(consent_line(self._loaded, step, number, answers, self._clock))
            case Break(text=name, shortest_s=shortest_s, longest_s=longest_s):
                text = self._loaded.texts.get(name, "")
                self._pages(
                    [
                        lambda: BreakPage(
                            text,
                            shortest_s=shortest_s,
                            longest_s=longest_s,
                            code=code,
                            clock=self._clock,
                            part=part,
                        )
                    ]
                )
            case Questionnaire():
                self._ask(log, number, step)
            case Debriefing():
                text = self._loaded.texts[step.text]
                remarks = self._remarks(step)
                self._pages([lambda: NoticePage(tr(words.THANKS), text, remarks, code=code)])
            case Practice() | Calibration() | Block():
                self._play(log, number, step)
            case other:
                assert_never(other)

    def _part(self, number: int) -> str:
        count = len(self._study.sittings[self._attempt.sitting].steps)
        return tr(words.PART, number=number + 1, count=count)

    def _pages(self, pages: Pages, on_result: OnResult = ignore_result) -> Results:
        results, closed = self._presenter.pages(pages, on_result)
        if closed:
            raise _LeftEarly("window-closed")
        if len(results) < len(pages) or results[-1] is None or results[-1] is False:
            raise _LeftEarly("stopped")
        return results

    def _say(self, text: str) -> None:
        """Show a last page; nothing hangs on how it is left."""
        self._presenter.pages([lambda: NoticePage(tr(words.THANKS), "", [text], code=self._attempt.code)])

    def _ask(self, log: SittingLog, number: int, step: Questionnaire) -> None:
        """Ask every question in turn; each answer is on the disk before the next question comes."""
        asked = self._loaded.questionnaires[step.questions]
        code, clock, count = self._attempt.code, self._clock, len(asked.questions)
        if asked.introduction or asked.title:
            intro = f"# {asked.title}\n\n{asked.introduction}"
            self._pages([lambda: TextPage(intro, code=code, part=self._part(number))])

        def page(place: int) -> Callable[[], Screen[object]]:
            question = asked.questions[place]
            return lambda: QuestionPage(question, number=place + 1, count=count, code=code, clock=clock)

        def write(place: int, result: object) -> None:
            if isinstance(result, Answered):
                question = asked.questions[place]
                log.write(
                    QuestionAnswered(
                        step=number,
                        questionnaire=asked.name,
                        question=question.id,
                        answer=result.answer,
                        shown_ns=result.shown_ns,
                        answered_ns=result.answered_ns,
                        passed=passed(question, result.answer),
                    )
                )

        self._pages([page(place) for place in range(count)], write)

    def _play(self, log: SittingLog, number: int, step: Block | Practice | Calibration) -> None:
        condition = condition_of(self._study, self._attempt, number, step)
        earlier = self._earlier(number) if isinstance(step, Block) else None
        if earlier is not None and earlier.finished:
            played = played_of(earlier)  # the program was killed between the last game and the ledger's line
        else:
            played = self._presenter.play(self._call(number, step, condition, earlier))
        for name in (played.file, *played.more_files):
            if name:
                log.write(
                    FileRecorded(
                        step=number,
                        kind=recorded_kind(step),
                        file=name,
                        condition=condition,
                        ended=played.how,
                    )
                )
        if isinstance(step, Block):
            self._count(played)
        if played.remark:
            self._remarks_for_experimenter.append(played.remark)
        if played.how != "finished":
            raise _LeftEarly(played.how, played.trouble)

    def _call(
        self, number: int, step: Block | Practice | Calibration, condition: str, earlier: BlockSoFar | None
    ) -> BlockCall:
        attempt = self._attempt
        has_games = earlier is not None and earlier.summary.games_finished > 0
        return BlockCall(
            step=step,
            condition=condition,
            code=attempt.code,
            folder=self._folder,
            seed=session_seed(self._study, attempt, number),
            resume=earlier.path if earlier is not None and has_games else None,
            part=block_of_visit(self._study.sittings[attempt.sitting].steps, number),
            on_gone=self._presenter.on_gone,
            facts={
                "study": self._study.name,
                "study_version": self._study.version,
                "study_sha256": self._loaded.sha256,
                "place": str(attempt.place),
                "order": " ".join(attempt.order),
                "sitting": str(attempt.sitting),
                "step": str(number),
                "run": str(attempt.run),
                "kind": recorded_kind(step),
                "condition": condition,
            },
        )

    def _remarks(self, step: Debriefing) -> list[str]:
        remarks = list(own_numbers(self._numbers)) if step.own_numbers else []
        if step.show_condition:
            remarks.append(tr(words.ORDER, order=", ".join(self._attempt.order)))
        return [*remarks, tr(words.CODE, code=self._attempt.code)]
