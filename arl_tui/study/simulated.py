"""Simulated participants of a whole study: they press keys on the real pages, headless, and leave real files.

Sessions are those of `studies.demo`: the same learners, credit and recorder as in a live session, with a simulated
participant in place of a person, as fast as the machine can. Nobody draws their games.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import assert_never

import msgspec
import numpy as np
from textual.pilot import Pilot

from arl_tui.games.registry import words_of
from arl_tui.study.page_app import PageApp, Results
from arl_tui.study.pages import BreakPage, ConsentPage, StopPage, StudyPage
from arl_tui.study.question_pages import QuestionPage
from arl_tui.study.run import BlockCall, OnResult, Pages, Played, ignore_result
from core.feedback.simulated_participants import persons
from core.numerics.clock import NS_PER_S, ManualClock
from core.numerics.streams import stream
from core.recording.reader import read_recording
from studies.lab.config import Block, Calibration, Practice
from studies.lab.questions import Choice, FreeText, Likert, Number, Question, Scale
from studies.lab.read import LoadedStudy

KINDS = tuple(persons())
"""Kinds of simulated participants, taken in turn."""
SIZE = (80, 24)
LATEST_PRESS = 400
"""A page that is not left after so many keys cannot be left at all."""


@dataclass(frozen=True, slots=True)
class Habits:
    """How one simulated participant behaves."""

    kind: str
    """One of `KINDS`: how they judge."""
    declines: bool = False
    """They do not consent."""


class StuckError(RuntimeError):
    """A page could not be left by keys: the study cannot be finished by a person either."""


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
    ) -> None:
        """Prepare.

        Args:
            loaded: the study.
            habits: of the participant.
            seed: of their answers.
            clock: of all times in the record; it moves on with every key.
            software: versions, for headers.
        """
        self._loaded = loaded
        self._habits = habits
        self._clock = clock
        self._software = software
        self._rng = stream(seed, "answers")

    def pages(self, pages: Pages, on_result: OnResult = ignore_result) -> tuple[Results, bool]:
        """Go through the pages.

        Raises:
            StuckError: a page cannot be left by keys.
        """
        app = PageApp(pages, on_result)
        stuck: list[str] = []

        async def press(pilot: Pilot[object]) -> None:
            for _ in range(LATEST_PRESS):
                if not app.is_running or len(app.results) == len(pages):
                    return
                screen = app.screen
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

    def _keys(self, screen: StudyPage | StopPage) -> list[str]:
        if isinstance(screen, StopPage):
            return ["n"]
        if isinstance(screen, ConsentPage) and screen.at_end:
            return ["n" if self._habits.declines else "y"] * screen.n_statements + (
                ["enter", "enter"] if self._habits.declines else ["enter"]
            )
        if isinstance(screen, QuestionPage):
            return [*self._answer(screen.question), "enter"]
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
            case FreeText():
                return list("simulated")
            case other:
                assert_never(other)

    def _draw(self, low: int, high: int) -> int:
        return int(self._rng.integers(low, high + 1))

    def play(self, call: BlockCall) -> Played:
        """Play a session with a simulated participant."""
        match call.step:
            case Block():
                return self._play_block(call)
            case Practice() | Calibration():
                raise NotImplementedError
            case other:
                assert_never(other)

    def _play_block(self, call: BlockCall) -> Played:
        assert isinstance(call.step, Block), "a block"
        protocol = self._loaded.simulated_protocol(call.condition, call.step)
        trainer = persons()[self._habits.kind]
        protocol = msgspec.structs.replace(
            protocol, trainer=msgspec.structs.replace(trainer, delay=protocol.trainer.delay)
        )
        call.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        path = call.folder / f"{call.code}-step-{call.facts['step']}-{call.facts['sitting']}.jsonl"
        from studies.demo import simulate_session, summarise  # compiled code comes with them

        simulate_session(
            protocol,
            call.seed,
            path,
            software=dict(self._software),
            participant=call.code,
            source={f"study.{name}": value for name, value in call.facts.items()},
        )
        summary = summarise(read_recording(path))
        return Played(
            how="finished",
            file=path.name,
            games=tuple(summary.performances),
            presses=summary.accepted,
            unit=words_of(protocol.game).units[1],
        )


def habits_of(number: int) -> Habits:
    """Return the habits of the simulated participant with this number, from 0: every kind in turn."""
    return Habits(KINDS[number % len(KINDS)])
