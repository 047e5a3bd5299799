"""A session in several recordings: it was broken off, and went on in a new file after the last finished game.

The older file is never touched. The new one's header names it, its hash, and how many of its inputs and
outputs belong to the session (`core.recording.schema.Resumes`). `joined` puts both together, so that replay,
what-ifs and summaries see one session.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    Event,
    Input,
    KeyPressed,
    Output,
    SessionEnded,
    StopAsked,
)
from core.numerics.clock import NS_PER_S
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.schema import Header, Resumes

MARGIN_NS = NS_PER_S
"""An older recording ends at least so long before the new one begins."""
PACKED = ("", ".gz", ".bz2", ".xz")
"""What may have been added to the older file's name."""


class ResumeError(RecordingError):
    """A session cannot go on; the message says why, and what to do."""


@dataclass(frozen=True, slots=True)
class FinishedPart:
    """What a session that broke off had done up to its last finished game. Times are shifted already."""

    path: Path
    header: Header
    events: tuple[Event, ...]
    resumes: Resumes
    """What the new recording's header says about it."""

    @property
    def inputs(self) -> tuple[Input, ...]:
        """What the screen showed and the participant did, in order."""
        return tuple(event for event in self.events if isinstance(event, Input))

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What the domain and the agent did, in order."""
        return tuple(event for event in self.events if isinstance(event, Output))

    @property
    def games(self) -> int:
        """How many watched games are finished."""
        return sum(isinstance(event, EpisodeEnded) for event in self.events)

    @property
    def last_ns(self) -> int:
        """Time of its latest event."""
        return latest_ns(self.events)


def finished_part(recording: Recording, now_ns: int) -> FinishedPart:
    """Return what a session can go on with: all up to its last finished game, and what followed before the
    next one.

    A game that was cut short by the session's end is not part of it; nor are presses made during it.

    Args:
        recording: of a live session, joined with older ones (`joined`).
        now_ns: the present time of the clock by which the session goes on.

    Raises:
        ResumeError: the session is finished, has no finished game, or is not one that a participant can go on
            with.
    """
    _check_can_go_on(recording)
    inputs, outputs = recording.inputs, recording.outputs
    stopped_at = next((at for at, event in enumerate(inputs) if isinstance(event, StopAsked)), len(inputs))
    last = max(
        (
            at
            for at, output in enumerate(outputs)
            if isinstance(output, EpisodeEnded) and output.inputs <= stopped_at
        ),
        default=None,
    )
    if last is None:
        raise ResumeError(
            f"{recording.path}: no game was finished: begin anew (the same games come with "
            f"--seed {recording.header.root_seed})"
        )
    n_outputs, n_inputs = len(outputs), stopped_at
    for at in range(last + 1, len(outputs)):
        following = outputs[at]
        if isinstance(following, EpisodeStarted | SessionEnded):
            n_outputs = at
            if isinstance(following, EpisodeStarted):
                n_inputs = following.inputs
            break
    kept = _first(recording.events, n_inputs, n_outputs)
    shift_ns = min(0, now_ns - MARGIN_NS - latest_ns(kept))
    resumes = Resumes(
        file=recording.path.name,
        chain=recording.chain,
        inputs=n_inputs,
        outputs=n_outputs,
        shift_ns=shift_ns,
    )
    return FinishedPart(recording.path, recording.header, shifted(kept, shift_ns), resumes)


def _check_can_go_on(recording: Recording) -> None:
    path, origin = recording.path, recording.header.origin
    if origin != "live":
        raise ResumeError(f"{path}: of origin {origin}; only a session with a participant can go on")
    if any(isinstance(event, KeyPressed) and event.source == "simulated" for event in recording.events):
        raise ResumeError(f"{path}: a simulated participant pressed keys in it; begin anew (`arl demo`)")
    if any(isinstance(event, SessionEnded) for event in recording.events):
        stop = next((event for event in recording.inputs if isinstance(event, StopAsked)), None)
        if stop is None:
            raise ResumeError(f"{path}: this session is finished: there is nothing left to do")
        if stop.reason in ("time-limit", "practised"):
            why = (
                "has reached its time limit"
                if stop.reason == "time-limit"
                else "was a practice, which is complete"
            )
            raise ResumeError(f"{path}: this session {why}: there is nothing left to do")


def joined(recording: Recording) -> Recording:
    """Return the whole session: the older recordings' events that belong to it, then its own.

    Args:
        recording: as it was read. One that does not go on with another is returned as it is.

    Raises:
        RecordingError: the older recording is missing, was changed, or is of another session.
        OSError: it cannot be read.
    """
    resumes = recording.header.resumes
    if resumes is None or recording.older:
        return recording
    before = _older(recording, resumes)
    kept = _first(before.events, resumes.inputs, resumes.outputs)
    if len(kept) != resumes.inputs + resumes.outputs:
        raise RecordingError(
            f"{recording.path}: goes on after {resumes.inputs} inputs and {resumes.outputs} outputs of "
            f"{before.path}, "
            f"which holds {len(before.inputs)} and {len(before.outputs)}"
        )
    return replace(
        recording,
        events=(*shifted(kept, resumes.shift_ns), *recording.events),
        notes=(*before.notes, *recording.notes),
        older=(*before.older, before.path),
    )


def read_session(path: Path, *, allow_truncated: bool = True) -> Recording:
    """Read a recording, and the older ones that it goes on with, as one session.

    Args:
        path: of the newest recording.
        allow_truncated: as in `core.recording.reader.read_recording`; of older ones, the end is always
            missing.

    Raises:
        RecordingError: a file is damaged, missing or not the one that was recorded.
        OSError: a file cannot be read.
    """
    return joined(read_recording(path, allow_truncated=allow_truncated))


def older_path(path: Path, resumes: Resumes) -> Path:
    """Return where the recording lies that the one at `path` goes on with, packed or not."""
    at = path.parent / resumes.file
    return next((there for end in PACKED if (there := Path(f"{at}{end}")).exists()), at)


def latest_ns(events: Iterable[Event]) -> int:
    """Return the latest time that any of these events names; 0 where none does."""
    return max((time_ns for event in events for time_ns in _times(event).values()), default=0)


def shifted(events: Iterable[Event], shift_ns: int) -> tuple[Event, ...]:
    """Return the events with every time moved by `shift_ns`."""
    if shift_ns == 0:
        return tuple(events)
    return tuple(_moved(event, shift_ns) for event in events)


def _moved(event: Event, shift_ns: int) -> Event:
    times = {name: time_ns + shift_ns for name, time_ns in _times(event).items()}
    return msgspec.structs.replace(event, **times) if times else event


def _times(event: Event) -> dict[str, int]:
    """Return an event's points in time by field; durations are none."""
    if isinstance(event, CreditGiven):
        return {}
    names = ("time_ns", "flushed_ns", "last_ns", "shown_ns")
    return {name: getattr(event, name) for name in names if hasattr(event, name)}


def _first(events: Iterable[Event], n_inputs: int, n_outputs: int) -> tuple[Event, ...]:
    """Return the first inputs and outputs, so many of each, in the order in which they were recorded."""
    kept: list[Event] = []
    inputs_left, outputs_left = n_inputs, n_outputs
    for event in events:
        if isinstance(event, Input):
            if inputs_left:
                kept.append(event)
                inputs_left -= 1
        elif outputs_left:
            kept.append(event)
            outputs_left -= 1
    return tuple(kept)


def _older(recording: Recording, resumes: Resumes) -> Recording:
    path = older_path(recording.path, resumes)
    if path == recording.path:
        raise RecordingError(f"{recording.path}:1: the header says that this recording goes on with itself")
    try:
        before = read_recording(path)
    except FileNotFoundError as error:
        raise RecordingError(
            f"{recording.path}: goes on with {resumes.file}, which is not in its folder: keep both files "
            f"together"
        ) from error
    if before.chain != resumes.chain:
        raise RecordingError(
            f"{path}: not as it was when {recording.path.name} went on with it (its last chain is "
            f"{before.chain}, "
            f"and was {resumes.chain}). Take the unchanged file, from a backup or from where it was copied"
        )
    ours, theirs = recording.header, before.header
    if (ours.root_seed, ours.participant) != (theirs.root_seed, theirs.participant):
        raise RecordingError(
            f"{path}: of another session than {recording.path.name}, which goes on with it: seed or "
            f"participant differ"
        )
    return joined(before)
