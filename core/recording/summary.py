"""What a recording holds and how its session ended, in the words that every command uses."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, cast

from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    Event,
    FocusLost,
    KeyPressed,
    Output,
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

EndingKind = Literal["finished", "imported", "running", "killed", "cut", "closed"] | StopReason

_STOPS: dict[StopReason, str] = {
    "participant": "stopped by the participant",
    "window-closed": "window closed",
    "signal": "stopped by a signal",
    "worker-died": "worker died",
    "time-limit": "time limit reached",
    "practised": "both keys were practised",
    "disk-failed": "disk failed: the recording could not be written any more",
}
_Kind = tuple[str, int, float]
"""What is told of a press that was accepted: its source, who pressed, and its value (0 where it has none)."""
_V1_STOP = " (or window closed, signal, disk full: version 1 does not tell)"


@dataclass(frozen=True, slots=True)
class Ending:
    """How a recorded session ended."""

    kind: EndingKind
    """`running`: it is being recorded now. `killed`: the process ended without a word. `cut`: the file ends
    within a line. `closed`: the recording was closed, but the session's end is not in it."""
    words: str
    """The same in plain words."""


def ending_of(recording: Recording) -> Ending:
    """Return how the session of a recording ended, from its events alone."""
    summarising = Summarising()
    for event in recording.events:
        summarising.take(event)
    return summarising.ending(
        recording.header,
        complete=recording.complete,
        lost_tail=bool(recording.lost_tail),
        being_written=recording.being_written,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingSummary:
    """One recording in figures."""

    game: str
    """"" where the recording does not say it: imported tables of evaluations."""
    variant: str
    """Which environment, where the game names one ([domain] env); else ""."""
    protocol: str
    """Its name; "" where there is none."""
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
    """Code and counted presses of each of several participants at one keyboard, in order; () where there is
    one.
    """
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
        games = [f"{self.games_finished} of {self.games_planned} games finished"]
        if self.games_planned is None:
            games = [_counted(self.games_begun, "game")] if self.game else []
        presses = f"{_counted(self.presses_counted, 'press', 'presses')} counted"
        about = [f"{name} {n}" for name, n in self.presses_of_people]
        about += [f"{n} of {value:+g}" if value else f"{n} of 0" for value, n in self.presses_by_value]
        about += [f"{self.presses_simulated} simulated"] if self.presses_simulated else []
        about += [f"{self.presses_taken_back} more taken back"] if self.presses_taken_back else []
        presses += f" ({', '.join(about)})" if about else ""
        game = f"{self.game}:{self.variant}" if self.variant else self.game
        parts = [f"{game}, protocol {self.protocol}" if game else "evaluations without their game"]
        parts[0] += f", condition {self.condition}" if self.condition else ""
        parts += [*games, presses]
        parts += [f"the machine stood still {_counted(self.gaps, 'time')}"] if self.gaps else []
        return f"{'; '.join(parts)}; ended: {self.ending.words}"


def _counted(n: int, one: str, many: str | None = None) -> str:
    return f"{n} {one if n == 1 else many or one + 's'}"


def summarise_recording(recording: Recording) -> RecordingSummary:
    """Return a recording's summary. It asks for no game and runs nothing."""
    summarising = Summarising()
    for event in recording.events:
        summarising.take(event)
    return summarising.summary(
        recording.header,
        complete=recording.complete,
        lost_tail=bool(recording.lost_tail),
        being_written=recording.being_written,
    )


class Summarising:
    """Takes events in, one by one, and counts: it keeps no event but the last ones."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._steps = 0
        self._begun = self._finished = self._gaps = self._focus_lost = 0
        self._accepted: dict[int, _Kind] = {}  # by the number of the press
        self._kinds: dict[_Kind, _Kind] = {}  # one object for all presses of a kind: there may be a million
        self._taken_back: set[int] = set()
        self._stop: StopAsked | None = None
        self._last_output: Output | None = None

    def take(self, event: Event) -> None:
        """Take in the next event."""
        if isinstance(event, KeyPressed):  # of many, the most: asked about first
            if event.verdict == "accepted":
                kind = (event.source, event.person, event.value or 0.0)
                self._accepted[event.press] = self._kinds.setdefault(kind, kind)
            return
        if isinstance(event, Output):
            self._last_output = event
        match event:
            case StepTaken():
                self._steps += 1
            case PressRetracted():
                self._taken_back.add(event.press)
            case EpisodeStarted():
                self._begun += 1
            case EpisodeEnded():
                # Over before the session was asked to stop, or by itself.
                self._finished += self._stop is None or event.ended == "termination"
            case StopAsked():
                self._stop = event
            case TimeGap():
                self._gaps += not event.joint
            case FocusLost():
                self._focus_lost += 1
            case _:
                pass

    def add_steps(self, n_steps: int) -> None:
        """Count steps that are not taken in one by one."""
        self._steps += n_steps

    def ending(
        self, header: Header, *, complete: bool, lost_tail: bool, being_written: bool = False
    ) -> Ending:
        """Return how the session ended.

        Args:
            header: of the recording.
            complete: it has its end line.
            lost_tail: it ends within a line.
            being_written: a program is writing it now.
        """
        if header.origin == "imported":
            return Ending("imported", "imported")
        last_word = isinstance(self._last_output, SessionEnded)
        if self._stop is not None:
            words = _stop_words(header, self._stop, complete=complete, last_word=last_word)
            return Ending(self._stop.reason, words)
        if last_word:
            whole = "" if complete else ", but the end of the file is missing"
            return Ending("finished", f"finished{whole}")
        if complete:
            return Ending("closed", "closed before its end, without a reason")
        if being_written:
            return Ending("running", "not yet, it is being recorded now")
        when = "" if self._last_output is not None else " before the first game"
        if lost_tail:
            return Ending("cut", f"killed{when}, or the copy is not whole: the file ends within a line")
        return Ending("killed", f"killed{when}, or the copy is not whole: the file has no end line")

    def summary(
        self, header: Header, *, complete: bool, lost_tail: bool, being_written: bool = False
    ) -> RecordingSummary:
        """Return what was counted; arguments as for `ending`."""
        protocol = header.protocol
        imported = header.origin == "imported"
        says_game = not imported or "domain" in protocol or self._begun > 0
        taken_back = self._taken_back & self._accepted.keys()
        counted = Counter(kind for number, kind in self._accepted.items() if number not in taken_back)
        return RecordingSummary(
            game=_game(protocol) if says_game else "",
            variant=_variant(protocol),
            protocol=str(protocol.get("name", "default")) if says_game else "",
            condition=condition_of(header),
            games_finished=self._finished,
            games_begun=self._begun,
            games_planned=None if imported else _planned(protocol),
            steps=self._steps,
            presses_counted=counted.total(),
            presses_simulated=sum(n for (source, _, _), n in counted.items() if source == "simulated"),
            presses_of_people=_of_people(header, counted),
            presses_by_value=_by_value(protocol, counted),
            presses_taken_back=len(taken_back),
            gaps=self._gaps,
            focus_lost=self._focus_lost,
            ending=self.ending(header, complete=complete, lost_tail=lost_tail, being_written=being_written),
        )


def _stop_words(header: Header, stop: StopAsked, *, complete: bool, last_word: bool) -> str:
    words = _STOPS[stop.reason]
    if stop.reason == "participant" and recorded_version(header) < HAS_REASONS:
        words += _V1_STOP
    if not last_word and stop.reason != "worker-died":
        words += ", and the worker gave no answer"
    if not complete:
        words += "; the end of the file is missing"
    return words


def _of_people(header: Header, counted: Counter[_Kind]) -> tuple[tuple[str, int], ...]:
    """Return how many presses of each of several participants counted."""
    names = header.participants if isinstance(header.participants, list) else []
    return tuple(
        (name, sum(n for (_, who, _), n in counted.items() if who == person))
        for person, name in enumerate(names)
    )


def _by_value(protocol: Mapping[str, Any], counted: Counter[_Kind]) -> tuple[tuple[float, int], ...]:
    """Return how many presses of each value counted, where any participant's feedback was graded."""
    keys = [protocol.get("keys"), *(protocol.get("people") or ())]
    if not any(isinstance(each, Mapping) and each.get("graded") for each in keys):
        return ()
    values = Counter[float]()
    for (_, _, value), n in counted.items():
        values[value] += n
    return tuple(sorted(values.items()))


def condition_of(header: Header) -> str:
    """Return the study's condition of a session; "" where there is none."""
    for said in (header.study, header.source, header.protocol):
        if said.get("condition"):
            return str(said["condition"])
    return ""


def _game(protocol: Mapping[str, Any]) -> str:
    domain = protocol.get("domain")
    # Recordings made before there was a second game do not name theirs.
    return str(domain.get("type", FIRST_GAME)) if isinstance(domain, Mapping) else FIRST_GAME


def _variant(protocol: Mapping[str, Any]) -> str:
    domain = protocol.get("domain")
    return str(domain.get("env", "")) if isinstance(domain, Mapping) else ""


def _planned(protocol: Mapping[str, Any]) -> int | None:
    session = protocol.get("session")
    episodes = session.get("episodes") if isinstance(session, Mapping) else None
    return cast("int | None", episodes)
