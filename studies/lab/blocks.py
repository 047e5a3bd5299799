"""What has been recorded of a block so far: found in the participant's folder by what the headers say.

A sitting that was killed has left no line about its last recording. Each recording's header says which step
of which study it belongs to, so nothing that was recorded is overlooked.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from core.events import EpisodeEnded
from core.recording.joined import joined
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.summary import RecordingSummary, summarise_recording

SITTINGS = "sitting-"
"""How the names of records of sittings begin: files of another format."""


@dataclass(frozen=True, slots=True)
class BlockSoFar:
    """The recordings of one block, joined."""

    path: Path
    """Of the newest one."""
    recording: Recording
    summary: RecordingSummary

    @property
    def finished(self) -> bool:
        """Whether all games of the block were played."""
        return self.summary.ending.kind == "finished"

    @property
    def performances(self) -> tuple[float, ...]:
        """Of the watched games, the last of which may have been broken off."""
        return tuple(event.performance for event in self.recording.events if isinstance(event, EpisodeEnded))


def sessions_in(folder: Path, damaged: list[str] | None = None) -> Iterator[BlockSoFar]:
    """Yield the sessions in a participant's folder; a recording that another one goes on with is part of that
    one.

    Args:
        folder: of the participant.
        damaged: takes what is wrong with files that cannot be used; without it such a file is an error.

    Raises:
        RecordingError: a file is damaged, and `damaged` was not given.
    """
    found: list[Recording] = []
    parts: set[Path] = set()
    for path in sorted(folder.glob("*.jsonl")):
        if path.name.startswith(SITTINGS):
            continue
        try:
            recording = joined(read_recording(path))
        except (RecordingError, OSError) as error:
            if damaged is None:
                raise
            damaged.append(said_of(path, error))
            continue
        found.append(recording)
        parts.update(recording.older)
    for recording in found:
        if recording.path not in parts:
            yield BlockSoFar(recording.path, recording, summarise_recording(recording))


def said_of(path: Path, error: Exception) -> str:
    """Return what is wrong with a file, beginning with its name without folders."""
    reason = str(error).replace(str(path), path.name)
    return reason if reason.startswith(path.name) else f"{path.name}: {reason}"


def block_so_far(folder: Path, sitting: int, step: int, run: int) -> BlockSoFar | None:
    """Return what has been recorded of a block; None where nothing has.

    Args:
        folder: of the participant.
        sitting: number of the sitting, from 0.
        step: place of the block in it, from 0.
        run: how often the sitting was begun anew.

    Returns:
        Where the block was begun several times, because no game had been finished, the one with most games.

    Raises:
        RecordingError: a file is damaged, or one is missing that another goes on with.
    """
    wanted = {"sitting": str(sitting), "step": str(step), "run": str(run), "kind": "block"}
    mine = [
        session
        for session in sessions_in(folder)
        if all(session.recording.header.study.get(name) == value for name, value in wanted.items())
    ]
    return max(
        mine,
        key=lambda one: (one.summary.games_finished, one.recording.header.created_utc, one.path.name),
        default=None,
    )
