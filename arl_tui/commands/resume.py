"""`arl play --resume FILE`: a session that broke off goes on after its last finished game."""

from collections.abc import Iterator
from pathlib import Path

import click
from click.core import ParameterSource

from arl_tui.command_line import say
from arl_tui.commands.exact import protocol_of
from arl_tui.commands.play import need_terminal, run_live, tell
from arl_tui.recordings import ENDINGS
from core.numerics.clock import MonotonicClock
from core.recording.joined import FinishedPart, ResumeError, finished_part, older_path, read_session
from core.recording.reader import Recording, RecordingError, read_recording
from core.system.foreign_text import printable


def resume_session(context: click.Context, path: Path) -> None:
    """Go on with a session in this terminal, and say where the rest of its recording is.

    Args:
        context: of `arl play`, whose other options must not be given.
        path: the newest recording of the session.
    """
    _refuse_other_options(context)
    need_terminal("arl play", instead="arl demo")
    try:
        recording, kept = part_to_go_on_with(path)
    except (RecordingError, OSError) as error:
        raise click.ClickException(printable(str(error), longest=None)) from error
    header, protocol = recording.header, protocol_of(recording)
    say(
        f"Session of {header.participant}: goes on after {kept.games} of {protocol.session.episodes} games. "
        f"What has been recorded stays in {path}"
    )
    outcome = run_live(
        protocol,
        participant=header.participant,
        seed=header.root_seed,
        recordings=path.parent,
        source=credit_facts(recording),
        study=header.study,
        kept=kept,
    )
    tell(outcome)


def part_to_go_on_with(path: Path) -> tuple[Recording, FinishedPart]:
    """Return a session, and what it had done up to its last finished game.

    Raises:
        ResumeError: it cannot go on, or another recording goes on with it already.
        RecordingError: a file is damaged or missing.
        OSError: a file cannot be read.
    """
    recording = read_session(path)
    newer = next(going_on_with(path), None)
    if newer is not None:
        raise ResumeError(f"{path}: {newer} goes on with it already: resume that one (--resume {newer})")
    return recording, finished_part(recording, MonotonicClock().now_ns())


def going_on_with(path: Path) -> Iterator[Path]:
    """Yield the recordings in the same folder that go on with this one; damaged ones are passed over."""
    for other in sorted(path.parent.iterdir()):
        if other == path or not other.name.endswith(ENDINGS):
            continue
        try:
            resumes = read_recording(other).header.resumes
        except (RecordingError, OSError):
            continue  # `arl recordings` names it
        if resumes is not None and older_path(other, resumes) == path:
            yield other


def credit_facts(recording: Recording) -> dict[str, str]:
    """Return what the header says of the credit rule: the rest of the session goes by the same one."""
    return {name: value for name, value in recording.header.source.items() if name.startswith("credit")}


def _refuse_other_options(context: click.Context) -> None:
    given = [
        f"--{name}" if name != "game" else "GAME"
        for name in context.params
        if name != "resume" and context.get_parameter_source(name) is ParameterSource.COMMANDLINE
    ]
    if given:
        raise click.UsageError(
            f"--resume goes on as the recording says: leave out {', '.join(given)} (the new file lies beside "
            f"the old one)"
        )
