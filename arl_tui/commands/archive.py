"""`arl archive`: a folder ready for OSF or Zenodo."""

from pathlib import Path

import click

from arl_tui.command_line import ToWrite, say
from arl_tui.commands.anonymise import KEEP
from arl_tui.commands.export import plain_errors, tell_trouble
from core.system.foreign_text import printable

LOCK_FILE = "requirements.lock"


@click.command(short_help="Make a folder ready for OSF or Zenodo: anonymised data, tables, codebook.")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--out", "into", type=ToWrite(folder=True), required=True, help="A new folder: the archive.")
@click.option(
    "--key",
    type=click.Path(dir_okay=False, path_type=Path),
    required=True,
    help="File of the secret key from which new codes are made, as in `arl anonymise`; a new one where it "
    "is missing.",
)
@click.option(
    "--keep", type=click.Choice(KEEP), multiple=True, help="Do not remove this, as in `arl anonymise`."
)
@click.option(
    "--file-hash",
    type=click.Choice(["sha256", "keyed"]),
    default="sha256",
    show_default=True,
    help="How a copy names its old file, as in `arl anonymise`.",
)
@click.option(
    "--study",
    "study_file",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Study file: it is copied with its texts, questionnaires and protocol.",
)
@click.option(
    "--name", default="Key presses and reaction times", show_default=True, help="Title of the archive."
)
@click.option("--author", "authors", multiple=True, help="An author; may be given several times.")
@click.option("--licence", default="", help="Licence of the data, such as CC0.")
@plain_errors
def archive(
    folder: Path,
    into: Path,
    key: Path,
    keep: tuple[str, ...],
    file_hash: str,
    study_file: Path | None,
    name: str,
    authors: tuple[str, ...],
    licence: str,
) -> None:
    """Make an archive of the data in FOLDER that can be deposited as it is.

    It holds the anonymised data, tidy tables with their codebook, a BIDS data set, Minari data sets (where
    minari is installed), protocols and study files, the format's JSON Schema, versions and lock file,
    checksums, and a README.
    """
    from arl_tui.app.facts import REPOSITORY, software
    from core.recording.anonymise import Anonymising, removals
    from studies.exports.anonymise import read_or_make_key
    from studies.exports.archive import ArchiveSettings, make_archive

    how = Anonymising(
        read_or_make_key(key, apart_from=(folder, into)), removals(keep), keyed_hash=file_hash == "keyed"
    )
    settings = ArchiveSettings(
        name=name,
        authors=authors,
        licence=licence,
        study_file=study_file,
        lock_file=REPOSITORY / LOCK_FILE,
        software=software(),
    )
    made = make_archive(folder, into, how, settings)
    say(f"Archive: {printable(str(into), longest=None)}")
    for part, what in made.parts.items():
        say(f"  {part:12} {what}")
    say(f"Key: {printable(str(key), longest=None)}. Keep it under lock, apart from the archive.")
    tell_trouble(made.copies.left_out, made.copies.damaged)
