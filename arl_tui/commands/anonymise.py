"""`arl anonymise`: copies that can be published."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import ToWrite, say
from core.system.foreign_text import printable, printable_lines

if TYPE_CHECKING:
    from studies.exports.anonymise import Copies

KEEP = ("dates", "terminal", "free-text", "other-keys", "codes")


@click.command(short_help="Copy recordings without dates, terminal facts, free text and codes.")
@click.argument("source", type=click.Path(exists=True, path_type=Path))
@click.argument("into", type=ToWrite(folder=True))
@click.option(
    "--key",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="File of the secret key from which new codes are made; a new one where it is missing. Keep it "
    "elsewhere: it must lie in neither folder.",
)
@click.option(
    "--keep",
    type=click.Choice(KEEP),
    multiple=True,
    help="Do not remove this. dates: wall-clock times. terminal: facts about the machine (how times were "
    "measured is always kept). free-text: paths, names of files, typed answers. other-keys: names of keys "
    "that mean nothing. codes: participants' codes. May be given several times.",
)
@click.option(
    "--study",
    "study_file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Study file: typed answers are found by its questions. Without it, every answer in words to a "
    "question that is not among the ready ones counts as typed.",
)
@click.option(
    "--file-hash",
    type=click.Choice(["sha256", "keyed"]),
    default="sha256",
    show_default=True,
    help="How a copy names its old file: by SHA-256, or by HMAC-SHA256 under the key, from which nobody "
    "without the key can try out dates and codes.",
)
def anonymise(
    source: Path, into: Path, key: Path, keep: tuple[str, ...], study_file: Path | None, file_hash: str
) -> None:
    """Copy SOURCE, a recording or a folder, to the new folder INTO so that it can be published.

    Recordings, reaction trials and records of sittings are copied. Copies are sealed anew and replay exactly;
    their headers say what was done and name the old file by its hash. SOURCE stays as it is. Status 1 where a
    file is damaged.
    """
    from core.recording.anonymise import Anonymising, removals
    from studies.exports.anonymise import anonymise as copy
    from studies.exports.anonymise import read_or_make_key
    from studies.lab.read import load_study

    new = not key.exists()
    try:
        where = source if source.is_dir() else source.parent
        secret = read_or_make_key(key, apart_from=(where, into) if source.is_dir() else (into,))
        how = Anonymising(secret, removals(keep), keyed_hash=file_hash == "keyed")
        questions = load_study(study_file).questionnaires if study_file else None
        copies = copy(source, into, how, questions=questions)
    except ValueError as error:
        raise click.ClickException(printable_lines(str(error))) from error
    if new:
        say(f"A new key: {printable(str(key), longest=None)}. Keep it under lock, apart from the copies.")
    tell(copies)


def tell(copies: "Copies") -> None:
    """Print what was copied and what was not; leave with status 1 where a file is damaged."""
    for old, new in copies.made:
        say(printable(f"{old} -> {new}", longest=None))
    for left in copies.left_out:
        say(f"Left out: {printable(str(left), longest=None)}", err=True)
    for bad in copies.damaged:
        say(f"Not copied: {printable(str(bad), longest=None)}", err=True)
    if copies.damaged:
        raise SystemExit(1)
    if not copies.made:
        raise click.ClickException("there is nothing to copy: no recordings, reaction trials or sittings")
