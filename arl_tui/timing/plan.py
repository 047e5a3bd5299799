"""What happens in a self-test, and what the app under test and the robot each saw of it."""

import re
from typing import Literal

import msgspec

Condition = Literal["bare reader", "at rest", "beside a board"]
CONDITIONS: dict[Condition, str] = {
    "bare reader": "a program of a few lines without any screen: what this machine adds to all times",
    "at rest": "nothing else moves",
    "beside a board": "a Tetris board at 30 fps, its agent learning in a process of its own",
}
ANSWER_KEY = "j"
MARKER = re.compile(rb"<<(\d{4})>>")
"""How the stimulus of a trial looks in the bytes that the terminal gets."""
SHORTEST_MS, LONGEST_MS = 150, 1000
"""Range of the robot's reaction times."""
TIME_OUT_S = 3.0
"""The app waits this long for an answer."""
GAP_S = 0.2
"""From an answer to the next foreperiod."""
SETTLE_S = 0.7
"""From the first paint to the first foreperiod."""

START_UP_S = 240.0
"""Compiling everything for the first time on a busy machine takes minutes."""


class PlannedTrial(msgspec.Struct, frozen=True, kw_only=True):
    """One stimulus and its answer."""

    number: int
    """0 to 9999."""
    foreperiod_ms: int
    delay_ms: int
    """The robot answers so long after it has read the stimulus."""


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """A condition and its trials."""

    condition: Condition
    root_seed: int
    trials: tuple[PlannedTrial, ...]

    @property
    def longest_s(self) -> float:
        """How long the trials take if nothing is answered at all."""
        return SETTLE_S + sum(GAP_S + TIME_OUT_S + trial.foreperiod_ms / 1000 for trial in self.trials)


class Answered(msgspec.Struct, frozen=True, kw_only=True):
    """A trial as the app saw it. Times in ns of the monotonic clock."""

    number: int
    flushed_ns: int | None
    """The onset: the stimulus had been passed to the terminal."""
    key_ns: int | None
    """The key message's own time; None where no key came in time."""


class Seen(msgspec.Struct, frozen=True, kw_only=True):
    """What the app saw of a whole condition."""

    answers: tuple[Answered, ...]
    board_frames: int
    """Pictures of the board that reached the terminal during the trials; 0 without a board."""
    duration_ns: int
    """From the first foreperiod to the last answer."""


def marker(number: int) -> str:
    """Return what a trial's stimulus looks like."""
    return f"<<{number:04d}>>"


def make_plan(condition: Condition, n_trials: int, *, root_seed: int, longest_ms: int = LONGEST_MS) -> Plan:
    """Draw foreperiods of 300 to 600 ms and delays of 150 to `longest_ms`.

    Args:
        condition: what else is on the screen.
        n_trials: 1 to 9999.
        root_seed: the same seed gives the same trials.
        longest_ms: longest delay, at least 150.
    """
    if not (1 <= n_trials <= 9999 and longest_ms >= SHORTEST_MS):
        raise ValueError(
            f"need 1 to 9999 trials and a longest delay from {SHORTEST_MS} ms, got {n_trials} and "
            f"{longest_ms}"
        )
    from core.numerics.streams import stream  # Numpy: a session's header only reads results.

    rng = stream(root_seed, "timing self-test", condition)
    foreperiods = rng.integers(300, 600, n_trials, endpoint=True)
    delays = rng.integers(SHORTEST_MS, longest_ms, n_trials, endpoint=True)
    trials = tuple(
        PlannedTrial(number=i, foreperiod_ms=int(f), delay_ms=int(d))
        for i, (f, d) in enumerate(zip(foreperiods, delays, strict=True))
    )
    return Plan(condition=condition, root_seed=root_seed, trials=trials)
