"""Replay: run a session again from its recording alone, and compare every output."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import msgspec

from core.events import CreditGiven, Input, Output, SessionEnded
from core.numerics.clock import ManualClock
from core.recording.reader import Recording, RecordingError
from core.recording.version_1 import as_far_as_recorded
from core.session.session import Session


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
        return f"output {self.number}: {self.field} was {self.recorded!r} in the recording and is {self.replayed!r} now"


@dataclass(frozen=True, slots=True)
class ReplayResult:
    """What came of an exact replay."""

    outputs: int
    """Outputs that were compared and equal."""
    difference: Difference | None
    """The first difference, or None: then the replay is exact."""


class Recorded:
    """The recording as a source of feedback: gives each input out at the point where it was taken in."""

    def __init__(self, inputs: Sequence[Input]) -> None:
        self._inputs = inputs
        self._given = 0
        self.taken_before_next_output = 0
        """How many inputs had been taken in before the next output: set by whoever drives the replay."""

    def during(self, step: int) -> Iterable[Input]:
        """Return the inputs that were taken in at this point of the session."""
        upto = max(self.taken_before_next_output, self._given)
        given, self._given = self._inputs[self._given : upto], upto
        return given


def replay_exactly(recording: Recording, session: Session) -> ReplayResult:
    """Run `session` with the recording as clock and participant, and compare.

    Args:
        recording: a live or simulated session. One that was cut off, or whose agent died, is replayed up to there.
        session: a new session built from the recording's own protocol and root seed.

    Raises:
        RecordingError: the recording was imported, so there is nothing to run again.
    """
    if recording.header.origin == "imported":
        raise RecordingError(
            f"{recording.path}: imported from {recording.header.source.get('format', 'elsewhere')}: its agent cannot be "
            "run again. Ask what other credit rules and schemes would have learned from it: --credit RULE"
        )
    compared = 0
    for recorded, replayed in _run_both(recording, session):
        if recorded is None and replayed is None:
            break
        if recorded is not None and replayed is not None:
            replayed = as_far_as_recorded(recorded, replayed)
        if recorded != replayed:
            return ReplayResult(compared, first_difference(compared, recorded, replayed))
        compared += 1
    return ReplayResult(compared, None)


def _run_both(recording: Recording, session: Session) -> Iterator[tuple[Output | None, Output | None]]:
    """Yield recorded and replayed outputs side by side; None where one of the two has ended."""
    outputs = recording.outputs
    # A resumed session's older part may have been shifted to times before zero.
    first_ns = next((output.time_ns for output in outputs if not isinstance(output, CreditGiven)), 0)
    source, clock = Recorded(recording.inputs), ManualClock(first_ns)
    run = session.run(source, clock)
    for number, recorded in enumerate(outputs):
        timed = next((output for output in outputs[number:] if not isinstance(output, CreditGiven)), None)
        if timed is not None:
            source.taken_before_next_output = timed.inputs
            clock.advance_to_ns(timed.time_ns)
        else:
            return  # cut off while presses were being credited: what had been taken in is not known
        yield recorded, next(run, None)
    if outputs and isinstance(outputs[-1], SessionEnded):
        yield None, next(run, None)


def first_difference(number: int, recorded: Output | None, replayed: Output | None) -> Difference:
    """Return in which field two outputs that are not equal differ."""
    if recorded is None or replayed is None or type(recorded) is not type(replayed):
        return Difference(number, "type", type(recorded).__name__, type(replayed).__name__)
    before, now = msgspec.structs.asdict(recorded), msgspec.structs.asdict(replayed)
    field = next(name for name in before if before[name] != now[name])
    return Difference(number, field, before[field], now[field])
