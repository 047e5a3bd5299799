"""`arl export`: data in formats that other programs and archives read."""

import functools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal

import click

from arl_tui.command_line import ToWrite, say
from core.system.foreign_text import printable, printable_lines

source_argument = click.argument("folder", type=click.Path(exists=True, path_type=Path))
into_option = click.option(
    "--out", "into", type=ToWrite(folder=True), required=True, help="A new folder for what is written."
)


@click.group(short_help="Write data as tables, BIDS or Minari.")
def export() -> None:
    """Write the data in a folder in formats that other programs and archives read.

    Recordings, reaction trials and records of a study's sittings are read; nothing in the folder is changed.
    """


def plain_errors(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let a command tell documented errors in a message without a stack trace."""

    @functools.wraps(function)
    def run(*args: Any, **extra: Any) -> Any:
        try:
            return function(*args, **extra)
        except ValueError as error:
            raise click.ClickException(printable_lines(str(error))) from error

    return run


def tell_trouble(left_out: Iterable[object], damaged: Iterable[object]) -> None:
    """Name the files that were not exported; leave with status 1 where one is damaged."""
    for other in left_out:
        say(f"Left out: {printable(str(other), longest=None)}", err=True)
    bad = [printable(str(each), longest=None) for each in damaged]
    for each in bad:
        say(f"Not exported: {each}", err=True)
    if bad:
        raise SystemExit(1)


@export.command(short_help="Tidy tables with a codebook.")
@source_argument
@into_option
@click.option(
    "--format",
    "file_format",
    type=click.Choice(["csv", "parquet"]),
    default="csv",
    show_default=True,
    help="Of the tables. Parquet needs pyarrow: pip install 'arl-tui[parquet]'.",
)
@plain_errors
def tidy(folder: Path, into: Path, file_format: Literal["csv", "parquet"]) -> None:
    """Write the data in FOLDER as tables: sessions, games, steps, presses, credit, answers, frames, trials.

    With them come settings, interruptions and a codebook (Markdown and JSON). docs/how-to/publish-data.md has
    examples.
    """
    from studies.exports.tidy import export_tidy, simulated_note

    exported = export_tidy(folder, into, file_format=file_format)
    say(f"{exported.files} files read. Tables in {printable(str(into), longest=None)}:")
    for name, rows in exported.rows.items():
        say(f"  {name + '.' + file_format:20} {rows:>9,} rows")
    say("  codebook.md, codebook.json")
    if note := simulated_note(exported.origins):
        say(note)
    for first, second in exported.twice:
        names = printable(f"{first} and {second}", longest=None)
        say(f"Beware: {names} seem to be one session: its rows are there twice.", err=True)
    tell_trouble(exported.left_out, exported.damaged)


@export.command(short_help="Print the codebook of the tidy tables.")
@click.option("--json", "as_json", is_flag=True, help="As JSON (a Frictionless data package).")
def codebook(as_json: bool) -> None:
    """Print the codebook of the tidy tables: every column, its unit and its levels."""
    import json

    from studies.exports.columns import codebook as in_json
    from studies.exports.columns import codebook_page
    from studies.exports.tables import TABLES

    page = codebook_page(TABLES).rstrip("\n")
    say(json.dumps(in_json(TABLES), indent=2, ensure_ascii=False) if as_json else page)


@export.command(short_help="A BIDS data set.")
@source_argument
@into_option
@click.option(
    "--name", default="Key presses and reaction times", show_default=True, help="Name of the data set."
)
@click.option(
    "--author",
    "authors",
    multiple=True,
    help="An author; may be given several times. BIDS expects two or more.",
)
@click.option("--licence", default="", help="Licence of the data, such as CC0.")
@click.option("--institution", default="", help="Where the data were recorded.")
@click.option("--institution-address", default="", help="Its address.")
@click.option("--department", default="", help="Its department.")
@click.option("--with-dates", is_flag=True, help="Write when sessions began.")
@click.option("--with-free-text", is_flag=True, help="Write remarks and names of other keys.")
@plain_errors
def bids(
    folder: Path,
    into: Path,
    name: str,
    authors: tuple[str, ...],
    licence: str,
    institution: str,
    institution_address: str,
    department: str,
    with_dates: bool,
    with_free_text: bool,
) -> None:
    """Write the recordings and reaction trials in FOLDER as a BIDS data set of behaviour.

    Wall-clock times and texts that people typed are left out unless they are asked for.
    """
    from studies.exports.bids import BidsSettings, export_bids

    settings = BidsSettings(
        name=name,
        authors=authors,
        licence=licence,
        institution=institution,
        institution_address=institution_address,
        department=department,
        dates=with_dates,
        free_text=with_free_text,
    )
    exported = export_bids(folder, into, settings)
    say(f"{len(exported.files)} tables in {printable(str(into), longest=None)}")
    unsaid = {
        "--author (two or more)": len(authors) > 1,
        "--licence": licence,
        "--institution": institution,
        "--institution-address": institution_address,
        "--department": department,
    }
    missing = [option for option, said in unsaid.items() if not said]
    if missing:
        say(f"Not said, and the validator will warn of it: {', '.join(missing)}")
    tell_trouble(exported.left_out, exported.damaged)


@export.command(short_help="Minari data sets, one per game.")
@source_argument
@into_option
@plain_errors
def minari(folder: Path, into: Path) -> None:
    """Write the watched games of the recordings in FOLDER as Minari data sets, for other programs' learners.

    Needs minari: pip install 'arl-tui[minari]'. Minari finds the data sets by MINARI_DATASETS_PATH.
    """
    from studies.exports.minari import FOLDER_VARIABLE, export_minari

    exported = export_minari(folder, into)
    for name, episodes in exported.episodes.items():
        say(
            f"{name}: {episodes} games, presses in "
            f"{printable(str(into / name / 'presses.csv'), longest=None)}"
        )
    say(f"Load: {FOLDER_VARIABLE}={printable(str(into), longest=None)}; minari.load_dataset({name!r})")
    tell_trouble(exported.left_out, exported.damaged)
