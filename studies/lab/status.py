"""What an experimenter sees of a running study: who is where, how balanced it is, and whose data look wrong.

Everything is read from the append-only files; nothing is written and no running session is disturbed.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from core.events import Event, KeyPressed, PressRetracted, WrongPressAsked
from studies.lab.blocks import SITTINGS, BlockSoFar, said_of, sessions_in
from studies.lab.config import Study, kind_of
from studies.lab.folder import participant_folder
from studies.lab.ledger import read_ledger
from studies.lab.minutes import minutes_of
from studies.lab.orders import order_of
from studies.lab.progress import Participant, progress
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import FileRecorded, QuestionAnswered, read_sitting

FEW_PRESSES_PER_GAME = 0.5
"""Fewer accepted presses per game than this are pointed out."""
ALWAYS_THE_SAME = 0.98
"""A fraction of one key among at least `ENOUGH_PRESSES` above this is pointed out."""
ENOUGH_PRESSES = 20
SILENT_MIN = 10.0
"""A sitting without an end whose files have not grown for so many minutes is pointed out."""
ENDED = {"stopped": ", stopped", "window-closed": ", window closed", "failed": ", failed"}
"""How an unfinished sitting ended, in words."""
ENOUGH_ASKED = 4
"""With fewer requests for a wrong press, nothing is said about how many were followed."""


@dataclass(frozen=True, slots=True)
class Row:
    """One participant, as a table shows them."""

    code: str
    place: int
    order: tuple[str, ...]
    state: str
    where: str
    """Sitting and step, in words."""
    minutes: float | None
    """From the first to the last sign of life, over all attempts at all sittings. Of a simulated participant:
    minutes of the simulated sessions; None where no record of a sitting can be read."""
    games: int
    presses_per_game: float | None
    """Accepted presses that were not taken back; None before the first game."""
    flags: tuple[str, ...]
    """What is worth a look, in words."""


@dataclass(frozen=True, slots=True)
class Status:
    """A study as far as it is."""

    rows: tuple[Row, ...]
    declined: int
    planned: int
    finished: int
    orders: tuple[tuple[tuple[str, ...], int], ...]
    """Each order, and how many have finished with it."""


def status(study: Study, data: Path, now: datetime, *, sha256: str = "") -> Status:
    """Return how far a study is.

    Args:
        study: from its file.
        data: folder of its data.
        now: with a time zone.
        sha256: of the study file; sittings that were led by another one are pointed out. "" points out none.

    Raises:
        SealedFileError: the ledger was changed.
        OSError: the ledger cannot be read.
    """
    so_far = progress(read_ledger(data / "ledger.jsonl"))
    rows = tuple(_row(study, sha256, data, person, now) for person in so_far.participants.values())
    finished = Counter(row.order for row in rows if row.state == "finished")
    orders = dict.fromkeys(order_of(study, place) for place in range(study.participants))
    return Status(
        rows,
        so_far.declined,
        study.participants,
        sum(finished.values()),
        tuple((order, finished[order]) for order in orders),
    )


def _row(study: Study, sha256: str, data: Path, person: Participant, now: datetime) -> Row:
    flags: list[str] = []
    games = presses = 0
    minutes = None
    if not person.withdrawn:
        folder = participant_folder(data, person.code)
        looked_at, minutes = _Recordings(folder), minutes_of(folder)
        flags = [*_silence(study, person, folder, now), *_lost(person, folder), *looked_at.flags()]
        others = sorted(version for version, sha in looked_at.led_by if sha256 not in ("", sha))
        if others:
            flags.append(
                f"led by another study file, of version {', '.join(others)} (now {study.version}): are its "
                f"steps the same?"
            )
        games, presses = looked_at.games, looked_at.presses
    return Row(
        person.code,
        person.place,
        person.order,
        person.state(study, now),
        _where(study, person),
        _ledger_minutes(person) if minutes is None and not person.simulated else minutes,
        games,
        presses / games if games else None,
        tuple(flags),
    )


def _ledger_minutes(person: Participant) -> float:
    """Return the minutes of each sitting's last attempt as the ledger knows them: its files are gone."""
    return sum(
        (sitting.last_sign - sitting.begun_at).total_seconds() / 60
        for sitting in person.sittings.values()
        if sitting.begun_at is not None and sitting.last_sign is not None
    )


def _where(study: Study, person: Participant) -> str:
    if person.withdrawn:
        return "withdrawn"
    number = person.next_sitting(study)
    if number == len(study.sittings):
        return "finished"
    sitting = study.sittings[number]
    if number not in person.sittings:
        return f"before {sitting.name}"
    steps = sitting.steps
    place = person.sittings[number].next_step(len(steps))
    if place == len(steps):
        return f"{sitting.name}: all steps done"
    ended = ENDED.get(person.sittings[number].ended or "", "")
    return f"{sitting.name}: step {place + 1} of {len(steps)} ({kind_of(steps[place])}){ended}"


def _silence(study: Study, person: Participant, folder: Path, now: datetime) -> Iterator[str]:
    """Yield that a sitting seems to have broken off: it has no end, and its files have not grown for long."""
    number = person.next_sitting(study)
    if number not in person.sittings or person.sittings[number].ended is not None:
        return
    last_s = max((path.stat().st_mtime for path in folder.rglob("*.jsonl")), default=now.timestamp())
    silent_min = (now.timestamp() - last_s) / 60
    if silent_min > SILENT_MIN:
        yield f"no sign of life for {silent_min:.0f} minutes: did the sitting break off?"


def _lost(person: Participant, folder: Path) -> Iterator[str]:
    """Yield which sittings were begun and have no record any more."""
    for number, sitting in person.sittings.items():
        if sitting.attempts and not any(folder.glob(f"{SITTINGS}{number + 1}[.-]*")):
            yield f"the record of sitting {number + 1} is gone: is there a copy of {folder.name}'s folder?"


class _Recordings:
    """What the files of one participant say."""

    def __init__(self, folder: Path) -> None:
        self.games = 0
        self.presses = 0
        self.damaged: list[str] = []
        self.failed_checks = 0
        self.focus_lost = 0
        self.wrong_asked = self.wrong_given = 0
        """Deliberately wrong presses that the screen has asked for, and those that a press followed."""
        self.led_by: set[tuple[str, str]] = set()
        """Version and SHA-256 of the study files of the sittings."""
        self._keys: Counter[str] = Counter()
        for path in sorted(folder.glob("sitting-*.jsonl")):
            self._read_sitting(path)
        for session in sessions_in(folder, self.damaged):
            if session.recording.header.study.get("kind") == "block":
                self._read_block(session)

    def flags(self) -> Iterator[str]:
        """Yield what is worth a look."""
        for name in self.damaged:
            yield f"damaged file: {name}"
        if self.games and self.presses < FEW_PRESSES_PER_GAME * self.games:
            yield f"few presses: {self.presses} in {self.games} games"
        total = sum(self._keys.values())
        if total >= ENOUGH_PRESSES:
            key, count = self._keys.most_common(1)[0]
            if count > ALWAYS_THE_SAME * total:
                yield f"always the same key: {key} in {count} of {total} presses"
        if self.failed_checks:
            yield f"failed attention checks: {self.failed_checks}"
        if self.wrong_asked >= ENOUGH_ASKED and 2 * self.wrong_given < self.wrong_asked:
            yield f"instructed presses: {self.wrong_given} of {self.wrong_asked} were given"
        if self.focus_lost:
            yield f"the window lost the keyboard {self.focus_lost} times"

    def _read_sitting(self, path: Path) -> None:
        try:
            header, lines = read_sitting(path)
        except (SealedFileError, OSError) as error:
            self.damaged.append(said_of(path, error))
            return
        self.led_by.add((header.study_version, header.study_sha256))
        for line in lines:
            if isinstance(line, QuestionAnswered):
                self.failed_checks += line.passed is False
            elif isinstance(line, FileRecorded) and not (path.parent / line.file).exists():
                self.damaged.append(f"{line.file} (it was recorded, and is not there)")

    def _read_block(self, session: BlockSoFar) -> None:
        events = session.recording.events
        asked, given = instructed_presses(events)
        self.wrong_asked += asked
        self.wrong_given += given
        self.games += session.summary.games_finished
        self.presses += session.summary.presses_counted
        self.focus_lost += session.summary.focus_lost
        taken_back = {event.press for event in events if isinstance(event, PressRetracted)}
        for event in events:
            if (
                isinstance(event, KeyPressed)
                and event.verdict == "accepted"
                and event.press not in taken_back
            ):
                self._keys[event.key] += 1


def instructed_presses(events: Iterable[Event]) -> tuple[int, int]:
    """Return how many deliberately wrong presses were asked for, and how many an accepted press followed."""
    asked = given = 0
    for event in events:
        asked += isinstance(event, WrongPressAsked)
        given += isinstance(event, KeyPressed) and event.verdict == "accepted" and event.asked_wrong
    return asked, given
