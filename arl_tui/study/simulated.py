"""Simulated participants of a whole study: they press keys on the real pages, headless, and leave real files.

Sessions are played on the real screens, picture by picture (`arl_tui.study.drawn_session`), or computed
(`studies.demo`): the same learners, credit and recording, some fifty times as fast.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, assert_never

import numpy as np
from textual.pilot import Pilot
from textual.screen import Screen

from arl_tui.games.registry import words_of
from arl_tui.language import key_for
from arl_tui.recordings import new_path
from arl_tui.study.calibrations import simulated_calibration
from arl_tui.study.page_app import PageApp, Results
from arl_tui.study.pages import BreakPage, ConsentPage, StopPage, StudyPage
from arl_tui.study.presenter import BlockCall, OnResult, Pages, Played, do_nothing, ignore_result
from arl_tui.study.question_pages import QuestionPage
from core.feedback.simulated_participants import persons
from core.numerics.clock import NS_PER_S, ManualClock, wall_time_utc
from core.numerics.streams import stream
from core.recording.reader import read_recording
from core.session.protocol import Protocol
from studies.lab.config import Block, Calibration, Practice
from studies.lab.minutes import SECONDS_PER_QUESTION, WORDS_PER_MINUTE
from studies.lab.questions import Choice, FreeText, Likert, Number, Press, Question, Scale
from studies.lab.read import LoadedStudy

KINDS = tuple(persons())
"""Kinds of simulated participants, taken in turn."""
Drawn = Literal["once", "all", "none"]
"""Which blocks are played on the real screens: each block of a condition once, all, or none."""
Settle = Callable[[BlockCall, Block], tuple[Protocol, dict[str, str]]]
SIZE = (80, 24)
LATEST_PRESS = 400
"""A page that is not left after so many keys cannot be left at all."""


class ToDraw:
    """Says which sessions of a simulation are drawn."""

    def __init__(self, drawn: Drawn) -> None:
        self._drawn = drawn
        self._seen: set[tuple[str, str]] = set()

    def wants(self, call: BlockCall) -> bool:
        """Return whether a session is to be drawn; with "once", the same step and condition only once."""
        kind = (call.facts["step"], call.condition or "")
        new = kind not in self._seen
        self._seen.add(kind)
        return self._drawn == "all" or (self._drawn == "once" and new)


@dataclass(frozen=True, slots=True)
class Habits:
    """How one simulated participant behaves."""

    kind: str
    """One of `KINDS`: how they judge."""
    declines: bool = False
    """They do not consent."""


class StuckError(RuntimeError):
    """A page could not be left by keys: the study cannot be finished by a participant either."""


class SimulatedPresenter:
    """Presses keys on the real pages, and plays sessions with a simulated participant."""

    def __init__(
        self,
        loaded: LoadedStudy,
        habits: Habits,
        *,
        seed: int,
        clock: ManualClock,
        software: Mapping[str, str],
        settle: Settle | None = None,
        to_draw: ToDraw | None = None,
    ) -> None:
        """Prepare.

        Args:
            loaded: the study with this participant in it (`studies.lab.simulated_people.as_participant`).
            habits: of the participant.
            seed: of their answers.
            clock: of all times in the record; it moves on with every key.
            software: versions, for headers.
            settle: returns a block's protocol with its credit rule in numbers, and where that comes from; by
                default the simulated participant's own delay is known without a calibration.
            to_draw: says which sessions are played on the real screens; none by default.
        """
        self._loaded = loaded
        self._habits = habits
        self._clock = clock
        self._software = software
        self._settle: Settle = settle or (
            lambda call, step: (loaded.simulated_protocol(call.condition, step), {})
        )
        self._to_draw = to_draw or ToDraw("none")
        self._rng = stream(seed, "answers")
        self.on_gone: Callable[[], None] = do_nothing

    def pages(self, pages: Pages, on_result: OnResult = ignore_result) -> tuple[Results, bool]:
        """Go through the pages.

        Raises:
            StuckError: a page cannot be left by keys.
        """
        app = PageApp(pages, on_result, language=self._loaded.study.language)
        stuck: list[str] = []

        async def press(pilot: Pilot[object]) -> None:
            seen: set[Screen[object]] = set()
            for _ in range(LATEST_PRESS):
                if not app.is_running or len(app.results) == len(pages):
                    return
                screen = app.screen
                if screen not in seen:
                    seen.add(screen)
                    self._read(screen)
                for key in self._keys(screen) if isinstance(screen, StudyPage | StopPage) else ():
                    self._clock.advance_ns(NS_PER_S // 2)
                    await pilot.press(key)
                await pilot.pause()
                if app.results and app.results[-1] in (None, False):
                    return
            stuck.append(type(app.screen).__name__)
            app.exit(app.results)

        app.run(headless=True, size=SIZE, auto_pilot=press)
        if stuck:
            raise StuckError(f"a simulated participant could not leave a page of type {stuck[0]} by keys")
        return app.results, False

    def _read(self, screen: Screen[object]) -> None:
        """Take as long over a page as `arl study check` plans for a person."""
        if isinstance(screen, QuestionPage):
            self._clock.advance_ns(round(SECONDS_PER_QUESTION * NS_PER_S))
        elif isinstance(screen, StudyPage):
            words = len(screen.reading.split())
            self._clock.advance_ns(round(words / WORDS_PER_MINUTE * 60 * NS_PER_S))

    def _keys(self, screen: StudyPage | StopPage) -> list[str]:
        if isinstance(screen, StopPage):
            return [key_for("no")]
        if isinstance(screen, ConsentPage) and screen.at_end:
            return [key_for("no" if self._habits.declines else "yes")] * screen.n_statements + (
                ["enter", "enter"] if self._habits.declines else ["enter"]
            )
        if isinstance(screen, QuestionPage):
            answer = self._answer(screen.question)
            return answer if isinstance(screen.question, Press) else [*answer, "enter"]
        if isinstance(screen, BreakPage):
            self._clock.advance_ns(int(screen.shortest_s * NS_PER_S))
        return ["enter"]

    def _answer(self, question: Question) -> list[str]:
        match question:
            case Likert(points=points, correct=correct):
                return [str(correct or self._draw(1, min(points, 9)))]
            case Scale():
                return [("left", "right")[self._draw(0, 1)]] * self._draw(1, 10)
            case Choice(options=options, correct=correct):
                return [str(options.index(correct) + 1 if correct else self._draw(1, min(len(options), 9)))]
            case Number(lowest=lowest, highest=highest):
                return list(str(self._draw(int(np.ceil(lowest)), int(highest))))
            case Press(key=key):
                return [key]
            case FreeText():
                return list("simulated")
            case other:
                assert_never(other)

    def _draw(self, low: int, high: int) -> int:
        return int(self._rng.integers(low, high + 1))

    def play(self, call: BlockCall) -> Played:
        """Play a session with a simulated participant, or leave what they would leave of a calibration."""
        call.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        match call.step:
            case Block():
                protocol, source = self._settle(call, call.step)
                return self._play_games(call, protocol, source)
            case Practice():
                return self._play_games(call, self._loaded.practice_protocol(call.step), {})
            case Calibration():
                names, time_ns = simulated_calibration(
                    self._loaded,
                    call.step,
                    code=call.code,
                    folder=call.folder,
                    seed=call.seed,
                    software=dict(self._software),
                )
                self._clock.advance_ns(time_ns)
                return Played(how="finished", file=names[0], more_files=names[1:])
            case other:
                assert_never(other)

    def _play_games(self, call: BlockCall, protocol: Protocol, source: Mapping[str, str]) -> Played:
        from studies.demo import simulate_session, summarise  # here: compiled code comes with it

        if self._to_draw.wants(call):
            path = self._play_drawn(call, protocol, source)
        else:
            stem = f"{call.code}-sitting-{int(call.facts['sitting']) + 1}-step-{int(call.facts['step']) + 1}"
            path = new_path(call.folder, stem, wall_time_utc())
            simulate_session(
                protocol,
                call.seed,
                path,
                software=dict(self._software),
                participant=call.code,
                source=source,
                study=call.facts,
            )
        recording = read_recording(path)
        times = [getattr(event, "time_ns", 0) for event in recording.events]
        self._clock.advance_ns(max(0, max(times, default=0) - recording.header.started_ns))
        summary = summarise(recording)
        return Played(
            how="finished",
            file=path.name,
            games=tuple(summary.performances),
            presses=summary.accepted,
            unit=words_of(protocol.game).unit,
        )

    def _play_drawn(self, call: BlockCall, protocol: Protocol, source: Mapping[str, str]) -> Path:
        """Play a session on the real screens; return its recording."""
        from arl_tui.study.drawn_session import draw_session  # here: compiled code comes with it

        outcome = draw_session(
            protocol,
            call.seed,
            call.folder,
            participant=call.code,
            source=source,
            study=call.facts,
            practice=isinstance(call.step, Practice),
        )
        assert outcome.recording is not None, "`draw_session` refuses a session without one"
        return outcome.recording


def habits_of(number: int) -> Habits:
    """Return the habits of the simulated participant with this number, from 0: every kind in turn."""
    return Habits(KINDS[number % len(KINDS)])
