"""`arl recordings`: its options; the list is made by `recordings`."""

from pathlib import Path

import click

from arl_tui.command_line import FILE, ToWrite, recordings_option
from arl_tui.commands.recordings_format import schema, upgrade


@click.group(
    name="recordings",
    invoke_without_command=True,
    short_help="List the recordings there are, and check each.",
)
@recordings_option(to_write=False)
@click.option("--csv", "csv_path", type=ToWrite(), help="Write the list to a file, with everything it says.")
@click.option(
    "--publish",
    type=ToWrite(folder=True),
    metavar="DIR",
    help="Copy all sound recordings into a new folder, without dates in headers and names, chained anew. "
    "`arl anonymise` removes more.",
)
@click.option(
    "--verify",
    type=FILE,
    metavar="KEY",
    help="Say of each recording whether it was signed with this key (KEY.pub); status 1 where one was not.",
)
@click.option(
    "--make-key",
    type=ToWrite(),
    metavar="FILE",
    help="Make a key for signatures: FILE, which stays with you, and FILE.pub. Sessions sign where "
    "ARL_SIGNING_KEY names FILE.",
)
@click.pass_context
def list_recordings(
    context: click.Context,
    recordings: Path,
    csv_path: Path | None,
    publish: Path | None,
    verify: Path | None,
    make_key: Path | None,
) -> None:
    """List the recordings there are, with what each holds and how its session ended, and check each.

    Status 1 where a file is damaged: each of them is named with its reason, and hides no other.
    """
    if context.invoked_subcommand is not None:
        if any((csv_path, publish, verify, make_key)):
            raise click.UsageError(
                f"--csv, --publish, --verify and --make-key are not for {context.invoked_subcommand}: leave "
                f"them out"
            )
        return
    from arl_tui.commands.recordings import list_all, publish_all

    if make_key is not None or verify is not None:
        from arl_tui.commands.signatures import make_new_key, verify_all

        if make_key is not None:
            make_new_key(make_key)
        if verify is not None:
            verify_all(recordings, verify)
        return
    if publish is not None:
        publish_all(recordings, publish)
        return
    list_all(recordings, csv_path=csv_path)


list_recordings.add_command(upgrade)
list_recordings.add_command(schema)
