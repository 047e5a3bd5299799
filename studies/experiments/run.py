"""Plays what an experiment still lacks: one unit of work is one trial of one condition, and one file.

A file is written whole or not at all, so a run that was killed goes on where it stopped. Units go to any
`concurrent.futures.Executor`; what they return does not depend on which.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from core.recording.version_1 import with_schedules
from studies.experiments.sweep import Condition, Experiment, describe_settings, run_unit
from studies.experiments.trial_file import Played, read_trials, seal_of, seal_path

SWEEP_FILE = "sweep.json"


class SweepError(RuntimeError):
    """A folder cannot be used for this sweep; the message says why and what to do."""


@dataclass(frozen=True, slots=True)
class Unit:
    """One trial of one condition."""

    condition: str
    root_seed: int

    def path(self, folder: Path) -> Path:
        """Return its file below the sweep's folder."""
        return folder / self.condition / f"seed-{self.root_seed:07d}.csv"


class SweepRecord(msgspec.Struct, frozen=True, kw_only=True):
    """What `sweep.json` says: what is in the folder."""

    experiment: str
    quick: bool
    conditions: dict[str, Any]
    """Settings of each condition that was ever asked for, by name."""
    software: list[dict[str, str]]
    """Versions of each program that added units, in order."""


def planned_units(conditions: Sequence[Condition], seeds: Iterable[int]) -> list[Unit]:
    """Return all units, trial by trial, so that a run cut short has the same trials of every condition."""
    return [Unit(condition.name, seed) for seed in seeds for condition in conditions]


def run_sweep(
    experiment: Experiment,
    seeds: Sequence[int],
    folder: Path,
    executor: Executor,
    *,
    quick: bool = False,
    only: Sequence[str] = (),
    software: dict[str, str] | None = None,
    on_progress: Callable[[int, int], None] = lambda done, planned: None,
    on_damaged: Callable[[Path, str], None] = lambda path, reason: None,
) -> list[Path]:
    """Play every unit that has no file yet, or a damaged one.

    Args:
        experiment: what to run.
        seeds: root seeds of the trials.
        folder: of this experiment's results; made if missing.
        executor: where units are played; as many at once as it takes.
        quick: play the smoke-test versions.
        only: names of conditions; all where empty.
        software: versions, for `sweep.json`.
        on_progress: called with (units done, units planned), first before any is played.
        on_damaged: called with each damaged file and the reason, before it is played again.

    Returns:
        The files of all planned units.

    Raises:
        SweepError: the folder holds results of other settings.
    """
    conditions = [experiment.condition(name) for name in only] if only else list(experiment.conditions)
    folder.mkdir(parents=True, exist_ok=True)
    _note_sweep(folder, experiment, conditions, quick, software or {})
    units = planned_units(conditions, seeds)
    played = {name: Played(plain, quick) for name, plain in describe_settings(conditions).items()}
    missing = _without_result(units, folder, played, on_damaged)
    done = len(units) - len(missing)
    on_progress(done, len(units))
    for unit, text in _played(experiment.source or experiment.name, missing, quick, executor):
        path = unit.path(folder)
        write_whole(seal_path(path), seal_of(path, text.encode(), played[unit.condition]))
        write_whole(path, text)
        done += 1
        on_progress(done, len(units))
    return [unit.path(folder) for unit in units]


def _without_result(
    units: Sequence[Unit],
    folder: Path,
    played: Mapping[str, Played],
    on_damaged: Callable[[Path, str], None],
) -> list[Unit]:
    """Return the units that have no file, or one that cannot be used."""
    missing = {unit for unit in units if not unit.path(folder).exists()}
    for condition, how in played.items():
        there = {u.path(folder): u for u in units if u.condition == condition and u not in missing}
        for path, reason in read_trials(there, how)[1].items():
            if path.is_dir() or seal_path(path).is_dir():
                raise SweepError(
                    f"{path} or its seal is a folder, and no file can be written there: remove it"
                )
            on_damaged(path, reason)
            missing.add(there[path])
    return [unit for unit in units if unit in missing]


def _played(name: str, units: Sequence[Unit], quick: bool, executor: Executor) -> Iterator[tuple[Unit, str]]:
    """Yield each unit with its rows as soon as it is done; an error stops the rest."""
    waiting: dict[Future[str], Unit] = {
        executor.submit(run_unit, name, unit.condition, unit.root_seed, quick): unit for unit in units
    }
    try:
        while waiting:
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                yield waiting.pop(future), future.result()
    finally:
        for future in waiting:
            future.cancel()


def write_whole(path: Path, text: str) -> None:
    """Write a file so that it is there completely or not at all, also after a crash."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    with part.open("w", encoding="utf-8", newline="\n") as out:
        out.write(text)
        out.flush()
        os.fsync(out.fileno())
    part.replace(path)


@contextmanager
def dask_cluster(address: str, *, timeout_s: float = 10.0) -> Iterator[Executor]:
    """Run units on an existing Dask cluster.

    Args:
        address: of its scheduler, as "tcp://10.0.0.1:8786". Its workers need the same version of this
            program.
        timeout_s: how long to wait for its answer.

    Raises:
        SweepError: Dask is not installed, or nobody answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise SweepError("a cluster needs Dask: pip install 'arl-tui[cluster]'") from error
    try:
        client = Client(address, timeout=timeout_s)
    except OSError as error:
        raise SweepError(f"no Dask scheduler answers at {address}: {error}") from error
    with client:
        yield client.get_executor(pure=False)


def read_record(folder: Path) -> SweepRecord | None:
    """Return what a folder says it holds; None where it says nothing."""
    path = folder / SWEEP_FILE
    if not path.exists():
        return None
    try:
        return msgspec.json.decode(path.read_bytes(), type=SweepRecord)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise SweepError(
            f"{path} is not a sweep's record: {error}. Take it from a backup, or choose another --out"
        ) from error


def _note_sweep(
    folder: Path,
    experiment: Experiment,
    conditions: Sequence[Condition],
    quick: bool,
    software: dict[str, str],
) -> None:
    """Write what the folder is going to hold; refuse a folder that holds something else."""
    settings = describe_settings(conditions)
    record = read_record(folder)
    if record is None:
        record = SweepRecord(experiment=experiment.name, quick=quick, conditions={}, software=[])
    elif record.experiment != experiment.name or record.quick != quick:
        what = f"{'quick ' * record.quick}{record.experiment}"
        raise SweepError(f"{folder} holds results of {what}: choose another folder (--out)")
    check_settings(folder, record, settings)
    versions = record.software if software in record.software else [*record.software, software]
    record = msgspec.structs.replace(record, conditions=record.conditions | settings, software=versions)
    write_whole(folder / SWEEP_FILE, msgspec.json.format(msgspec.json.encode(record)).decode() + "\n")


def check_settings(folder: Path, record: SweepRecord, settings: Mapping[str, Any]) -> None:
    """Check that conditions were played with these settings.

    Args:
        folder: of the results, for the message.
        record: what it says it holds.
        settings: of the conditions as they are now, by name, as read back from JSON.

    Raises:
        SweepError: one was played with others.
    """
    for name, known in record.conditions.items():
        if name in settings and settings[name] != with_schedules(known):
            raise SweepError(
                f"{folder}: condition {name} was played with other settings than the present ones; "
                f"remove {folder / name} and its entry in {SWEEP_FILE}, or choose another folder (--out)"
            )
