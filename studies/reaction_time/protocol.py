"""What a reaction-time session consists of, and what is recorded: plain data, no screen, no clock.

Seven tasks share one schedule: blocks of trials, each a foreperiod, a stimulus and the keys that answer it.
All fields are written to the recording; a schedule is made from configuration and seed alone (`schedule.py`).
"""

from typing import Literal

import msgspec

Task = Literal[
    "simple", "choice", "go/no-go", "memory search", "visual search", "recognition", "feedback lag"
]
Status = Literal["ok", "anticipation", "time-out", "wrong key", "repeat"]
RESPONSE_KEYS = ("f", "j", "space")
"""Keys a task may ask for. Escape, arrows, digits and modifiers occur in terminals' own replies or come
late."""
YES, NO = "j", "f"
"""Present, old, good; absent, new, bad. The right hand says yes."""


class Foreperiod(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Time from trial start to stimulus: a constant plus a truncated exponential.

    The exponential does not age: having waited tells nothing about how much longer it will take, until the
    truncation. A uniform foreperiod would make late stimuli expected, hence faster.
    """

    least_s: float = 1.0
    """Shortest foreperiod, seconds (Deary & Liewald: 1 to 3 s)."""
    mean_extra_s: float = 0.8
    """Mean of the exponential before truncation, seconds."""
    most_s: float = 4.0
    """Longest foreperiod, seconds."""

    def __post_init__(self) -> None:
        if not 0.0 < self.least_s < self.most_s or not self.mean_extra_s > 0.0:
            raise ValueError(
                f"foreperiod: need 0 < least_s < most_s and mean_extra_s > 0, got {self.least_s}, "
                f"{self.most_s} and {self.mean_extra_s} s"
            )


class TaskConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One task of a session. Defaults make 8 practice and 40 scored trials: about 3 minutes."""

    task: Task = "simple"
    n_practice: int = 8
    """Practice trials, a block of their own (Deary & Liewald: 8)."""
    n_trials: int = 40
    """Scored trials, catch trials included."""
    trials_per_block: int = 20
    """A break is offered after each block."""
    foreperiod: Foreperiod = Foreperiod()
    catch_rate: float = 0.1
    """Fraction of trials without a stimulus: a press there is a guess, not a reaction. Not in
    go/no-go."""
    time_out_s: float = 2.0
    """Longest wait for a response, seconds; the trial is then right-censored."""
    least_rt_s: float = 0.1
    """A faster response is an anticipation (no simple reaction is faster than 0.10 to 0.15 s)."""
    set_sizes: tuple[int, ...] = ()
    """Items to remember (memory search) or to look through (visual search); () takes the task's own."""
    go_rate: float = 0.75
    """Fraction of go stimuli in go/no-go."""
    n_studied: int = 16
    """Words studied before a recognition block."""
    study_item_s: float = 1.0
    """Time each studied word or remembered item is shown, seconds."""
    game: str = "tetris"
    """Game watched in the feedback-lag task."""
    picture_ms: float | None = None
    """How long a picture of the watched game is on screen, milliseconds: a tick of Tetris, a cycle of
    Keepaway. None: the default session's pace (in files written before this was a setting: 150 and 100)."""

    def __post_init__(self) -> None:
        problems = [
            (self.n_practice >= 0 and self.n_trials >= 1, "n_practice >= 0 and n_trials >= 1"),
            (self.trials_per_block >= 1, "trials_per_block >= 1"),
            (0.0 <= self.catch_rate <= 0.5, "catch_rate in [0, 0.5]"),
            (0.0 < self.go_rate < 1.0, "go_rate in (0, 1)"),
            (0.0 < self.least_rt_s < self.time_out_s, "0 < least_rt_s < time_out_s"),
            (all(1 <= size <= 16 for size in self.set_sizes), "set sizes from 1 to 16"),
            (self.picture_ms is None or 10.0 <= self.picture_ms <= 2000.0, "picture_ms in [10, 2000]"),
            (1 <= self.n_studied <= 24 and self.study_item_s > 0.0, "n_studied in 1..24, study_item_s > 0"),
        ]
        broken = [rule for holds, rule in problems if not holds]
        if broken:
            raise ValueError(f"task {self.task!r}: expected {'; '.join(broken)}, got {self}")


class TrialPlan(msgspec.Struct, frozen=True, kw_only=True):
    """One trial as it will be run."""

    index: int
    """Position in the session, from 0."""
    foreperiod_s: float
    stimulus: str
    """What is shown (lines joined by newlines), or the event waited for in the feedback-lag task; "" in a
    catch."""
    condition: str
    """What the trial tests, e.g. "go", "absent, set size 4"."""
    expected_keys: tuple[str, ...]
    """Keys that answer rightly; () where withholding is right."""
    study_items: tuple[str, ...] = ()
    """Items shown one after another before the foreperiod."""
    catch: bool = False


class BlockPlan(msgspec.Struct, frozen=True, kw_only=True):
    """Trials between two breaks."""

    index: int
    practice: bool
    trials: tuple[TrialPlan, ...]
    study_items: tuple[str, ...] = ()
    """Words studied at the start of the block (recognition)."""


class Schedule(msgspec.Struct, frozen=True, kw_only=True):
    """Everything that will happen, in order."""

    config: TaskConfig
    root_seed: int
    allowed_keys: tuple[str, ...]
    """Keys that count as a response in this task; others are counted apart and change nothing."""
    blocks: tuple[BlockPlan, ...]

    @property
    def trials(self) -> tuple[TrialPlan, ...]:
        """All trials in order."""
        return tuple(trial for block in self.blocks for trial in block.trials)

    def block_of(self, trial: int) -> BlockPlan:
        """Return the block that holds the trial with this index."""
        for block in self.blocks:
            if block.trials and block.trials[0].index <= trial <= block.trials[-1].index:
                return block
        raise IndexError(f"trial {trial}: the schedule has trials 0 to {len(self.trials) - 1}")


class TrialRecord(msgspec.Struct, frozen=True, kw_only=True):
    """One trial as it was. Raw: nothing is ever left out or corrected here."""

    trial: int
    block: int
    task: Task
    practice: bool
    catch: bool
    condition: str
    stimulus: str
    expected_keys: tuple[str, ...]
    foreperiod_s: float
    """As planned, seconds."""
    started_ns: int
    """When the foreperiod began; all `_ns` fields are on the header's clock."""
    asked_ns: int | None
    """When the stimulus was asked for; in a catch trial, when it would have been."""
    flushed_ns: int | None
    """When its frame was flushed to the terminal: the onset. None in catch trials."""
    key: str | None
    """The first allowed key at or after the onset; None without one."""
    key_ns: int | None
    """The key message's own time."""
    rt_s: float | None
    """key_ns - flushed_ns in seconds (catch: from asked_ns); None without a key."""
    status: Status
    """"ok" includes a withheld response where withholding is right."""
    early_presses: int
    """Allowed keys between trial start and onset."""
    other_presses: int
    """Keys outside the allow-list during the trial."""
    frame_interval_ns: int | None
    """From the frame before to the onset's frame."""
    time_out_s: float
    ended_ns: int
    comment: str = ""
