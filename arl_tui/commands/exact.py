"""Running a recording again: shared by `arl replay` and `arl demo`."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import click
import msgspec

from arl_tui.app import facts
from arl_tui.command_line import say
from core.events import SessionEnded
from core.recording.joined import read_session
from core.recording.reader import Recording, RecordingError
from core.recording.stored import AnyRecording, StoredRecording, stored_recording
from core.recording.summary import summarise_recording
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.system.foreign_text import printable

GETTING_READY = "Getting ready; the first time this may take half a minute ..."
"""Said where everything may have to be compiled first."""
WORTH_A_BAR = 20_000
"""Outputs from which on a replay shows how far it is."""
WORTH_A_BAR_UNSEEN = 20_000
"""Unseen episodes of a block from which on a replay shows how far it is: they take half a minute."""


def read_or_stop(path: Path, *, allow_truncated: bool) -> Recording:
    """Read a session and say what is unusual about its files; stop where they cannot be read."""
    try:
        recording = read_session(path, allow_truncated=allow_truncated)
    except (RecordingError, OSError) as error:
        raise click.ClickException(printable(str(error), longest=None)) from error
    for note in recording.notes:
        say(f"Beware: {printable(note, longest=None)}", err=True)
    for older in recording.older:
        say(f"Goes on with {printable(str(older), longest=None)}: both are taken as one session.", err=True)
    return recording


def open_or_stop(path: Path, *, allow_truncated: bool) -> AnyRecording:
    """Open a session to be run again: a long one stays on the disk. Otherwise as `read_or_stop`."""
    try:
        stored = stored_recording(path)
    except OSError as error:
        raise click.ClickException(printable(str(error), longest=None)) from error
    if stored is None or not (stored.complete or allow_truncated):
        return read_or_stop(path, allow_truncated=allow_truncated)
    for note in stored.notes:
        say(f"Beware: {printable(note, longest=None)}", err=True)
    return stored


def need_outputs(recording: AnyRecording) -> None:
    """Stop where a recording holds nothing that could come out the same, or be learned from."""
    if not recording.n_outputs:
        raise click.ClickException(
            f"{recording.path}: there is nothing to replay: no game is in the recording. "
            f"{summary_words(recording)}"
        )


def summary_words(recording: AnyRecording) -> str:
    """Return a recording's summary in words."""
    if isinstance(recording, StoredRecording):
        return recording.summary.words
    return summarise_recording(recording).words


def protocol_of(recording: AnyRecording) -> Protocol:
    """Return the protocol in a recording's header."""
    if recording.header.origin == "imported" and not recording.header.protocol:
        raise click.ClickException(
            f"{recording.path}: imported presses without the states and actions that they judge: nothing can "
            f"be replayed. "
            "`arl presses` reports them, `arl fit` fits their delays"
        )
    try:
        return protocol_from(recording.header.protocol)
    except msgspec.ValidationError as error:
        raise click.ClickException(f"{recording.path}:1: the protocol cannot be used: {error}") from error


def run_again(recording: AnyRecording) -> None:
    """Run a recording again and say that it came out the same; leave with status 1 where it did not."""
    # Compiled code comes with these.
    from core.session.replay import replay_exactly
    from core.session.session import build_session

    need_outputs(recording)
    session = build_session(protocol_of(recording), recording.header.root_seed)
    n_outputs = recording.n_outputs
    # A session of some minutes is replayed at once.
    bar = click.progressbar(
        length=n_outputs,
        label="Replaying",
        file=sys.stderr,
        hidden=n_outputs < WORTH_A_BAR,
        update_min_steps=1000,
    )
    try:
        with bar:
            result = replay_exactly(recording, session, on_progress=bar.update, on_unseen=_tell_unseen())
    except RecordingError as error:
        raise click.ClickException(str(error)) from error
    if result.difference is not None:
        raise click.ClickException(
            f"the replay differs from the recording after {result.outputs} equal outputs\n  "
            f"{result.difference}\n"
            f"{why_different(recording.header.software)}"
        )
    whole = isinstance(recording.last_output, SessionEnded)
    say(
        f"Replay: exact ({result.outputs} outputs equal"
        + (", the weights bit for bit)" if whole else "; the recording ends there, before the session's end)")
    )
    say(f"Session: {printable(summary_words(recording))}")


def _tell_unseen() -> Callable[[int, int], None]:
    """Return what shows how far a long block of unseen episodes is."""
    bar = click.progressbar(length=1, file=sys.stderr, hidden=True)  # of the block before the first one

    def tell(done: int, count: int) -> None:
        nonlocal bar
        if done == 1:
            few = count < WORTH_A_BAR_UNSEEN or not sys.stderr.isatty()
            bar = click.progressbar(length=count, label="Unseen episodes", file=sys.stderr, hidden=few)
        bar.update(1)
        if done == count:
            bar.render_finish()

    return tell


def why_different(software: Mapping[str, str]) -> str:
    """Return what may explain that a recording comes out otherwise: software that is not the one it was made
    with.
    """
    others = facts.differing(software)
    if not others:
        return (
            "The software is the same: this is a fault of the program, or a machine that computes otherwise. "
            "Please report it."
        )
    return (
        f"It was recorded with other software: {'; '.join(others)}. Where a game plays otherwise "
        "(CHANGELOG), only the commit that recorded it can replay it. Its presses can still be learned from, "
        "where it holds what was on screen: --credit RULE"
    )
