"""Replay: run a session again from its recording alone, and compare every output."""

import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import msgspec

from core.events import CreditGiven, Input, Output, SessionEnded, UnseenPlayed
from core.feedback.asking_config import AskingConfig
from core.feedback.keys import KeyConfig
from core.feedback.people import PersonConfig, keys_of_person
from core.numerics.clock import ManualClock
from core.recording.reader import RecordingError
from core.recording.stored import AnyRecording
from core.recording.version_1 import as_far_as_recorded
from core.session.inputs import check_inputs
from core.session.session import Session

TOLD_EVERY = 1000
"""Outputs between two words about progress."""


@dataclass(frozen=True, slots=True)
class Difference:
    """The first output that came out otherwise than recorded."""

    number: int
    """Number of the output in the recording, from 0."""
    field: str
    """The field that differs; "type" where another kind of output came."""
    recorded: object
    replayed: object

    def __str__(self) -> str:
        return (
            f"output {self.number}: {self.field} was {self.recorded!r} in the recording and is "
            f"{self.replayed!r} now"
        )


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """What came of an exact replay."""

    outputs: int
    """Outputs that were compared and equal."""
    difference: Difference | None
    """The first difference, or None: then the replay is exact."""


class Recorded:
    """The recording as a source of feedback: gives each input out at the point where it was taken in."""

    def __init__(self, inputs: Iterable[Input] = ()) -> None:
        self._waiting = deque(inputs)
        self.given = 0
        """How many inputs have been given out: the last of them is being acted on."""
        self.taken_before_next_output = 0
        """How many inputs had been taken in before the next output: set by what drives the replay."""

    def add(self, event: Input) -> None:
        """Append the recording's next input."""
        self._waiting.append(event)

    def during(self, step: int) -> Iterator[Input]:
        """Yield the inputs that were taken in at this point of the session."""
        while self._waiting and self.given < self.taken_before_next_output:
            self.given += 1
            yield self._waiting.popleft()


@contextmanager
def naming_the_input(recording: AnyRecording, source: Recorded) -> Iterator[None]:
    """Turn what stops a session into the error of a recording, with the line of the input that was acted on.

    Raises:
        RecordingError: an input makes no sense where it stands; instead of the error that it led to.
    """
    try:
        yield
    except (ValueError, LookupError, ArithmeticError) as error:
        places = (n for n, event in enumerate(recording.events) if isinstance(event, Input))
        place = next(itertools.islice(places, max(source.given - 1, 0), None), 0)
        raise RecordingError(
            f"{recording.path}:{recording.line_of(place)}: no session can go on from this input: "
            f"{type(error).__name__}: {error}. The file was changed after it was recorded, or another "
            f"program wrote it"
        ) from error


def replay_exactly(
    recording: AnyRecording,
    session: Session,
    *,
    on_progress: Callable[[int], None] = lambda events: None,
    on_unseen: Callable[[int, int], None] = lambda done, count: None,
) -> ReplayResult:
    """Run `session` with the recording as clock and participant, and compare.

    Args:
        recording: a live or simulated session. One that was cut off, or whose agent died, is replayed up to
            there. Its events are gone over twice, in their order, and not kept.
        session: a new session built from the recording's own protocol and root seed.
        on_progress: called with how many outputs were compared since the last call, about `TOLD_EVERY`.
        on_unseen: called after each unseen episode with how many of its block are done, and how many it has.

    Raises:
        RecordingError: the recording was imported, so there is nothing to run again; or an input cannot have
            happened where it stands (`core.session.inputs`).
    """
    if recording.header.origin == "imported":
        raise RecordingError(
            f"{recording.path}: imported from {recording.header.source.get('format', 'elsewhere')}: its "
            "agent cannot be run again. Ask what other credit rules and schemes would have learned from it: "
            "--credit RULE"
        )
    protocol = recording.header.protocol
    asking = protocol.get("agent", {}).get("asking", {})
    check_inputs(recording, _keys_of(protocol), msgspec.convert(asking, AskingConfig, strict=False))
    compared = 0
    try:
        for recorded, replayed in _run_both(recording, session, on_unseen):
            if recorded is None and replayed is None:
                break
            if recorded is not None and replayed is not None:
                replayed = as_far_as_recorded(recorded, replayed)
            if recorded != replayed:
                return ReplayResult(compared, first_difference(compared, recorded, replayed))
            compared += 1
            if compared % TOLD_EVERY == 0:
                on_progress(TOLD_EVERY)
    except _Otherwise as found:
        return ReplayResult(compared, Difference(compared, found.field, found.recorded, found.replayed))
    return ReplayResult(compared, None)


class _Otherwise(Exception):
    """An output will come out otherwise than recorded, which is known before it is there."""

    def __init__(self, field: str, recorded: object, replayed: object) -> None:
        self.field, self.recorded, self.replayed = field, recorded, replayed


def _keys_of(protocol: Mapping[str, Any]) -> list[KeyConfig]:
    """Return the keys of each participant at the keyboard, from a header's protocol."""
    shared = msgspec.convert(protocol.get("keys", {}), KeyConfig)
    people = msgspec.convert(protocol.get("people", []), list[PersonConfig])
    return [keys_of_person(person, shared) for person in people] or [shared]


def _run_both(
    recording: AnyRecording, session: Session, on_unseen: Callable[[int, int], None]
) -> Iterator[tuple[Output | None, Output | None]]:
    """Yield recorded and replayed outputs side by side; None where one of the two has ended.

    Where the file ends while presses were being credited, it is not known what had been taken in: those are
    left out.
    """
    # A resumed session's older part may have been shifted to times before zero.
    outputs = (event for event in recording.events if isinstance(event, Output))
    first_ns = next((output.time_ns for output in outputs if not isinstance(output, CreditGiven)), 0)
    source, clock = Recorded(), ManualClock(first_ns)
    run = session.run(source, clock)
    recorded: Output | None = None

    def unseen(done: int, count: int) -> None:
        # Found at the first episode: a protocol may ask for more of them than can be played in a lifetime.
        if not isinstance(recorded, UnseenPlayed):
            raise _Otherwise("type", type(recorded).__name__, UnseenPlayed.__name__)
        if len(recorded.policies) != count:
            raise _Otherwise("number of policies", len(recorded.policies), count)
        on_unseen(done, count)

    session.after_unseen = unseen
    credited: list[CreditGiven] = []
    last: Output | None = None
    with naming_the_input(recording, source):
        for event in recording.events:
            if not isinstance(event, Output):
                source.add(event)
                continue
            last = event
            if isinstance(event, CreditGiven):
                credited.append(event)
                continue
            source.taken_before_next_output = event.inputs
            clock.advance_to_ns(event.time_ns)
            for recorded in (*credited, event):
                yield recorded, next(run, None)
            credited.clear()
        if isinstance(last, SessionEnded):
            yield None, next(run, None)


def first_difference(number: int, recorded: Output | None, replayed: Output | None) -> Difference:
    """Return in which field two outputs that are not equal differ."""
    if recorded is None or replayed is None or type(recorded) is not type(replayed):
        return Difference(number, "type", type(recorded).__name__, type(replayed).__name__)
    before, now = msgspec.structs.asdict(recorded), msgspec.structs.asdict(replayed)
    field = next(name for name in before if before[name] != now[name])
    return Difference(number, field, before[field], now[field])
