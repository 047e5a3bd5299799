"""Where each participant of a study is: worked out from the ledger's lines, never stored."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from typing import Literal, assert_never

from studies.lab.config import Study
from studies.lab.ledger import (
    ADVICE,
    Declined,
    DroppedOut,
    Enrolled,
    LedgerError,
    Line,
    Opened,
    SittingEnded,
    SittingStarted,
    StepDone,
    Withdrawn,
)

State = Literal["active", "finished", "dropped out", "withdrawn"]


@dataclass(slots=True)
class SittingProgress:
    """How far one sitting of a participant is."""

    attempts: int = 0
    """How often it was begun, or gone on with."""
    run: int = 0
    """How often it was begun anew."""
    steps_done: set[int] = field(default_factory=set)
    """Places of the finished steps, from 0."""
    ended: Literal["finished", "stopped", "window-closed", "failed"] | None = None
    """How the newest attempt ended; None: it is running, or was killed."""
    begun_at: datetime | None = None
    last_sign: datetime | None = None
    """Of the newest line about it."""

    def next_step(self, n_steps: int) -> int:
        """Return the place of the first step that is not done, `n_steps` if all are."""
        return next((place for place in range(n_steps) if place not in self.steps_done), n_steps)


@dataclass(slots=True)
class Participant:
    """One participant as the ledger knows them."""

    code: str
    place: int
    order: tuple[str, ...]
    simulated: bool
    last_sign: datetime
    sittings: dict[int, SittingProgress] = field(default_factory=dict)
    dropped_out: str | None = None
    """Why, if the participant counts as dropped out."""
    withdrawn: bool = False

    def state(self, study: Study, now: datetime) -> State:
        """Return whether the participant has finished, is still expected, or is gone.

        Args:
            study: whose rule says when a participant counts as dropped out.
            now: with a time zone.
        """
        if self.withdrawn:
            return "withdrawn"
        if all(
            number in self.sittings and self.sittings[number].ended == "finished"
            for number in range(len(study.sittings))
        ):
            return "finished"
        too_old = now - self.last_sign > timedelta(hours=study.dropouts.after_hours)
        return "dropped out" if self.dropped_out is not None or too_old else "active"

    def next_sitting(self, study: Study) -> int:
        """Return the number of the first sitting that is not finished, the number of sittings if all are."""
        return next(
            (
                number
                for number in range(len(study.sittings))
                if number not in self.sittings or self.sittings[number].ended != "finished"
            ),
            len(study.sittings),
        )


@dataclass(frozen=True, slots=True)
class Progress:
    """A study as far as it is."""

    participants: dict[str, Participant]
    """By code, in the order in which they came."""
    declined: int
    """How many did not consent."""

    def free_place(self, study: Study, now: datetime) -> int:
        """Return the lowest place that nobody holds.

        A finished or active participant holds their place. So does one who dropped out or withdrew, where the
        study does not replace them.
        """
        replaced = {
            "dropped out": study.dropouts.replace,
            "withdrawn": study.dropouts.replace_withdrawn,
            "active": False,
            "finished": False,
        }
        held = {
            person.place for person in self.participants.values() if not replaced[person.state(study, now)]
        }
        return next(place for place in range(len(held) + 1) if place not in held)

    def holders(self, place: int) -> int:
        """Return how many participants have had a place so far."""
        return sum(person.place == place for person in self.participants.values())


def progress(lines: Iterable[Line]) -> Progress:
    """Return where each participant is after these lines of a ledger.

    Raises:
        LedgerError: a line is of a participant who was not enrolled, or of a sitting that was not begun.
    """
    people: dict[str, Participant] = {}
    declined = 0
    for number, line in enumerate(lines, start=1):
        at = moment(line.at_utc)
        if isinstance(line, Declined):
            declined += 1
        elif isinstance(line, Enrolled):
            people[line.code] = Participant(line.code, line.place, line.order, line.simulated, at)
        elif not isinstance(line, Opened):
            try:
                _take(people[line.code], line, at)
            except KeyError as error:
                raise LedgerError(
                    f"ledger.jsonl:{number}: {line.__struct_config__.tag} of {line.code}: no line before "
                    f"enrols this participant, or begins this sitting. {ADVICE}"
                ) from error
    return Progress(people, declined)


def _take(
    person: Participant,
    line: SittingStarted | StepDone | SittingEnded | DroppedOut | Withdrawn,
    at: datetime,
) -> None:
    """Take in a line about a participant.

    Raises:
        KeyError: the sitting was not begun.
    """
    match line:
        case SittingStarted():
            sitting = person.sittings.setdefault(line.sitting, SittingProgress())
            sitting.attempts = line.attempt + 1
            sitting.run = line.run
            sitting.ended = None
            sitting.begun_at = sitting.last_sign = person.last_sign = at
            sitting.steps_done = {place for place in sitting.steps_done if place < line.first_step}
        case StepDone():
            sitting = person.sittings[line.sitting]
            sitting.steps_done.add(line.step)
            sitting.last_sign = person.last_sign = at
        case SittingEnded():
            sitting = person.sittings[line.sitting]
            sitting.ended = line.how
            sitting.last_sign = person.last_sign = at
        case DroppedOut():
            person.dropped_out = line.reason
        case Withdrawn():
            person.withdrawn = True
        case other:
            assert_never(other)


def moment(at_utc: str) -> datetime:
    """Return a time of the ledger as a moment in UTC."""
    return datetime.fromisoformat(at_utc).astimezone(UTC)
