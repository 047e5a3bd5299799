"""`arl recordings`: what there is, what it holds, how it ended, and whether it is whole."""

import csv
import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import click
import msgspec

from arl_tui.command_line import say
from arl_tui.home import elsewhere, recordings_folder, why_here
from arl_tui.recordings import CALIBRATION_FOLDER, all_recordings
from core.recording.reader import RecordingError
from core.recording.skim import Skimmed, skim_recording
from core.system.foreign_text import in_table, printable
from core.system.whole_file import whole_file

Found = tuple[Path, Skimmed | None, str]
"""A file; what it holds, None where it is damaged; and the reason."""


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """A line of the table that `--csv` writes; empty where a damaged file does not tell."""

    file: str
    state: str
    """"sound", or "damaged"."""
    reason: str = ""
    """Why it is damaged."""
    notes: str = ""
    """What is unusual about a sound file, separated by "; "."""
    goes_on_with: str = ""
    """Older recordings that are part of the session, separated by "; ": they have no line of their own."""
    participant: str = ""
    origin: str = ""
    created_utc: str = ""
    format_version: int | str = ""
    game: str = ""
    protocol: str = ""
    condition: str = ""
    games_planned: int | str = ""
    games_begun: int | str = ""
    games_finished: int | str = ""
    steps: int | str = ""
    presses_counted: int | str = ""
    presses_of_people: str = ""
    """Of several people at one keyboard: code and number of each, separated by "; "."""
    presses_by_value: str = ""
    """Of graded feedback: value and number of each, separated by "; "."""
    presses_simulated: int | str = ""
    """Of those that counted."""
    presses_taken_back: int | str = ""
    gaps: int | str = ""
    focus_lost: int | str = ""
    ended: str = ""
    """A word that never changes: finished, participant, window-closed, ... (`core.recording.summary`)."""
    ended_in_words: str = ""


def list_all(folder: Path, *, csv_path: Path | None = None) -> None:
    """Print what each recording holds; leave with status 1 if one of them is damaged."""
    why = f" ({why_here()})" if folder == recordings_folder() else ""
    problems: list[OSError] = []
    found = as_sessions(read_all(folder, problems))
    if found:
        say(f"Recordings in {folder}{why}:")
    else:
        say(f"There are no recordings in {folder}{why}. `arl demo` makes one.")
    for path, recording, reason in found:
        tell_one(path, folder, recording, reason)
    for error in problems:
        say(f"UNREADABLE  {error.filename}: {error.strerror}", fg="red")
    n_damaged = sum(recording is None for _, recording, _ in found)
    tell_rest(folder, found, n_damaged)
    if csv_path is not None:
        write_csv(csv_path, found)
        say(f"Table: {csv_path}")
    if n_damaged or problems:
        raise SystemExit(1)


def read_all(folder: Path, problems: list[OSError], *, whole_sessions: bool = True) -> Iterator[Found]:
    """Read every recording in a folder and below; no damaged one hides another.

    Args:
        folder: where to look.
        problems: takes folders that cannot be read.
        whole_sessions: name a recording as damaged, too, that goes on with another one which is damaged or
            missing.
    """
    for path in all_recordings(folder, problems.append):
        try:
            yield path, skim_recording(path, whole_session=whole_sessions), ""
        except (RecordingError, OSError) as error:
            yield path, None, str(error)


def as_sessions(found: Iterable[Found]) -> list[Found]:
    """Return one entry per session: a recording that another one goes on with is part of that one."""
    sessions = list(found)
    parts = {older for _, skimmed, _ in sessions if skimmed is not None for older in skimmed.older}
    return [one for one in sessions if one[0] not in parts]


def tell_one(path: Path, folder: Path, recording: Skimmed | None, reason: str) -> None:
    """Print the lines about one file."""
    name = printable(str(path.relative_to(folder)), longest=None)
    if recording is None:
        say(f"{name}  DAMAGED", fg="red")
        say(f"    {printable(reason, longest=None)}")
        return
    header = recording.header
    when = header.created_utc
    if when[:1].isdigit():  # else it was removed
        when = when.removesuffix("+00:00").replace("T", " ") + " UTC"
    say(name, nl=False, bold=True)
    say(printable(f"  {header.participant}  {header.origin}  {when}"))
    say(f"    {printable(recording.summary.words)}")
    for older in recording.older:
        say(f"    goes on with {printable(older.name)}: both are one session")
    for note in recording.notes:
        say(f"    beware: {printable(note, longest=None)}")


def tell_rest(folder: Path, found: Sequence[Found], n_damaged: int) -> None:
    """Print how many there are of what, and where there are others."""
    if found:
        say(f"{len(found) - n_damaged} sound, {n_damaged} damaged.")
    n_trials = sum(1 for _ in (folder / CALIBRATION_FOLDER).glob("*.jsonl"))
    if n_trials:
        files = "1 file" if n_trials == 1 else f"{n_trials} files"
        say(f"Calibrations: {files} of trials in {folder / CALIBRATION_FOLDER} (`arl fit` reads them).")
    old = elsewhere(folder)
    if old is not None and folder == recordings_folder():
        move = shlex.join(["mv", str(old.absolute()), str(folder)])
        say(
            f"There are recordings in {old.absolute()}, too, where earlier versions kept them: `arl "
            f"recordings --recordings {shlex.quote(str(old))}`, or move them: `{move}`"
        )


def row_of(path: Path, recording: Skimmed | None, reason: str) -> Row:
    """Return the line of the table for one file."""
    if recording is None:
        return Row(file=str(path), state="damaged", reason=reason)
    header = recording.header
    held = recording.summary
    return Row(
        file=str(path),
        state="sound",
        notes="; ".join(recording.notes),
        goes_on_with="; ".join(older.name for older in recording.older),
        participant=header.participant,
        origin=header.origin,
        created_utc=header.created_utc,
        format_version=header.version,
        game=held.game,
        protocol=held.protocol,
        condition=held.condition,
        games_planned="" if held.games_planned is None else held.games_planned,
        games_begun=held.games_begun,
        games_finished=held.games_finished,
        steps=held.steps,
        presses_counted=held.presses_counted,
        presses_of_people="; ".join(f"{name} {n}" for name, n in held.presses_of_people),
        presses_by_value="; ".join(f"{value:g} {n}" for value, n in held.presses_by_value),
        presses_simulated=held.presses_simulated,
        presses_taken_back=held.presses_taken_back,
        gaps=held.gaps,
        focus_lost=held.focus_lost,
        ended=held.ending.kind,
        ended_in_words=held.ending.words,
    )


def write_csv(path: Path, found: Sequence[Found]) -> None:
    """Write a line per file, damaged ones too."""
    # A file's name may hold bytes that are no UTF-8.
    with whole_file(path, errors="backslashreplace") as file:
        writer = csv.DictWriter(file, [field.name for field in msgspec.structs.fields(Row)])
        writer.writeheader()
        writer.writerows(in_table(msgspec.structs.asdict(row_of(*one))) for one in found)


def publish_all(folder: Path, into: Path) -> None:
    """Copy all sound recordings of a folder without dates; name the damaged ones and leave with status 1."""
    from core.recording.publish import publish_folder

    if into.exists() and any(into.iterdir()):
        raise click.ClickException(f"{into} is not empty: name a new folder")
    if into.resolve().is_relative_to(folder.resolve()):
        raise click.ClickException(
            f"{into} lies in {folder}, and each session would be listed twice: name a folder elsewhere"
        )
    problems: list[OSError] = []
    found = list(read_all(folder, problems, whole_sessions=False))
    for path, copy in publish_folder([path for path, recording, _ in found if recording is not None], into):
        say(f"{path} -> {copy}")
    damaged = [reason for _, recording, reason in found if recording is None]
    for reason in [*damaged, *map(str, problems)]:
        say(f"Not copied: {printable(reason, longest=None)}", err=True)
    if damaged or problems:
        raise SystemExit(1)
