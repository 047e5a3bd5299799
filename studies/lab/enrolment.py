"""Who gets which place, code and order: decided while the ledger is locked, so that no two participants share
one.
"""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Literal

from core.numerics.clock import wall_time_utc
from core.numerics.streams import stream, stream_seed
from studies.lab.config import Study
from studies.lab.folder import sitting_path
from studies.lab.ledger import Enrolled, Ledger, LedgerError, Line, SittingStarted
from studies.lab.orders import order_of
from studies.lab.progress import Participant, SittingProgress, moment, progress
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import read_sitting

ALPHABET = "23456789ABCDEFGHJKMNPQRSTUVWXYZ"
"""Of drawn codes: nothing that looks like something else (0 and O, 1 and I and L)."""


Decision = Literal["resume", "restart"]
"""What an experimenter decides about a sitting that broke off, in place of the study's rule."""


class NotNow(ValueError):
    """A participant cannot begin or go on now; the message says why and what the experimenter can do."""


@dataclass(frozen=True, slots=True)
class Attempt:
    """What is to be done now: which sitting, from which step on."""

    code: str
    place: int
    order: tuple[str, ...]
    sitting: int
    number: int
    """Number of the attempt at this sitting, from 0."""
    run: int
    """How often the sitting was begun anew, from 0."""
    first_step: int
    anew: bool = False
    """The attempt before broke off, and the sitting begins from its first step."""

    @property
    def resumed(self) -> bool:
        """Whether the attempt before broke off and this one goes on with it."""
        return self.number > self.run and not self.anew

    def condition(self, block: int) -> str:
        """Return the condition of the participant's `block`-th block with an assigned condition, from 0."""
        return self.order[block] if len(self.order) > 1 else self.order[0]


def drawn_code(study: Study, ledger: Ledger, *, prefix: str | None = None) -> str:
    """Return a code that nobody has, and claim it.

    The codes follow from the study's seed in an order that says nothing about the condition.

    Args:
        study: whose codes are drawn.
        ledger: of the study.
        prefix: of the code, of simulated participants; the study's by default. Their letters are others.
    """
    draws = stream(study.seed, "codes" if prefix is None else "simulated codes")
    while True:
        letters = draws.integers(len(ALPHABET), size=study.codes.length)
        code = (study.codes.prefix if prefix is None else prefix) + "".join(
            ALPHABET[letter] for letter in letters
        )
        if ledger.claim("code", code):
            return code


def enrol(
    study: Study, ledger: Ledger, code: str, *, simulated: bool = False, now: datetime | None = None
) -> Enrolled:
    """Give a participant the lowest free place, and its order.

    Raises:
        NotNow: the code belongs to a participant already.
        LedgerError: the ledger cannot be used.
    """
    at = now or moment(wall_time_utc())

    def choose(lines: tuple[Line, ...]) -> Line:
        so_far = progress(lines)
        if code in so_far.participants:
            raise NotNow(f"{code} takes part already: leave the code out, and another one is drawn")
        place = so_far.free_place(study, at)
        # A claimed place without a line: another computer was killed in between, or its lock does not work.
        while not ledger.claim("place", f"{place}-{so_far.holders(place)}"):
            place += 1
        return Enrolled(
            at_utc=at.isoformat(timespec="seconds"),
            code=code,
            place=place,
            order=order_of(study, place),
            simulated=simulated,
        )

    written = ledger.decide(choose)
    assert isinstance(written, Enrolled), "what was chosen"
    return written


def begin_sitting(
    study: Study,
    ledger: Ledger,
    code: str,
    *,
    now: datetime | None = None,
    any_time: bool = False,
    decision: Decision | None = None,
    sha256: str = "",
) -> Attempt:
    """Begin the participant's next sitting, or go on with one that broke off, and write that to the ledger.

    Args:
        study: whose timeline it is.
        ledger: of the study.
        code: of the participant.
        now: with a time zone; the present time by default.
        any_time: do not ask how long ago the sitting before was (simulated participants).
        decision: of the experimenter about a sitting that broke off; None: the study's rule decides.
        sha256: of the study file; a sitting that another one began goes on only by `decision`.

    Raises:
        NotNow: there is nothing to do, it is too early or too late, or the study's rule refuses to go on.
    """
    at = now or moment(wall_time_utc())
    chosen: list[Attempt] = []

    def choose(lines: tuple[Line, ...]) -> Line:
        person = _known(progress(lines).participants, code)
        attempt = _next_attempt(study, person, at, any_time=any_time, decision=decision)
        if attempt.first_step and decision is None:
            _check_same_file(study, ledger.folder, attempt, sha256)
        chosen.append(attempt)
        return SittingStarted(
            at_utc=at.isoformat(timespec="seconds"),
            code=code,
            sitting=attempt.sitting,
            attempt=attempt.number,
            run=attempt.run,
            first_step=attempt.first_step,
            decided=decision,
        )

    ledger.decide(choose)
    return chosen[0]


def session_seed(study: Study, attempt: Attempt, step: int) -> int:
    """Return the root seed of a session: it follows from study, place, sitting, step and run.

    A resumed attempt keeps the seed of the attempt that it goes on with.
    """
    return stream_seed(study.seed, "session", attempt.place, attempt.sitting, step, attempt.run)


def _known(people: dict[str, Participant], code: str) -> Participant:
    if code not in people:
        raise NotNow(f"nobody with the code {code} takes part in this study: check the code")
    return people[code]


def _next_attempt(
    study: Study, person: Participant, now: datetime, *, any_time: bool, decision: Decision | None
) -> Attempt:
    if person.withdrawn:
        raise NotNow(f"{person.code} has withdrawn")
    if person.dropped_out is not None:
        raise NotNow(f"{person.code} counts as dropped out ({person.dropped_out})")
    number = person.next_sitting(study)
    if number == len(study.sittings):
        raise NotNow(f"{person.code} has finished: there is nothing left to do")
    _check_order(study, person)
    before = person.sittings.get(number)
    if before is None:
        if decision is not None:
            raise NotNow(f"{person.code} has no sitting that broke off: leave --broken-off out")
        if not any_time:
            _check_interval(study, person, number, now)
        return Attempt(person.code, person.place, person.order, number, 0, 0, 0)
    return _again(study, person, number, before, now, decision)


def _check_order(study: Study, person: Participant) -> None:
    """Check that the study file still has what the participant was promised with their place.

    Raises:
        NotNow: it lacks a condition of their order, or has another number of blocks.
    """
    unknown = [name for name in dict.fromkeys(person.order) if name not in study.conditions]
    if unknown:
        found = f"has no condition {', '.join(map(repr, unknown))}, only {', '.join(study.conditions)}"
    elif len(person.order) not in (1, study.assigned_blocks):
        found = f"has {study.assigned_blocks} blocks with an assigned condition, not {len(person.order)}"
    else:
        return
    raise NotNow(
        f"{person.code} was enrolled with the order {', '.join(person.order)}, and the study file {found}. A "
        "running study keeps its conditions and blocks: change the file back, or give the changed study a "
        f"name of its own. `arl study drop STUDY {person.code}` gives the place to another participant"
    )


def _check_same_file(study: Study, data: Path, attempt: Attempt, sha256: str) -> None:
    """Check that the study file is the one with which a sitting began: its steps count by their place.

    Raises:
        NotNow: it is another one.
    """
    try:
        header, _ = read_sitting(sitting_path(data, attempt.code, attempt.sitting, attempt.number - 1))
    except (SealedFileError, OSError):
        return  # `arl study status` names it
    if sha256 not in ("", header.study_sha256):
        raise NotNow(
            f"the study file was changed after {attempt.code} began the sitting "
            f"{study.sittings[attempt.sitting].name!r} (version {header.study_version} then, {study.version} "
            f"now), and steps count by their place in it. Put the old file back; or, where the steps are the "
            f"same, add --broken-off resume; or begin the sitting anew: --broken-off restart"
        )


def _check_interval(study: Study, person: Participant, number: int, now: datetime) -> None:
    if number == 0:
        return
    sitting, ended = study.sittings[number], person.sittings[number - 1].last_sign
    assert ended is not None, "a finished sitting has lines"
    earliest = ended + timedelta(hours=sitting.after_hours)
    if now < earliest:
        raise NotNow(
            f"{person.code}: the sitting {sitting.name!r} may begin {_when(earliest)}, "
            f"{sitting.after_hours:g} h after the one before"
        )
    if sitting.within_hours is not None and now > ended + timedelta(hours=sitting.within_hours):
        raise NotNow(
            f"{person.code} comes too late: the sitting {sitting.name!r} had to begin within "
            f"{sitting.within_hours:g} h, by {_when(ended + timedelta(hours=sitting.within_hours))}. `arl "
            f"study drop STUDY {person.code}` gives the place to another participant"
        )


def _again(
    study: Study,
    person: Participant,
    number: int,
    before: SittingProgress,
    now: datetime,
    decision: Decision | None,
) -> Attempt:
    rule, last = study.resuming, before.last_sign
    assert last is not None, "a sitting that was begun has lines"
    age = now - last
    begun = f"{person.code} began the sitting {study.sittings[number].name!r}, and it ended early"
    advice = (
        "Add --broken-off resume to go on after the last finished game, or --broken-off restart to begin the "
        f"sitting anew. `arl study drop STUDY {person.code}` gives the place to another participant"
    )
    if decision is None and rule.rule == "refuse":
        raise NotNow(f'{begun}; [resuming] rule = "refuse" leaves it to you. {advice}')
    if decision is None and age > timedelta(hours=rule.within_hours):
        raise NotNow(
            f"{begun} {age.total_seconds() / 3600:.1f} h ago; [resuming] within_hours allows "
            f"{rule.within_hours:g} h. {advice}"
        )
    anew = (decision or rule.rule) == "restart"
    first = 0 if anew else before.next_step(len(study.sittings[number].steps))
    return Attempt(
        person.code, person.place, person.order, number, before.attempts, before.run + anew, first, anew
    )


def _when(at: datetime) -> str:
    return at.astimezone(UTC).strftime("on %Y-%m-%d at %H:%M UTC")


__all__ = [
    "ALPHABET",
    "Attempt",
    "Decision",
    "LedgerError",
    "NotNow",
    "begin_sitting",
    "drawn_code",
    "enrol",
    "session_seed",
]
