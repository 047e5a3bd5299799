"""What the self-test found: measured minus true reaction times, in milliseconds."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from arl_tui.timing.plan import CONDITIONS, Condition, Plan, Seen

if TYPE_CHECKING:
    from arl_tui.timing.robot import RobotTrial

LATE_MS = 5.0
"""A robot that read the stimulus later than this after its flush is counted apart: the kernel held the bytes
up."""
NS_PER_MS = 1e6


class TimedTrial(msgspec.Struct, frozen=True, kw_only=True):
    """One answered trial, seen from both ends."""

    number: int
    true_ms: float
    """From the robot's read to its write."""
    error_ms: float
    """Measured minus true: (key time - flush) - (write - read)."""
    read_late_ms: float
    """From the flush to the robot's read; part of `error_ms`."""

    @property
    def late(self) -> bool:
        """True where the bytes were held up between the two."""
        return self.read_late_ms > LATE_MS


class Summary(msgspec.Struct, frozen=True, kw_only=True):
    """Errors in milliseconds."""

    n: int
    bias: float
    """Mean."""
    sd: float
    """With n - 1; 0 for a single trial."""
    median: float
    p95: float
    p99: float


class ConditionResult(msgspec.Struct, frozen=True, kw_only=True, rename={"condition": "scene"}):
    """One condition."""

    condition: Condition
    n_trials: int
    n_missed: int
    """Trials without an answer or without a flush stamp."""
    on_time: Summary | None
    """Trials whose bytes the robot read in time; None where there are none."""
    on_the_way: Summary | None
    """Flush to read in the trials that were read in time: the part of the error that the pseudo-terminal
    makes."""
    late: Summary | None
    """Trials whose bytes it read more than `LATE_MS` after the flush."""
    board_fps: float
    """Pictures of the board per second that reached the terminal; 0 without a board."""
    trials: tuple[TimedTrial, ...]


class TimingResult(msgspec.Struct, frozen=True, kw_only=True, rename={"conditions": "scenes"}):
    """The whole self-test: what `arl timing --json` writes."""

    format: str = "arl-timing"
    version: int = 1
    created_utc: str
    root_seed: int
    cores: int
    load: float
    """Load average of the last minute, at the end of the test."""
    software: dict[str, str]
    machine: str = ""
    """See `arl_tui.timing.kept.machine_code`."""
    terminal: dict[str, str] = {}
    """Where the command was run; see `arl_tui.app.facts.terminal`."""
    waking: Summary | None = None
    """By how much plain sleeps ended late beside the conditions; see `arl_tui.timing.waking`."""
    conditions: tuple[ConditionResult, ...]


def summarise(errors_ms: Sequence[float]) -> Summary | None:
    """Return the summary of some errors; None of none."""
    if not errors_ms:
        return None
    import numpy as np  # A session's header only reads results, and must not wait for this.

    values = np.array(errors_ms)
    median, p95, p99 = (float(q) for q in np.percentile(values, [50, 95, 99]))
    sd = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Summary(n=len(values), bias=float(values.mean()), sd=sd, median=median, p95=p95, p99=p99)


def compare(plan: Plan, robot: "Sequence[RobotTrial]", seen: Seen) -> ConditionResult:
    """Set both ends of a condition against each other."""
    answers = {answer.number: answer for answer in seen.answers}
    trials = []
    for done in robot:
        answer = answers.get(done.number)
        if answer is None or answer.flushed_ns is None or answer.key_ns is None:
            continue
        true_ns = done.written_ns - done.read_ns
        trials.append(
            TimedTrial(
                number=done.number,
                true_ms=true_ns / NS_PER_MS,
                error_ms=(answer.key_ns - answer.flushed_ns - true_ns) / NS_PER_MS,
                read_late_ms=(done.read_ns - answer.flushed_ns) / NS_PER_MS,
            )
        )
    return ConditionResult(
        condition=plan.condition,
        n_trials=len(plan.trials),
        n_missed=len(plan.trials) - len(trials),
        on_time=summarise([trial.error_ms for trial in trials if not trial.late]),
        on_the_way=summarise([trial.read_late_ms for trial in trials if not trial.late]),
        late=summarise([trial.error_ms for trial in trials if trial.late]),
        board_fps=seen.board_frames / (seen.duration_ns / 1e9),
        trials=tuple(trials),
    )


def read_timing(path: Path) -> TimingResult:
    """Read what `arl timing --json` wrote.

    Raises:
        ValueError: it is something else; the message names the file.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=TimingResult)
    except msgspec.MsgspecError as error:
        raise ValueError(f"{path}: not a result of `arl timing`: {error}") from error


def header_facts(result: TimingResult) -> dict[str, str]:
    """Return the result as facts for the header of a session (`TrialHeader.facts`)."""
    facts = {"timing_utc": result.created_utc, "timing_load": f"{result.load:.1f} on {result.cores} cores"}
    if result.waking is not None:
        facts["timing_waking"] = _short(result.waking)
    for condition in result.conditions:
        name = f"timing_{condition.condition.replace(' ', '_')}"
        facts[name] = "no usable trial" if condition.on_time is None else _short(condition.on_time)
        if condition.late is not None:
            facts[f"{name}_read_late"] = _short(condition.late)
    return facts


def _short(summary: Summary) -> str:
    return (
        f"n {summary.n}, error ms: bias {summary.bias:.2f}, sd {summary.sd:.2f}, median "
        f"{summary.median:.2f}, "
        f"p95 {summary.p95:.2f}, p99 {summary.p99:.2f}"
    )


def condition_lines(condition: ConditionResult) -> list[str]:
    """Return a condition's rows of the table whose head is `TABLE_HEAD`."""
    lines = [_row(condition.condition, condition.on_time)]
    if condition.on_the_way is not None:
        lines.append(_row("  of it on the way out", condition.on_the_way))
    if condition.late is not None:
        lines.append(_row(f"  read late (> {LATE_MS:g} ms)", condition.late))
    if condition.n_missed:
        lines.append(f"  {condition.n_missed} of {condition.n_trials} trials without an answer or a stamp")
    setting = CONDITIONS[condition.condition]
    lines.append(f"  ({setting}{f'; {condition.board_fps:.1f} fps here' if condition.board_fps else ''})")
    return lines


TABLE_HEAD = f"{'condition':<24}{'trials':>7}{'bias':>8}{'sd':>8}{'median':>8}{'p95':>8}{'p99':>8}"


def _row(name: str, summary: Summary | None) -> str:
    if summary is None:
        return f"{name:<24}{0:>7}"
    figures = (summary.bias, summary.sd, summary.median, summary.p95, summary.p99)
    return f"{name:<24}{summary.n:>7}" + "".join(f"{value:>8.2f}" for value in figures)
