"""`arl experiment`: run a sweep with progress, resumable; report from its files."""

import shlex
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Self

import click

from arl_tui.command_line import ToWrite, say

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from studies.experiments.sweep import Experiment

NAMES = (
    *("fig4", "fig5", "fig6", "fig7", "features", "robustness", "robustness-keepaway", "credit"),
    "mountain-car",
)
"""Written out here so that `--help` need not load them; a test compares."""
DEFAULT_RESULTS = Path("results")

name_argument = click.argument("name", metavar="NAME")
out_option = click.option(
    "--out",
    type=ToWrite(folder=True),
    default=DEFAULT_RESULTS,
    show_default=True,
    help="Results are kept in a folder of the experiment's name below this one.",
)


@click.group(short_help="Run the experiments behind the figures, and report them.")
def experiment() -> None:
    """Run the experiments behind the figures, and report them.

    NAME is one of fig4 fig5 fig6 fig7 features robustness robustness-keepaway credit mountain-car, or one of
    your own: a file (my.py) or a module (my_package.my) with an EXPERIMENT. docs/own-experiment.md has a
    template.
    """


@experiment.command()
@name_argument
@click.option("--trials", type=click.IntRange(1), default=20, show_default=True, help="Trials per condition.")
@click.option(
    "--first-seed", type=click.IntRange(0), default=0, show_default=True, help="Root seed of trial 0."
)
@click.option("--quick", is_flag=True, help="Short trials: to see that everything works.")
@click.option("--workers", type=click.IntRange(1), help="Processes; one per processor by default.")
@click.option(
    "--cluster",
    metavar="ADDRESS",
    help="Play on a Dask cluster instead, as tcp://host:8786. Only a cluster that you trust: its scheduler "
    "and workers can run any code in this program (Dask exchanges pickles). Without this option nothing is "
    "unpickled from elsewhere, and the network is not used.",
)
@click.option(
    "--only", multiple=True, metavar="CONDITION", help="Only this condition. May be given several times."
)
@out_option
def run(
    name: str,
    trials: int,
    first_seed: int,
    quick: bool,
    workers: int | None,
    cluster: str | None,
    only: tuple[str, ...],
    out: Path,
) -> None:
    """Play experiment NAME: every trial that has no file yet. May be stopped at any time and goes on from
    there.
    """
    from arl_tui.app import facts
    from studies.experiments.run import SweepError, run_sweep
    from studies.experiments.sweep import root_seeds

    sweep = _loaded(name)
    folder = out / (f"{sweep.name}-quick" if quick else sweep.name)
    try:
        with _executor(workers, cluster) as executor, _Progress(sweep.name) as progress:
            files = run_sweep(
                sweep,
                root_seeds(trials, first_seed),
                folder,
                executor,
                quick=quick,
                only=only,
                software=facts.software(),
                on_progress=progress.show,
                on_damaged=lambda path, reason: say(f"Damaged, played again: {path}: {reason}", err=True),
            )
    except (SweepError, ValueError) as error:
        raise click.ClickException(str(error)) from error
    following = ["arl", "experiment", "report", name, "--out", str(out)]
    following += ["--quick"] if quick else []
    following += [word for condition in only for word in ("--only", condition)]
    say(f"{len(files)} trials in {folder}. Next: {shlex.join(following)}")


@experiment.command()
@name_argument
@out_option
@click.option("--quick", is_flag=True, help="Of the short trials.")
@click.option(
    "--into",
    type=ToWrite(folder=True),
    help="The page goes into results/ below this folder, its figures into figures/; by default below the "
    "results.",
)
@click.option(
    "--only",
    multiple=True,
    metavar="CONDITION",
    help="Only this condition, however few trials it has; given several times, the trials that all of them "
    "have.",
)
def report(name: str, out: Path, quick: bool, into: Path | None, only: tuple[str, ...]) -> None:
    """Write the page of experiment NAME with its figures, from the files of its trials. Plays nothing."""
    from studies.experiments.page import write_page
    from studies.experiments.results import read_results
    from studies.experiments.run import SweepError
    from studies.experiments.sweep import experiment_module
    from studies.statistics import few_trials_note

    sweep = _loaded(name)
    module = experiment_module(name)
    if not hasattr(module, "report"):
        raise click.ClickException(f"{module.__name__} has no report(results)")
    folder = out / (f"{sweep.name}-quick" if quick else sweep.name)
    try:
        results = read_results(sweep, folder, only)
        written = write_page(
            module.report(results),
            into or folder / "report",
            quick=results.record.quick,
            trials=len(results.seeds),
        )
    except SweepError as error:
        raise click.ClickException(str(error)) from error
    except ValueError as error:
        raise click.ClickException(f"{name}: its report cannot be made of {folder}: {error}") from error
    for path in written:
        say(str(path))
    few = few_trials_note(len(results.seeds))
    if few is not None:
        say(few, err=True)


def _loaded(name: str) -> "Experiment":
    from studies.experiments.sweep import load_experiment

    try:
        return load_experiment(name)
    except (ValueError, TypeError, ImportError, SyntaxError) as error:
        raise click.BadParameter(str(error), param_hint="NAME") from error


def _executor(workers: int | None, cluster: str | None) -> "AbstractContextManager[Executor]":
    import os

    from studies.experiments.run import dask_cluster
    from studies.pools import processes

    if cluster:
        return dask_cluster(cluster)
    return processes(workers or os.cpu_count() or 1)


class _Progress:
    """A bar with the remaining time; where there is no terminal, a line now and then."""

    def __init__(self, name: str) -> None:
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        self._progress = Progress(
            TextColumn(name),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("trials, left"),
            # Trials take seconds to minutes: look back far.
            TimeRemainingColumn(),
            TextColumn("since"),
            TimeElapsedColumn(),
            speed_estimate_period=1800.0,
        )
        self._task = self._progress.add_task(name, total=None)
        self._first_done: int | None = None

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._progress.stop()

    def show(self, done: int, planned: int) -> None:
        """Show that so many trials are done."""
        if self._first_done is None:
            self._first_done = done
            if done:
                say(f"{done} of {planned} trials are there already")
        # Those of an earlier run took no time now: they would spoil the estimate.
        self._progress.update(self._task, completed=done - self._first_done, total=planned - self._first_done)
