"""`arl recordings --make-key` and `--verify`: signatures of recordings."""

from pathlib import Path

import click

from arl_tui.command_line import say
from arl_tui.recordings import all_recordings
from core.recording.reader import RecordingError, read_recording
from core.recording.signature import SigningError, make_key, public_key, verify


def make_new_key(path: Path) -> None:
    """Make a key and say what to do with it."""
    try:
        public = make_key(path)
    except SigningError as error:
        raise click.ClickException(str(error)) from error
    except FileExistsError as error:
        raise click.ClickException(
            f"{error.filename}: there is such a file; keys are never overwritten"
        ) from error
    say(f"Private key: {path} (keep it where only you can read it)")
    say(f"Public key: {public} (give it to those who are to verify your recordings)")
    say(f"Sign every session from now on: export ARL_SIGNING_KEY={path.absolute()}")


def verify_all(folder: Path, key_path: Path) -> None:
    """Say of each recording whether it was signed with a key; leave with status 1 where one was not."""
    try:
        key = public_key(key_path)
    except SigningError as error:
        raise click.ClickException(str(error)) from error
    problems: list[OSError] = []
    verdicts: list[str] = []
    for path in all_recordings(folder, problems.append):
        try:
            verdicts.append(verify(read_recording(path), key))
        except (RecordingError, OSError) as error:
            verdicts.append(f"damaged: {error}")
        say(f"{path.relative_to(folder)}  {verdicts[-1]}", fg="green" if verdicts[-1] == "signed" else "red")
    for problem in problems:
        say(f"UNREADABLE  {problem.filename}: {problem.strerror}", fg="red")
    n_signed = verdicts.count("signed")
    say(f"{n_signed} of {len(verdicts)} recordings were signed with {key_path} and not changed since.")
    if problems or n_signed < len(verdicts):
        raise SystemExit(1)
