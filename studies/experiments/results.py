"""Results of a sweep as they lie in its folder: reads files, never plays."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from core.numerics.arrays import Floats
from studies.experiments.run import SWEEP_FILE, SweepError, SweepRecord, check_settings, read_record
from studies.experiments.sweep import Experiment, describe_settings, load_experiment
from studies.experiments.trial_file import Played, read_trials, seed_of


class DamagedSweep(SweepError):
    """Files of a sweep are damaged; the message names them."""


@dataclass(frozen=True, slots=True)
class Results:
    """The trials that every condition of an experiment has."""

    experiment: Experiment
    record: SweepRecord
    seeds: tuple[int, ...]
    trials: dict[str, tuple[dict[str, Floats], ...]]
    """By condition; one entry per seed, in their order: columns by name."""
    left_out: dict[str, int] = field(default_factory=dict)
    """Conditions of which less than half of the trials are there, with how many are."""
    folder: Path | None = None
    """Where they were read from."""

    @property
    def conditions(self) -> tuple[str, ...]:
        """Names of the conditions that are there, in the experiment's order."""
        return tuple(self.trials)

    def label(self, condition: str) -> str:
        """Return how a condition is called in figures."""
        return self.experiment.condition(condition).label

    def require(self, *conditions: str) -> None:
        """Check that a page's conditions are there.

        Raises:
            SweepError: some are not, or too few of their trials to be compared with the others'.
        """
        missing = [name for name in conditions if name not in self.trials]
        if missing:
            there = ", ".join(f"{name} ({self.left_out.get(name, 0)} trials)" for name in missing)
            named = " ".join(f"--only {shlex.quote(name)}" for name in conditions)
            raise SweepError(
                f"the page of {self.experiment.name} compares conditions of which too few trials were "
                f"played: {there}; "
                f"play more, or report the trials that all of them have: {named}"
            )

    def table(self, condition: str, column: str) -> Floats:
        """Return one column of all trials, shape (trials, episodes); trials must have equal lengths."""
        return np.array([trial[column] for trial in self.trials[condition]])

    def blocks(self, condition: str, column: str, size: int) -> Floats:
        """Return means over blocks of `size` episodes, shape (trials, blocks)."""
        table = self.table(condition, column)
        n_blocks = table.shape[1] // size
        return np.asarray(table[:, : n_blocks * size].reshape(len(table), n_blocks, size).mean(axis=2))


def read_results(experiment: Experiment, folder: Path, only: Sequence[str] = ()) -> Results:
    """Read what a folder holds of an experiment.

    Only trials that all conditions have are taken: comparisons are paired. A condition with less than half
    the trials of the fullest one is left out, or it would take the others' trials with it.

    Args:
        experiment: which.
        folder: where its results are.
        only: conditions to read, all of them; where empty those that have enough trials.

    Raises:
        SweepError: there is nothing, or no trial that all conditions have; a file is damaged; or a condition
            was played with other settings than the experiment's present ones.
    """
    record = read_record(folder)
    if record is None:
        raise SweepError(
            f"{folder} holds no results: `arl experiment run "
            f"{shlex.quote(experiment.source or experiment.name)}` plays them"
        )
    if record.experiment != experiment.name:
        raise SweepError(f"{folder} holds results of {record.experiment}, not of {experiment.name}")
    files = {
        condition.name: sorted((folder / condition.name).glob("seed-*.csv"))
        for condition in experiment.conditions
        if not only or condition.name in only
    }
    rows = _sound_rows(experiment, folder, record, files)
    found = {name: set(trials) for name, trials in rows.items()}
    fullest = max((len(seeds) for seeds in found.values()), default=0)
    names = [name for name, seeds in found.items() if only or (seeds and 2 * len(seeds) >= fullest)]
    left_out = {name: len(seeds) for name, seeds in found.items() if seeds and name not in names}
    seeds = sorted(set.intersection(*(found[name] for name in names))) if names else []
    if not seeds:
        raise SweepError(
            f"{folder}: no trial was played under every condition ({', '.join(names) or 'none'})"
        )
    trials = {name: tuple(rows[name][seed] for seed in seeds) for name in names}
    return Results(experiment, record, tuple(seeds), trials, left_out, folder)


def read_beside(results: Results, name: str, only: Sequence[str]) -> Results | None:
    """Return results of another experiment whose folder lies beside; None where they are not there.

    Args:
        results: of one experiment.
        name: of the other.
        only: its conditions; the trials that all of them have are read.

    Raises:
        DamagedSweep: they are there, and damaged.
    """
    if results.folder is None:
        return None
    folder = results.folder.parent / (f"{name}-quick" if results.record.quick else name)
    try:
        found = read_results(load_experiment(name), folder, only)
    except DamagedSweep:
        raise
    except SweepError:
        return None
    of_it = found.record.experiment == name and found.record.quick == results.record.quick
    return found if of_it else None


def equal_trials(results: Results, condition: str, others: Results, other: str) -> tuple[int, int]:
    """Return how many trials two conditions have both (by root seed), and in how many of them all rows are
    equal.
    """
    by_seed = dict(zip(others.seeds, others.trials[other], strict=True))
    shared = [
        (mine, by_seed[seed])
        for seed, mine in zip(results.seeds, results.trials[condition], strict=True)
        if seed in by_seed
    ]
    equal = sum(
        mine.keys() == theirs.keys() and all(np.array_equal(mine[name], theirs[name]) for name in mine)
        for mine, theirs in shared
    )
    return len(shared), equal


def _sound_rows(
    experiment: Experiment, folder: Path, record: SweepRecord, files: Mapping[str, Sequence[Path]]
) -> dict[str, dict[int, dict[str, Floats]]]:
    """Return the rows of every trial by condition and seed; damaged ones are never averaged in."""
    asked_for = [experiment.condition(name) for name, paths in files.items() if paths]
    settings = describe_settings(asked_for)
    check_settings(folder, record, settings)
    unknown = [name for name in settings if name not in record.conditions]
    if unknown:
        raise SweepError(
            f"{folder}: {SWEEP_FILE} does not say with what settings {', '.join(unknown)} was played: `arl "
            f"experiment run {shlex.quote(experiment.source or experiment.name)}` plays it"
        )
    rows: dict[str, dict[int, dict[str, Floats]]] = {name: {} for name in files}
    damaged: dict[Path, str] = {}
    for name, plain in settings.items():
        sound, unsound = read_trials(files[name], Played(plain, record.quick))
        rows[name] = {seed_of(path): trial for path, trial in sound.items()}
        damaged |= unsound
    if damaged:
        named = "\n".join(f"  {path}: {reason}" for path, reason in damaged.items())
        quick = " --quick" if record.quick else ""
        raise DamagedSweep(
            f"{len(damaged)} files of {folder} are damaged, and nothing is averaged over the rest:\n{named}\n"
            f"Play them again: `arl experiment run{quick} "
            f"{shlex.quote(experiment.source or experiment.name)}`; a file that is no trial's has to be "
            "removed"
        )
    return rows
