"""`arl recordings upgrade` and `arl recordings schema`: the format of recordings and its versions."""

from pathlib import Path

import click

from arl_tui.command_line import ToWrite, say
from core.system.foreign_text import printable


@click.command(short_help="Write recordings of earlier versions again in the present one.")
@click.argument("source", type=click.Path(exists=True, path_type=Path))
@click.argument("into", type=ToWrite(folder=True))
def upgrade(source: Path, into: Path) -> None:
    """Write each recording in SOURCE that is of an earlier version again, in the new folder INTO.

    Old files stay as they are and are read as ever. New ones replay exactly; what the old version did not
    record is null in them. Status 1 where a file is damaged.
    """
    from core.recording.reader import RecordingError, read_recording
    from core.recording.schema import VERSION
    from core.recording.upgrade import upgraded, upgraded_path
    from core.system.private_files import make_private_folder, write_private
    from studies.exports.sources import find_sources

    if into.exists() and any(into.iterdir()):
        raise click.ClickException(f"{into} is not empty: name a new folder")
    # Listed first: new files are not to be found when the new folder lies in the old one.
    sources = [source for source in find_sources(source) if source.kind == "recording"]
    n_damaged = n_present = 0
    for one in sources:
        try:
            recording = read_recording(one.path)
        except RecordingError as error:
            say(f"Not upgraded: {printable(str(error), longest=None)}", err=True)
            n_damaged += 1
            continue
        if recording.header.version == VERSION:
            n_present += 1
            continue
        target = into / upgraded_path(one.relative)
        make_private_folder(target.parent)
        write_private(target, upgraded(recording))
        say(printable(f"{one.path} (version {recording.header.version}) -> {target}", longest=None))
    if n_present:
        say(f"{n_present} of version {VERSION} already: left as they are.")
    if n_damaged:
        raise SystemExit(1)


@click.command(short_help="Print the JSON Schema of the recording format.")
@click.option("--version", type=click.IntRange(1), help="Of this version; by default the present one.")
def schema(version: int | None) -> None:
    """Print the JSON Schema of one line of a recording, as in recordings/schema/."""
    import json

    from core.recording.json_schema import schema_of
    from core.recording.schema import VERSION

    try:
        say(json.dumps(schema_of(version or VERSION), indent=2, ensure_ascii=False))
    except ValueError as error:
        raise click.ClickException(str(error)) from error
