"""Learning curves of the noisy cross-entropy method on Tetris, beside the published ones.

Published: Thiery & Scherrer's reproduction of Szita & Lorincz (10 runs per noise schedule, 21 features,
10x20, mean lines of the mean vector over 30 games; files of the MDPTetris repository). Their rules are not
stated; see docs/decisions/cross-entropy-curves.md for which of ours stand for them and why.
"""

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from core.learners.cross_entropy import (
    ConstantNoise,
    CrossEntropy,
    CrossEntropyConfig,
    DecreasingNoise,
    Noise,
    NoNoise,
)
from core.numerics.streams import stream
from core.tetris.config import TetrisConfig
from core.tetris.cross_entropy_runner import evaluate, run_iteration
from studies.pools import processes

NOISES: dict[str, Noise] = {
    "none": NoNoise(),
    "constant": ConstantNoise(4.0),
    "linear": DecreasingNoise(5.0, 10.0),
}
"""Noise schedules by the names of the published files."""

RULES: dict[str, TetrisConfig] = {
    "reference": TetrisConfig(game_over="overflow", clear_on_overflow=True, lines_in_value=True),
    "overflow": TetrisConfig(game_over="overflow"),
    "overflow-clearing": TetrisConfig(game_over="overflow", clear_on_overflow=True),
    "fit-before-clear": TetrisConfig(),
}
"""Rules by name; all with a terminal value of minus infinity. `reference`: what the reference's cross-entropy
program does when told nothing else, with terminal placements avoided; `fit-before-clear`: our default."""

SEEDS = tuple(range(12))
"""The same for every rule and schedule, so that curves pair by seed."""
ITERATIONS = 20
COMPARED_ITERATIONS = (1, 3, 5, 10, 15, 20)


@dataclass(frozen=True, slots=True)
class Setting:
    """One run."""

    rules: str
    """A name in RULES."""
    noise: str
    """A name in NOISES."""
    root_seed: int


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """The mean vector after an iteration."""

    rules: str
    noise: str
    run: int
    """Root seed; number of the run in the published files."""
    iteration: int
    """Updates done, from 1."""
    mean_lines: float
    """Mean over 30 games."""


def settings(
    rules: Iterable[str], noises: Iterable[str] = NOISES, seeds: Sequence[int] = SEEDS
) -> list[Setting]:
    """Return every combination, as data."""
    return [Setting(rule, noise, seed) for rule in rules for noise in noises for seed in seeds]


def run_curve(setting: Setting, iterations: int = ITERATIONS) -> list[CurvePoint]:
    """Play one run; a pure function of the setting."""
    config = RULES[setting.rules]
    search = CrossEntropy(
        CrossEntropyConfig(noise=NOISES[setting.noise]), n_weights=21, root_seed=setting.root_seed
    )
    points = []
    for iteration in range(1, iterations + 1):
        run_iteration(search, config)
        rng = stream(setting.root_seed, "evaluation", iteration)
        lines = evaluate(search.mean, config, rng=rng).mean_lines
        points.append(CurvePoint(setting.rules, setting.noise, setting.root_seed, iteration, lines))
    return points


def run_curves(planned: Sequence[Setting], max_workers: int = 1) -> Iterator[list[CurvePoint]]:
    """Yield the curve of each setting, in their order; the same for any number of workers."""
    if max_workers == 1:
        yield from map(run_curve, planned)
        return
    with processes(max_workers) as pool:
        yield from pool.map(run_curve, planned, chunksize=1)


def read_published(path: Path) -> list[CurvePoint]:
    """Read the published curves.

    Args:
        path: CSV with the columns noise, run, iteration, mean_lines_of_mean_vector_30_games.
    """
    return _read_rows(path, "mean_lines_of_mean_vector_30_games", rules="published")


def lines_at(points: Iterable[CurvePoint], rules: str, noise: str, iteration: int) -> NDArray[np.float64]:
    """Return the mean lines of all runs of a kind after an iteration, shape (runs,)."""
    found = [
        point.mean_lines
        for point in points
        if (point.rules, point.noise, point.iteration) == (rules, noise, iteration)
    ]
    if not found:
        raise ValueError(f"no run with rules {rules!r}, noise {noise!r} reaches iteration {iteration}")
    return np.array(found)


@dataclass(frozen=True, slots=True)
class CurveComparison:
    """Our median beside the published runs, after one iteration."""

    rules: str
    noise: str
    iteration: int
    median: float
    """Of our runs."""
    published_min: float
    published_median: float
    published_max: float

    @property
    def inside(self) -> bool:
        """Whether our median lies in the range of the published runs."""
        return self.published_min <= self.median <= self.published_max


def compare(
    ours: Sequence[CurvePoint],
    published: Sequence[CurvePoint],
    iterations: Sequence[int] = COMPARED_ITERATIONS,
) -> list[CurveComparison]:
    """Compare every rule set and noise schedule in `ours` with the published runs of that schedule."""
    kinds = dict.fromkeys((point.rules, point.noise) for point in ours)
    rows = []
    for rules, noise in kinds:
        for iteration in iterations:
            theirs = lines_at(published, "published", noise, iteration)
            rows.append(
                CurveComparison(
                    rules,
                    noise,
                    iteration,
                    float(np.median(lines_at(ours, rules, noise, iteration))),
                    float(theirs.min()),
                    float(np.median(theirs)),
                    float(theirs.max()),
                )
            )
    return rows


def write_csv(points: Iterable[CurvePoint], path: Path) -> None:
    """Write curves as CSV, one row per run and iteration."""
    with path.open("w", newline="") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["rules", "noise", "run", "iteration", "mean_lines"])
        for point in points:
            writer.writerow([point.rules, point.noise, point.run, point.iteration, f"{point.mean_lines:.4f}"])


def read_csv(path: Path) -> list[CurvePoint]:
    """Read what `write_csv` wrote."""
    return _read_rows(path, "mean_lines")


def _read_rows(path: Path, lines_column: str, rules: str | None = None) -> list[CurvePoint]:
    """Return the rows of a CSV file as points; `rules` None: as its column says."""
    with path.open(newline="") as lines:
        return [
            CurvePoint(
                row["rules"] if rules is None else rules,
                row["noise"],
                int(row["run"]),
                int(row["iteration"]),
                float(row[lines_column]),
            )
            for row in csv.DictReader(lines)
        ]


def draw(ours: Sequence[CurvePoint], published: Sequence[CurvePoint], path: Path) -> None:
    """Draw one panel per noise schedule: the published range and median, and our median under each rule
    set.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 3.9), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, len(NOISES), sharey=True)
    iterations = sorted({point.iteration for point in ours})
    titles = {"none": "no noise", "constant": "constant noise 4", "linear": "noise max(5 - t/10, 0)"}
    colours = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
    for axis, noise in zip(axes, NOISES, strict=True):
        theirs = [lines_at(published, "published", noise, iteration) for iteration in iterations]
        low, high = [runs.min() for runs in theirs], [runs.max() for runs in theirs]
        axis.fill_between(iterations, low, high, color="0.85", label="published: range of 10 runs")
        axis.plot(iterations, [np.median(runs) for runs in theirs], color="0.45", label="published: median")
        for rules, colour in zip(dict.fromkeys(point.rules for point in ours), colours, strict=False):
            n_runs = len(lines_at(ours, rules, noise, iterations[0]))
            medians = [np.median(lines_at(ours, rules, noise, iteration)) for iteration in iterations]
            axis.plot(
                iterations, medians, color=colour, marker=".", label=f"{rules}: median of {n_runs} runs"
            )
        axis.set(title=titles[noise], xlabel="iteration", yscale="log", xticks=[1, 5, 10, 15, 20])
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("lines per game of the mean vector (30 games)")
    axes[0].legend(fontsize="x-small", loc="lower right")
    figure.savefig(path, dpi=130)
