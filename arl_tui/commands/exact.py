"""Running a recording again: shared by `arl replay` and `arl demo`."""

from pathlib import Path

import click
import msgspec

from core.protocol import Protocol
from core.recording.reader import Recording, RecordingError, read_recording


def read_or_stop(path: Path, *, allow_truncated: bool) -> Recording:
    """Read a recording; stop with the reason where that is impossible."""
    try:
        return read_recording(path, allow_truncated=allow_truncated)
    except (RecordingError, OSError) as error:
        raise click.ClickException(str(error)) from error


def run_again(recording: Recording) -> None:
    """Run a recording again and say that it came out the same; leave with status 1 where it did not."""
    # Compiled code comes with these.
    from core.replay import replay_exactly
    from core.session import build_session

    try:
        protocol = msgspec.convert(recording.header.protocol, Protocol)
        result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    except msgspec.ValidationError as error:
        raise click.ClickException(f"{recording.path}:1: the protocol cannot be used: {error}") from error
    except RecordingError as error:
        raise click.ClickException(str(error)) from error
    if result.difference is not None:
        raise click.ClickException(
            f"the replay differs from the recording after {result.outputs} equal outputs\n  {result.difference}"
        )
    click.echo(f"Replay: exact ({result.outputs} outputs equal, the weights bit for bit)")
    if not recording.complete:
        click.echo("The session was cut off; everything up to there came out the same.")
