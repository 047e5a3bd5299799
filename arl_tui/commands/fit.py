"""`arl fit`: reaction times in, delay densities with their uncertainty out."""

import os
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import NumberRange, ToWrite, file_or_dash
from arl_tui.commands.fit_request import InputError, Request, say

if TYPE_CHECKING:
    from studies.reaction_time.fit import GroupFit
    from studies.reaction_time.report import Result
    from studies.reaction_time.sample import Sample

IN_FULL = 3
"""Up to this many participants are shown in full, more of them in a line each."""
WORTH_A_PROCESS = 8
"""Fewer participants are fitted sooner here than in processes that have to start first."""


_PATH = ToWrite()
READABLE = (".tsv", ".csv", ".jsonl", ".txt")
"""Endings of files that most often hold reaction times; JSON describes others' tables more often."""


@click.command(short_help="Fit delay densities to reaction times in files.")
@click.argument("files", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option(
    "--from",
    "preset",
    metavar="PROGRAM",
    help="Whose files they are: psychopy, jspsych, eprime, gorilla, opensesame, dmdx, qualtrics; or table. "
    "Recognised by default; a file without that program's marks is an error.",
)
@click.option(
    "--column",
    multiple=True,
    metavar="WHAT=NAME",
    help="Which column of a table holds what: rt=NAME (response_time, or the program's), participant=NAME "
    "(participant_id, or the program's; without such a column the file's name tells).",
)
@click.option(
    "--unit",
    type=click.Choice(["s", "ms", "us", "ns"]),
    help="Unit of the rt column, unless its name (rt_ms), a BIDS sidecar or BIDS itself states it. Never "
    "guessed.",
)
@click.option(
    "--keep",
    multiple=True,
    metavar="COLUMN=VALUE",
    help="Read only rows with this value; several values of one column: any of them.",
)
@click.option(
    "--by", multiple=True, metavar="COLUMN", help="Fit each value of this column (a condition) apart."
)
@click.option(
    "--decimal",
    type=click.Choice([".", ","]),
    default=".",
    show_default=True,
    help="What separates decimals in tables.",
)
@click.option(
    "--waited",
    type=float,
    metavar="SECONDS",
    help="The task's time-out: rows without a response, and times equal to it, are censored there.",
)
@click.option(
    "--list",
    "of_list",
    type=click.Choice(["first", "last"]),
    help="Which time counts in a cell that holds a list of times; by default such cells are refused.",
)
@click.option(
    "--missing",
    multiple=True,
    metavar="TEXT",
    help="A cell of the rt column that means no response, such as -1 or 9999.",
)
@click.option(
    "--encoding",
    metavar="NAME",
    help="Code page of the tables, e.g. cp1250; UTF-8, UTF-16 or else Windows-1252 by default.",
)
@click.option("--trust-magnitudes", is_flag=True, help="Take medians that no person has in the stated unit.")
@click.option(
    "--allow-faults",
    is_flag=True,
    help="Leave out any number of negative and absurd times; by default more than 5 % in a file are refused.",
)
@click.option(
    "--task",
    metavar="TEXT",
    help="What was measured; our recordings say it. Evaluations (evaluation, feedback lag) have other limits "
    "than reactions.",
)
@click.option(
    "--only", multiple=True, metavar="CODE", help="Fit only this participant. May be given several times."
)
@click.option("--as-one", is_flag=True, help="Take all rows as one person's.")
@click.option(
    "--anticipation-below",
    type=float,
    default=0.1,
    show_default=True,
    help="Seconds; faster is not a reaction.",
)
@click.option(
    "--slow-above",
    type=float,
    help="Seconds; slower is something else. 3 for reactions, 10 for evaluations by default.",
)
@click.option(
    "--absurd-above",
    type=float,
    default=30.0,
    show_default=True,
    help="Seconds; slower is a fault of the file.",
)
@click.option("--keep-practice", is_flag=True, help="Use practice trials, too.")
@click.option("--keep-wrong", is_flag=True, help="Use the times of wrong answers, too.")
@click.option(
    "--time-outs",
    type=click.Choice(["censor", "exclude"]),
    default="censor",
    show_default=True,
    help="Trials without a response, where it is known how long they waited.",
)
@click.option(
    "--pooled",
    is_flag=True,
    help="Also let participants inform each other: for few trials each, from 5 people.",
)
@click.option(
    "--level", type=NumberRange(0.5, 0.999), default=0.95, show_default=True, help="Of all intervals."
)
@click.option(
    "--resamples",
    type=click.IntRange(0),
    default=200,
    show_default=True,
    help="Parametric bootstrap; 0 leaves it out.",
)
@click.option(
    "--goodness",
    type=click.IntRange(0),
    help=f"Resamples of the goodness-of-fit test; 199 for up to {IN_FULL} participants, none for more.",
)
@click.option(
    "--seed",
    type=click.IntRange(0, 2**63 - 1),
    default=0,
    show_default=True,
    help="Root seed of the resampling.",
)
@click.option("--workers", type=click.IntRange(1), help="Processes. The result does not depend on it.")
@click.option(
    "--figure",
    type=ToWrite(figure=True),
    help="Draw the fit, or the means of several participants (PNG, SVG or PDF).",
)
@click.option(
    "--json",
    "json_path",
    metavar="FILE",
    callback=file_or_dash,
    help="Write everything for machines; - prints it instead of the tables.",
)
@click.option("--html", type=_PATH, help="Write a report of one page.")
@click.option(
    "--out",
    type=ToWrite(folder=True),
    help="Write JSON, report, the verdict on each row and all figures into a new folder.",
)
def fit(files: tuple[Path, ...], **options: object) -> None:
    """Fit delay densities to the reaction times in FILES: our recordings, BIDS, CSV, or a program's own data
    files.

    Gamma and seven other families by maximum likelihood, with intervals. Status 2 and a message if a file
    cannot be used. When to trust the numbers: docs/trusting-a-fit.md.
    """
    request = Request(**options)  # type: ignore[arg-type]
    fit_files(files, request)


def fit_files(files: Sequence[Path], request: Request) -> None:
    """Read, select, fit, print and write."""
    from arl_tui.commands.fit_input import limit_lines, oddity_lines, read, select_from, source_lines, task_of
    from arl_tui.commands.fit_tables import fault_lines, not_fitted_lines, reading_lines
    from core.numerics.clock import wall_time_utc
    from core.system.foreign_text import printable
    from studies.reaction_time.report import Result, write_report

    if request.out is not None and request.out.exists():
        raise InputError(f"{request.out} exists: reports are never overwritten; name a new folder")
    refuse_folders(files)
    task = request.task or task_of(files)
    readings = read(files, request)
    for line in source_lines(readings):
        say(line, err=True)
    rows, samples, selection = select_from(readings, request, task)
    for line in (
        *limit_lines(rows, selection, request, task),
        *fault_lines(rows, selection),
        *oddity_lines(request, rows, samples),
    ):
        say(line, err=True)
    group = fit_with_bar(samples, request)
    names = tuple(printable(path.name, longest=None) for path in files)
    result = Result(created_utc=wall_time_utc(), task=task, files=names, selection=selection, group=group)
    if request.json_path != "-":
        for line in reading_lines(rows, selection):
            say(line)
        show(group, samples, request)
        for line in not_fitted_lines(selection, group, request.only):
            say(line)
    write(result, samples, request)
    if request.out is not None:
        write_report(
            request.out, task=task, files=names, rows=rows, samples=samples, selection=selection, group=group
        )
        say(f"Report: {request.out}", err=True)


def refuse_folders(paths: Sequence[Path]) -> None:
    """Stop where a folder is named, with the files in it: which of them hold reactions, nobody can guess."""
    for folder in (path for path in paths if path.is_dir()):
        by_ending = {ending: sorted(folder.rglob(f"*{ending}")) for ending in READABLE}
        found = max(by_ending.values(), key=len)
        if not found:
            raise InputError(f"{folder} is a folder without a table or a recording in it: name files")
        levels = "/".join("*" * (len(found[0].relative_to(folder).parts) - 1))
        pattern = folder / levels / f"*{found[0].suffix}"
        raise InputError(
            f"{folder} is a folder of {len(found)} files that may hold reactions, the first {found[0]}: name "
            f"the files, for instance `arl fit {pattern}`"
        )


def fit_with_bar(samples: "Mapping[str, Sample]", request: Request) -> "GroupFit":
    """Fit all participants with a bar that shows how far it is; stop where none can be fitted."""
    from studies.reaction_time.fit import FitSettings, fit_group
    from studies.reaction_time.pooling import FEWEST_PEOPLE

    if request.pooled and len(samples) < FEWEST_PEOPLE:
        raise InputError(
            f"--pooled needs at least {FEWEST_PEOPLE} participants, there are {len(samples)} to fit"
        )
    in_full = len(samples) <= IN_FULL
    settings = FitSettings(
        level=request.level,
        n_resamples=request.resamples,
        n_goodness=199 * in_full if request.goodness is None else request.goodness,
        root_seed=request.seed,
        pooled=request.pooled,
    )
    enough = len(samples) >= WORTH_A_PROCESS
    workers = request.workers or (os.cpu_count() or 1 if enough else 1)
    with click.progressbar(length=len(samples), label="Fitting", file=sys.stderr) as bar:
        group = fit_group(
            samples, settings, n_workers=workers, progress=lambda _done, _all, _participant: bar.update(1)
        )
    if not group.participants:
        raise InputError(
            "nobody can be fitted: " + "; ".join(f"{n}: {why}" for n, why in group.failures.items())
        )
    return group


def show(group: "GroupFit", samples: "Mapping[str, Sample]", request: Request) -> None:
    """Print the tables."""
    from arl_tui.commands.fit_tables import group_lines, participant_lines, pooled_lines

    people = list(group.participants.values())
    if len(people) <= IN_FULL:
        for one in people:
            say()
            say("\n".join(participant_lines(one, samples[one.participant])))
    else:
        say()
        say("\n".join(group_lines(group)))
        say(f"One participant in full, with plots: --only {shlex.quote(people[0].participant)}")
    if request.pooled:
        say()
        say("\n".join(pooled_lines(group)))


def write(result: "Result", samples: "Mapping[str, Sample]", request: Request) -> None:
    """Write the files that were asked for, and say so."""
    import msgspec

    from core.system.foreign_text import printable_json
    from core.system.whole_file import write_whole

    if request.json_path is not None:
        text = msgspec.json.format(msgspec.json.encode(result), indent=1).decode()
        if request.json_path == "-":
            say(printable_json(text))
        else:
            write_whole(Path(request.json_path), text)
            say(f"JSON: {request.json_path}", err=True)
    if request.figure is not None:
        from arl_tui.commands.fit_figure import draw_fit

        try:
            draw_fit(result.group, samples, request.figure)
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--figure") from error
        say(f"Figure: {request.figure}", err=True)
    if request.html is not None:
        from studies.reaction_time.report import html_report

        write_whole(request.html, html_report(result, samples))
        say(f"Page: {request.html}", err=True)
