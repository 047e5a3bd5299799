"""What a study will ask of participants before the first one comes: minutes, presses, orders, and what is
missing.
"""

import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import assert_never

from core.events import SessionEnded
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream_seed
from core.recording.reader import read_recording
from studies.demo import simulate_session, summarise
from studies.lab.config import (
    ASSIGNED,
    Block,
    Break,
    Calibration,
    Consent,
    Debriefing,
    Practice,
    Questionnaire,
    Step,
    TextPage,
    kind_of,
)
from studies.lab.minutes import SECONDS_PER_QUESTION, WORDS_PER_MINUTE
from studies.lab.orders import Order, order_of, orders_per_cycle
from studies.lab.read import LoadedStudy
from studies.lab.simulated_people import as_participant, chances_per_game, settings_without_effect

TRIAL_S = 6.0
"""One trial of a calibration, with what lies between trials."""
GAME_OF_PRACTICE_S = 60.0
PLACEHOLDER = re.compile(r"\[[A-ZÄÖÜ][A-ZÄÖÜß\s,.'-]+\]")
"""What a ready text leaves to the experimenter, such as [NAME OF THE INSTITUTION]."""


@dataclass(frozen=True, slots=True)
class BlockForecast:
    """What a block of one condition is like, from simulated sessions."""

    condition: str
    games: int
    minutes: float
    presses: float
    """Accepted presses of a simulated participant."""


@dataclass(frozen=True, slots=True)
class StepForecast:
    """How long one step takes."""

    sitting: int
    step: int
    kind: str
    minutes: float
    """Without the participant's own pauses."""
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Forecast:
    """A study before its first participant."""

    steps: tuple[StepForecast, ...]
    blocks: tuple[BlockForecast, ...]
    orders: tuple[Order, ...]
    """One per planned participant."""
    missing: tuple[str, ...]
    """What is still to be done, a sentence each."""

    def minutes(self, sitting: int) -> float:
        """Return how long a sitting takes."""
        return sum(step.minutes for step in self.steps if step.sitting == sitting)


def forecast(loaded: LoadedStudy, *, sessions: int = 2) -> Forecast:
    """Return what a study will be like.

    Args:
        loaded: the study.
        sessions: simulated sessions per condition, >= 1.
    """
    played = as_participant(loaded, "expert", chances_per_game(loaded))
    blocks = {name: _block(played, name, sessions) for name in loaded.protocols}
    longest = max(blocks.values(), key=lambda block: block.minutes)
    steps = tuple(
        StepForecast(sitting, place, kind_of(step), *_duration(loaded, step, blocks, longest))
        for sitting, place, step in loaded.study.steps
    )
    orders = tuple(order_of(loaded.study, place) for place in range(loaded.study.participants))
    return Forecast(steps, tuple(blocks.values()), orders, tuple(_missing(loaded)))


def _block(loaded: LoadedStudy, condition: str, sessions: int) -> BlockForecast:
    """Play simulated sessions of a condition; their times are those that would be on screen."""
    protocol = loaded.simulated_protocol(condition, Block())
    minutes, presses = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(sessions):
            path = Path(folder) / f"{number}.jsonl"
            seed = stream_seed(loaded.study.seed, "forecast", condition, number)
            recording = read_recording(simulate_session(protocol, seed, path, software={}))
            end = recording.events[-1]
            assert isinstance(end, SessionEnded), "a simulated session ends by itself"
            minutes += (end.time_ns - recording.header.started_ns) / NS_PER_S / 60
            presses += summarise(recording).accepted
    return BlockForecast(condition, protocol.session.episodes, minutes / sessions, presses / sessions)


def _duration(
    loaded: LoadedStudy, step: Step, blocks: dict[str, BlockForecast], longest: BlockForecast
) -> tuple[float, str]:
    match step:
        case Consent(text=text) | TextPage(text=text) | Debriefing(text=text):
            return len(loaded.texts[text].split()) / WORDS_PER_MINUTE, ""
        case Practice(games=games):
            return games * GAME_OF_PRACTICE_S / 60, "at most"
        case Calibration(tasks=tasks, trials=trials, practice=practice):
            return len(tasks) * (trials + practice) * TRIAL_S / 60, ""
        case Break(shortest_s=shortest_s):
            return shortest_s / 60, "at least"
        case Questionnaire(questions=name):
            return len(loaded.questionnaires[name].questions) * SECONDS_PER_QUESTION / 60, ""
        case Block(condition=condition, games=games):
            block = longest if condition == ASSIGNED else blocks[condition]
            fraction = 1.0 if games is None else games / block.games
            return block.minutes * fraction, "longest condition" if condition == ASSIGNED else ""
        case other:
            assert_never(other)


def _missing(loaded: LoadedStudy) -> Iterator[str]:
    """Yield what the experimenter still has to do."""
    for name, text in loaded.texts.items():
        if not text.strip():
            yield f"{name} is empty: write what participants are to read"
        left = sorted({" ".join(found.split()) for found in PLACEHOLDER.findall(text)})
        if left:
            yield f"{name} still holds {', '.join(left)}: replace it"
    kinds = [(where, step) for *where, step in loaded.study.steps]
    calibrated = min((where for where, step in kinds if isinstance(step, Calibration)), default=None)
    for where, step in kinds:
        if isinstance(step, Block):
            names = list(loaded.protocols) if step.condition == ASSIGNED else [step.condition]
            own = [name for name in names if loaded.protocols[name].delay_of not in ("rule", "paper")]
            if own and (calibrated is None or calibrated > where):
                yield (
                    f"step {where[1] + 1} of sitting {where[0] + 1} credits presses by the participant's own "
                    f"delay ({', '.join(own)}), and no calibration comes before it: add a step of type "
                    "calibration"
                )
    if without_effect := settings_without_effect(loaded):
        yield (
            f"[trainer] {', '.join(without_effect)} has no effect in a study, whose simulated participants "
            "are of all kinds: take it out. [simulated] says how often they press"
        )
    if not any(isinstance(step, Debriefing) for _, step in kinds):
        yield "no step of type debriefing: participants never learn what the study is about"
    cycle = orders_per_cycle(loaded.study)
    if loaded.study.participants % cycle:
        yield (
            f"{loaded.study.participants} participants cannot be balanced over {cycle} orders: plan a "
            f"multiple of {cycle}"
        )
