"""Results of a sweep as they lie in its folder: reads files, never plays."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from core.numerics.arrays import Floats
from studies.experiments.run import SweepError, SweepRecord, read_record
from studies.experiments.sweep import Experiment, load_experiment


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
                f"the page of {self.experiment.name} compares conditions of which too few trials were played: {there}; "
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

    Only trials that all conditions have are taken: comparisons are paired. A condition with less than half the trials
    of the fullest one is left out, or it would take the others' trials with it.

    Args:
        experiment: which.
        folder: where its results are.
        only: conditions to read, all of them; where empty those that have enough trials.

    Raises:
        SweepError: there is nothing, or no trial that all conditions have.
    """
    record = read_record(folder)
    if record is None:
        raise SweepError(
            f"{folder} holds no results: `arl experiment run {shlex.quote(experiment.source or experiment.name)}` plays them"
        )
    found = {
        condition.name: {_seed_of(path) for path in (folder / condition.name).glob("seed-*.csv")}
        for condition in experiment.conditions
        if not only or condition.name in only
    }
    fullest = max((len(seeds) for seeds in found.values()), default=0)
    names = [name for name, seeds in found.items() if only or (seeds and 2 * len(seeds) >= fullest)]
    left_out = {name: len(seeds) for name, seeds in found.items() if seeds and name not in names}
    seeds = sorted(set.intersection(*(found[name] for name in names))) if names else []
    if not seeds:
        raise SweepError(
            f"{folder}: no trial was played under every condition ({', '.join(names) or 'none'})"
        )
    trials = {
        name: tuple(_read_rows(folder / name / f"seed-{seed:07d}.csv") for seed in seeds) for name in names
    }
    return Results(experiment, record, tuple(seeds), trials, left_out, folder)


def read_beside(results: Results, name: str, only: Sequence[str]) -> Results | None:
    """Return results of another experiment whose folder lies beside; None where they are not there.

    Args:
        results: of one experiment.
        name: of the other.
        only: its conditions; the trials that all of them have are read.
    """
    if results.folder is None:
        return None
    folder = results.folder.parent / (f"{name}-quick" if results.record.quick else name)
    try:
        found = read_results(load_experiment(name), folder, only)
    except SweepError:
        return None
    of_it = found.record.experiment == name and found.record.quick == results.record.quick
    return found if of_it else None


def equal_trials(results: Results, condition: str, others: Results, other: str) -> tuple[int, int]:
    """Return how many trials two conditions have both (by root seed), and in how many of them all rows are equal."""
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


def _seed_of(path: Path) -> int:
    return int(path.stem.removeprefix("seed-"))


def _read_rows(path: Path) -> dict[str, Floats]:
    with path.open(encoding="utf-8") as lines:
        names = lines.readline().rstrip("\n").split(",")
        table = np.loadtxt(lines, delimiter=",", ndmin=2)
    if table.shape[1] != len(names):
        raise SweepError(
            f"{path}: {len(names)} columns are named, rows have {table.shape[1]}; remove the file"
        )
    return {name: table[:, place] for place, name in enumerate(names)}
