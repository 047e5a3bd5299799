"""Closes the recording of a session, and saves elsewhere what its disk does not take."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from arl_tui.recordings import rescue, rescue_whole
from core.events import Event
from core.recording.recorder import Recorder

CLOSING_S = 10.0
"""The disk gets this long to take the rest of the recording, seconds."""


def close_recorder(recorder: Recorder, timeout_s: float = CLOSING_S) -> tuple[str | None, Path | None]:
    """Close a recording; return what is wrong with it in words, and where the recording is.

    Args:
        recorder: of the session.
        timeout_s: how long the disk may take, seconds.
    """
    try:
        recorder.close(timeout_s)
    except OSError as error:  # a TimeoutError is one
        problem = f"The recording is not complete: {error}"
        if isinstance(error, TimeoutError) and not recorder.unwritten:
            kept = recorder.kept
            problem = (
                f"The disk is too slow: all is written, but of {kept.recorded} events only {kept.synced} are "
                "known to be on the disk. Do not switch the computer off yet"
            )
            return problem, recorder.path
        try:
            return _rescue(recorder, problem)
        except OSError as second:
            lost = count_events(recorder.unwritten) or f"all {recorder.kept.recorded} events"
            problem += f"\nWhat is missing from it could not be saved elsewhere: {second}\n({lost})"
            return problem, None if isinstance(recorder.failure, FileNotFoundError) else recorder.path
    return None, recorder.path


def _rescue(recorder: Recorder, problem: str) -> tuple[str, Path | None]:
    """Save elsewhere what is not where it should be; return where, in words, and where the recording is."""
    path: Path | None = recorder.path
    if isinstance(recorder.failure, FileNotFoundError):
        path = rescue_whole(recorder.content(), recorder.path.stem)
        problem += f"\nWhat it held has been saved: move {path} to where you keep recordings"
    if recorder.unwritten:
        rest = rescue(recorder.unwritten, recorder.path.stem)
        problem += f"\nWhat could not be written to it is in {rest}\n({count_events(recorder.unwritten)})"
    return problem, path


def count_events(events: Iterable[Event]) -> str:
    """Return how many events there are of each kind, in words: "3 KeyPressed, 1 FrameShown"."""
    counts = Counter(type(event).__name__ for event in events)
    return ", ".join(f"{count} {name}" for name, count in counts.most_common())
