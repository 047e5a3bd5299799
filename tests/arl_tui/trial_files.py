"""Trial files as a calibration leaves them, written without one."""

from pathlib import Path

from arl_tui.calibration.plan import PLANNED
from core.numerics.streams import stream
from studies.reaction_time.protocol import Schedule, TrialRecord
from studies.reaction_time.trial_log import TrialHeader, TrialWriter


def record_of(schedule: Schedule, trial: int, rt_s: float | None, **changes) -> TrialRecord:
    plan, block = schedule.trials[trial], schedule.block_of(trial)
    onset = trial * 10**10
    given = {
        "trial": trial,
        "block": block.index,
        "task": schedule.config.task,
        "practice": block.practice,
        "catch": plan.catch,
        "condition": plan.condition,
        "stimulus": plan.stimulus,
        "expected_keys": plan.expected_keys,
        "foreperiod_s": plan.foreperiod_s,
        "started_ns": onset - 10**9,
        "asked_ns": onset,
        "flushed_ns": onset,
        "key": None if rt_s is None else plan.expected_keys[0],
        "key_ns": None if rt_s is None else onset + round(rt_s * 1e9),
        "rt_s": rt_s,
        "status": "time-out" if rt_s is None else "ok",
        "early_presses": 0,
        "other_presses": 0,
        "frame_interval_ns": 10**7,
        "time_out_s": schedule.config.time_out_s,
        "ended_ns": onset + 2 * 10**9,
    }
    return TrialRecord(**{**given, **changes})


def write_session(
    folder: Path,
    participant: str,
    schedule: Schedule,
    times_s: list[float],
    *,
    planned: str = "simple",
    created: str = "2026-11-22T08:00:00+00:00",
) -> Path:
    """Write a session whose first trials have these times."""
    stamp = created[:19].replace("-", "").replace(":", "") + "Z"
    path = folder / "calibration" / f"{participant}-{planned.split(',')[0]}-{stamp}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    header = TrialHeader(
        participant=participant, created_utc=created, schedule=schedule, facts={PLANNED: planned}
    )
    with TrialWriter.create(path, header) as writer:
        for trial, rt_s in enumerate(times_s):
            writer.write(record_of(schedule, trial, rt_s))
    return path


def judgements(person: int, n: int, mean_s: float) -> list[float]:
    """Return times of a person who judges in `mean_s` on average."""
    shape = 12.0
    return [float(t) for t in 0.1 + stream(7, "people", person).gamma(shape, (mean_s - 0.1) / shape, size=n)]
