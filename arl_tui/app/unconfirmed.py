"""Presses that are recorded and not known to be in the file yet.

The screens are told of a press only when it is in the file: a press that a participant sees counted is never
lost.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from arl_tui.app.link import TakenFor
from core.events import Event, KeyPressed, PressRetracted
from core.feedback.keys import PressGate
from core.feedback.people import PeopleGate
from core.numerics.clock import NS_PER_S, Clock


class EventSink(Protocol):
    """Where events are recorded (`core.recording.recorder.Recorder`)."""

    failure: OSError | None
    """Why nothing more can be kept; None while all is well."""

    @property
    def recorded(self) -> int:
        """How many events have been taken."""
        ...

    @property
    def written(self) -> int:
        """How many of them are in the file: they survive the end of this program."""
        ...

    def record(self, event: Event) -> None:
        """Take one event; never wait."""
        ...


@dataclass(frozen=True, slots=True)
class Unconfirmed:
    """A press, or a press taken back, that is not known to be in the file yet."""

    number: int
    """How many events must be in the file for this one to be."""
    event: KeyPressed | PressRetracted
    presses_left: int
    """Of the budget, after it."""
    episode: int
    since_ns: int


class UnconfirmedPresses:
    """Keeps presses until they are in the file, and each participant's budget as far as presses are
    confirmed.
    """

    def __init__(
        self,
        gate: PressGate | PeopleGate,
        n_participants: int,
        clock: Clock,
        listener: Callable[[KeyPressed | PressRetracted | TakenFor], None],
    ) -> None:
        """Begin with no press waiting.

        Args:
            gate: knows what is left of each budget when a press is made.
            n_participants: how many participants press, >= 1.
            clock: says how long a press has waited.
            listener: told of each press when it is in the file, then of what it was taken for.
        """
        self._gate = gate
        self._clock = clock
        self._listener = listener
        self._unconfirmed: deque[Unconfirmed] = deque()
        self._taken: dict[int, TakenFor] = {}
        """What presses were taken for that are not known to be in the file yet."""
        self._episodes_begun = 0
        self._left = [gate.left_of(person) for person in range(n_participants)]
        """Presses that are left of each participant's budget, as far as presses have been confirmed."""
        self._person_of: dict[int, int] = {}

    @property
    def left_of_first(self) -> int:
        """Presses that are left of the first person's budget."""
        return self._left[0]

    def left_of(self, event: KeyPressed | PressRetracted) -> int:
        """Return how many presses of their budget the one has left whose press this is; 0 for nobody."""
        person = self._whose(event)
        return self._left[person] if person >= 0 else 0

    def accepted(self, press: KeyPressed) -> None:
        """Note whose press this is, for the case that it is taken back."""
        self._person_of[press.press] = press.person

    def episode_started(self) -> None:
        """Give each participant the budget of a new episode."""
        self._episodes_begun += 1
        self._left = [self._gate.left_of(person) for person in range(len(self._left))]

    def wait_for(self, event: KeyPressed | PressRetracted, sink: EventSink) -> None:
        """Keep a press that `sink` has just recorded until it is in the file."""
        self._unconfirmed.append(
            Unconfirmed(
                number=sink.recorded,
                event=event,
                presses_left=self._gate.left_of(self._whose(event)),
                episode=self._episodes_begun,
                since_ns=self._clock.now_ns(),
            )
        )

    def note_taken(self, taken: TakenFor) -> None:
        """Tell the screens what a press was taken for, after they have been told that it counts."""
        if any(waiting.event.press == taken.press for waiting in self._unconfirmed):
            self._taken[taken.press] = taken
        else:
            self._listener(taken)

    def confirm(self, sink: EventSink) -> None:
        """Pass on to the screens the presses that are in the file by now; none once the disk has failed."""
        while self._unconfirmed and sink.failure is None and self._unconfirmed[0].number <= sink.written:
            waiting = self._unconfirmed.popleft()
            same = waiting.episode == self._episodes_begun
            person = self._whose(waiting.event)
            if person >= 0:
                self._left[person] = waiting.presses_left if same else self._gate.left_of(person)
            self._listener(waiting.event)
            taken = self._taken.pop(waiting.event.press, None)
            if taken is not None:
                self._listener(taken)

    def waiting_s(self) -> float:
        """Return for how long the oldest press has waited, seconds; 0.0 where none waits."""
        if not self._unconfirmed:
            return 0.0
        return (self._clock.now_ns() - self._unconfirmed[0].since_ns) / NS_PER_S

    def _whose(self, event: KeyPressed | PressRetracted) -> int:
        """Return whose press this is; a press taken back is whose it was."""
        return event.person if isinstance(event, KeyPressed) else self._person_of.get(event.press, 0)
