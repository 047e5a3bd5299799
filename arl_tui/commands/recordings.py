"""`arl recordings`: what there is, and whether it is whole."""

from pathlib import Path

import click

from arl_tui.recordings import all_recordings
from core.episode import EpisodeEnded, KeyPressed
from core.recording.reader import Recording, RecordingError, read_recording


def list_all(folder: Path) -> None:
    """Print one line per recording; leave with status 1 if one of them is damaged."""
    damaged = 0
    found = False
    for path in all_recordings(folder):
        found = True
        try:
            click.echo(describe(read_recording(path)))
        except (RecordingError, OSError) as error:
            damaged += 1
            click.echo(click.style(f"DAMAGED  {error}", fg="red"))
    if not found:
        click.echo(f"There are no recordings in {folder}. `arl demo` makes one.")
    if damaged:
        raise SystemExit(1)


def describe(recording: Recording) -> str:
    """Return one line: file, participant, when, how much, whether whole."""
    header = recording.header
    episodes = sum(isinstance(event, EpisodeEnded) for event in recording.events)
    accepted = sum(
        isinstance(event, KeyPressed) and event.verdict == "accepted" for event in recording.events
    )
    whole = "complete" if recording.complete else "cut off "
    return (
        f"{whole}  {header.origin:9}  {header.participant:8}  {header.created_utc}  "
        f"{episodes:3} episodes  {accepted:4} presses  {recording.path}"
    )
