"""What a recording holds and how its session ended, in the words that every command uses."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    FocusLost,
    KeyPressed,
    PressRetracted,
    SessionEnded,
    StepTaken,
    StopAsked,
    StopReason,
    TimeGap,
)
from core.recording.reader import Recording
from core.recording.schema import FIRST_GAME, Header
from core.recording.upgrade import recorded_version

HAS_REASONS = 2
"""First version that tells a closed window, a signal and a full disk from a participant's stop."""

EndingKind = Literal["finished", "imported", "killed", "cut", "closed"] | StopReason

_STOPS: dict[StopReason, str] = {
    "participant": "stopped by the participant",
    "window-closed": "window closed",
    "signal": "stopped by a signal",
    "worker-died": "worker died",
    "time-limit": "time limit reached",
    "practised": "both keys were practised",
    "disk-failed": "disk failed: the recording could not be written any more",
}
_V1_STOP = " (or window closed, signal, disk full: version 1 does not tell)"


@dataclass(frozen=True, slots=True)
class Ending:
    """How a recorded session ended."""

    kind: EndingKind
    """`killed`: the process ended without a word. `cut`: the file ends within a line. `closed`: the recording
    was closed, but the session's end is not in it."""
    words: str
    """The same in plain words."""


def ending_of(recording: Recording) -> Ending:
    """Return how the session of a recording ended, from its events alone."""
    if recording.header.origin == "imported":
        return Ending("imported", "imported")
    stop = next((event for event in reversed(recording.inputs) if isinstance(event, StopAsked)), None)
    outputs = recording.outputs
    last_word = bool(outputs) and isinstance(outputs[-1], SessionEnded)
    if stop is not None:
        return Ending(stop.reason, _stop_words(recording, stop, last_word=last_word))
    if last_word:
        whole = "" if recording.complete else ", but the end of the file is missing"
        return Ending("finished", f"finished{whole}")
    if recording.complete:
        return Ending("closed", "closed before its end, without a reason")
    when = "" if outputs else " before the first game"
    if recording.lost_tail:
        return Ending("cut", f"killed{when}, or the copy is not whole: the file ends within a line")
    return Ending("killed", f"killed{when}, or the copy is not whole: the file has no end line")


def _stop_words(recording: Recording, stop: StopAsked, *, last_word: bool) -> str:
    words = _STOPS[stop.reason]
    if stop.reason == "participant" and recorded_version(recording.header) < HAS_REASONS:
        words += _V1_STOP
    if not last_word and stop.reason != "worker-died":
        words += ", and the worker gave no answer"
    if not recording.complete:
        words += "; the end of the file is missing"
    return words


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingSummary:
    """One recording in figures."""

    game: str
    protocol: str
    """Its name."""
    condition: str
    """Of the study; "" where there is none."""
    games_finished: int
    """Games that went to their end; one that was broken off by the session's end is not."""
    games_begun: int
    games_planned: int | None
    """None where nobody planned them: imported logs."""
    steps: int
    """Watched steps."""
    presses_counted: int
    """Presses that were accepted and not taken back."""
    presses_simulated: int
    """Of these, those of simulated participants."""
    presses_of_people: tuple[tuple[str, int], ...]
    """Code and counted presses of each of several people at one keyboard, in order; () where there is one."""
    presses_by_value: tuple[tuple[float, int], ...]
    """Counted presses of each value, from the lowest, where feedback was graded; else ()."""
    presses_taken_back: int
    """By the participant, or as a held key's repeats."""
    gaps: int
    """Times at which the program stood still."""
    focus_lost: int
    """Times at which the window lost the keyboard."""
    ending: Ending

    @property
    def words(self) -> str:
        """All of it in one line, as `arl recordings` and `arl replay` print it."""
        games = f"{self.games_finished} of {self.games_planned} games finished"
        if self.games_planned is None:
            games = _counted(self.games_begun, "game")
        presses = f"{_counted(self.presses_counted, 'press', 'presses')} counted"
        about = [f"{name} {n}" for name, n in self.presses_of_people]
        about += [f"{n} of {value:+g}" if value else f"{n} of 0" for value, n in self.presses_by_value]
        about += [f"{self.presses_simulated} simulated"] if self.presses_simulated else []
        about += [f"{self.presses_taken_back} more taken back"] if self.presses_taken_back else []
        presses += f" ({', '.join(about)})" if about else ""
        parts = [f"{self.game}, protocol {self.protocol}"]
        parts[0] += f", condition {self.condition}" if self.condition else ""
        parts += [games, presses]
        parts += [f"the machine stood still {_counted(self.gaps, 'time')}"] if self.gaps else []
        return f"{'; '.join(parts)}; ended: {self.ending.words}"


def _counted(n: int, one: str, many: str | None = None) -> str:
    return f"{n} {one if n == 1 else many or one + 's'}"


def summarise_recording(recording: Recording) -> RecordingSummary:
    """Return a recording's summary. It asks for no game and runs nothing."""
    protocol = recording.header.protocol
    imported = recording.header.origin == "imported"
    presses = {
        event.press: event
        for event in recording.events
        if isinstance(event, KeyPressed) and event.verdict == "accepted"
    }
    taken_back = {event.press for event in recording.events if isinstance(event, PressRetracted)}
    counted = [press for number, press in presses.items() if number not in taken_back]
    return RecordingSummary(
        game=_game(protocol),
        protocol=str(protocol.get("name", "default")),
        condition=condition_of(recording.header),
        games_finished=_finished(recording),
        games_begun=_count(recording, EpisodeStarted),
        games_planned=None if imported else _planned(protocol),
        steps=_count(recording, StepTaken) + recording.steps_left_out,
        presses_counted=len(counted),
        presses_simulated=sum(press.source == "simulated" for press in counted),
        presses_of_people=_of_people(recording.header, counted),
        presses_by_value=_by_value(protocol, counted),
        presses_taken_back=len(taken_back & presses.keys()),
        gaps=sum(isinstance(event, TimeGap) and not event.joint for event in recording.events),
        focus_lost=_count(recording, FocusLost),
        ending=ending_of(recording),
    )


def _of_people(header: Header, counted: Sequence[KeyPressed]) -> tuple[tuple[str, int], ...]:
    """Return how many presses of each of several people counted."""
    names = header.participants if isinstance(header.participants, list) else []
    return tuple(
        (name, sum(press.person == person for press in counted)) for person, name in enumerate(names)
    )


def _by_value(protocol: Mapping[str, Any], counted: Sequence[KeyPressed]) -> tuple[tuple[float, int], ...]:
    """Return how many presses of each value counted, where anybody's feedback was graded."""
    keys = [protocol.get("keys"), *(protocol.get("people") or ())]
    if not any(isinstance(each, Mapping) and each.get("graded") for each in keys):
        return ()
    return tuple(sorted(Counter(press.value or 0.0 for press in counted).items()))


def condition_of(header: Header) -> str:
    """Return the study's condition of a session; "" where there is none."""
    for said in (header.study, header.source, header.protocol):
        if said.get("condition"):
            return str(said["condition"])
    return ""


def _count(recording: Recording, kind: type) -> int:
    return sum(isinstance(event, kind) for event in recording.events)


def _game(protocol: Mapping[str, Any]) -> str:
    domain = protocol.get("domain")
    # Recordings made before there was a second game do not name theirs.
    return str(domain.get("type", FIRST_GAME)) if isinstance(domain, Mapping) else FIRST_GAME


def _planned(protocol: Mapping[str, Any]) -> int | None:
    session = protocol.get("session")
    episodes = session.get("episodes") if isinstance(session, Mapping) else None
    return cast("int | None", episodes)


def _finished(recording: Recording) -> int:
    """Count the games that were over before the session was asked to stop, or by themselves."""
    finished, stopped = 0, False
    for event in recording.events:
        if isinstance(event, StopAsked):
            stopped = True
        elif isinstance(event, EpisodeEnded):
            finished += not stopped or event.ended == "termination"
    return finished
