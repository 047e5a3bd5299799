"""Calibrations of a study: their tasks, and those of simulated participants."""

from pathlib import Path

import numpy as np

from arl_tui.calibration.fitting import FitOrder, fit_files
from arl_tui.calibration.plan import (
    PLANNED,
    CalibrationSetup,
    configure,
    new_parts,
    slug,
    task_names,
)
from arl_tui.recordings import CALIBRATION_FOLDER, new_path
from core.feedback.delays import Density, PerValueDelay
from core.feedback.trainers import draw_delay_s
from core.numerics.clock import NS_PER_S, wall_time_utc
from core.numerics.streams import stream
from studies.lab.config import Calibration
from studies.lab.read import LoadedStudy
from studies.reaction_time.protocol import Schedule, TaskConfig, TrialRecord
from studies.reaction_time.trial_log import TrialHeader, TrialWriter

SIMPLE_S = 0.3
"""Mean time of a simulated participant's simple reactions, seconds."""
TRIAL_NS = 6 * NS_PER_S


def calibration_configs(loaded: LoadedStudy, step: Calibration) -> tuple[TaskConfig, ...]:
    """Return the tasks of a calibration, at the pace of the study's sessions.

    Raises:
        ValueError: a task is unknown, or the study's game does not have it.
    """
    protocol = next(iter(loaded.protocols.values()))
    names = task_names(",".join(step.tasks))
    return configure(
        names, n_trials=step.trials, n_practice=step.practice, game=protocol.game, protocol=protocol
    )


def simulated_calibration(
    loaded: LoadedStudy, step: Calibration, *, code: str, folder: Path, seed: int, software: dict[str, str]
) -> tuple[tuple[str, ...], int]:
    """Leave trial files and fits as a participant does whose delays follow the protocol's `trainer.delay`.

    Returns:
        Names of the files in the participant's folder, and how long the trials took, nanoseconds.
    """
    delay = next(iter(loaded.protocols.values())).trainer.delay
    if isinstance(delay, PerValueDelay):
        delay = delay.for_value(1.0)  # a calibration asks for one answer, and nobody is in two minds
    setup = CalibrationSetup(
        participant=code, configs=calibration_configs(loaded, step), root_seed=seed, recordings=folder
    )
    paths, time_ns = [], 0
    for part in new_parts(setup):
        config = part.schedule.config
        created_utc = wall_time_utc()
        header = TrialHeader(
            participant=code,
            created_utc=created_utc,
            schedule=part.schedule,
            clock="simulated",
            facts=software | {PLANNED: setup.planned, "origin": "simulated"},
        )
        name = f"{code}-{slug(config)}"
        path = new_path(folder / CALIBRATION_FOLDER, name, created_utc)
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with TrialWriter.create(path, header) as writer:
            for record in _trials(part.schedule, delay, seed):
                writer.write(record)
        time_ns += len(part.schedule.trials) * TRIAL_NS
        paths.append(path)
    fit_files(FitOrder(recordings=str(folder), participant=code, files=tuple(map(str, paths))))
    return tuple(str(path.relative_to(folder)) for path in paths), time_ns


def _trials(schedule: Schedule, delay: Density, seed: int) -> list[TrialRecord]:
    config = schedule.config
    rng = stream(seed, f"simulated-{config.task}")
    judging = config.task == "feedback lag"
    records = []
    for plan in schedule.trials:
        time_s = (
            draw_delay_s(delay, rng=rng)
            if judging
            else float(np.clip(rng.gamma(9.0, SIMPLE_S / 9.0), 0.12, 1.4))
        )
        records.append(_record(schedule, plan.index, time_s))
    return records


def _record(schedule: Schedule, trial: int, time_s: float) -> TrialRecord:
    """Return a trial in which the right key came after `time_s`, or none where none should or it took too
    long.
    """
    plan, block, limit_s = schedule.trials[trial], schedule.block_of(trial), schedule.config.time_out_s
    onset_ns = (trial + 1) * TRIAL_NS
    answers = bool(plan.expected_keys) and not plan.catch and time_s < limit_s
    withheld = not plan.expected_keys or plan.catch
    return TrialRecord(
        trial=trial,
        block=block.index,
        task=schedule.config.task,
        practice=block.practice,
        catch=plan.catch,
        condition=plan.condition,
        stimulus=plan.stimulus,
        expected_keys=plan.expected_keys,
        foreperiod_s=plan.foreperiod_s,
        started_ns=onset_ns - round(plan.foreperiod_s * NS_PER_S),
        asked_ns=onset_ns,
        flushed_ns=None if plan.catch else onset_ns,
        key=plan.expected_keys[0] if answers else None,
        key_ns=onset_ns + round(time_s * NS_PER_S) if answers else None,
        rt_s=time_s if answers else None,
        status="ok" if answers or withheld else "time-out",
        early_presses=0,
        other_presses=0,
        frame_interval_ns=NS_PER_S // 30,
        time_out_s=limit_s,
        ended_ns=onset_ns + round(min(time_s, limit_s) * NS_PER_S),
    )
