"""`arl recordings`: its options; the list is made by `recordings`."""

from pathlib import Path

import click

from arl_tui.command_line import ToWrite, recordings_option


@click.command(name="recordings", short_help="List the recordings there are, and check each.")
@recordings_option(to_write=False)
@click.option("--csv", "csv_path", type=ToWrite(), help="Write the list to a file, with everything it says.")
@click.option(
    "--publish",
    type=ToWrite(folder=True),
    metavar="DIR",
    help="Copy all sound recordings into a new folder, without dates in headers and names, chained anew.",
)
def list_recordings(recordings: Path, csv_path: Path | None, publish: Path | None) -> None:
    """List the recordings there are, with what each holds and how its session ended, and check each.

    Status 1 where a file is damaged: each of them is named with its reason, and hides no other.
    """
    from arl_tui.commands.recordings import list_all, publish_all

    if publish is not None:
        publish_all(recordings, publish)
        return
    list_all(recordings, csv_path=csv_path)
