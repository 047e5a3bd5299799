"""Several people at one keyboard: whose key is which, and a gate for each of them.

Everything that a key says follows from the protocol: the letters of all participants differ, so a press has
one owner. Who pressed is recorded with the press (`core.events.KeyPressed.person`).
"""

import re
from collections.abc import Iterator, Sequence
from itertools import count
from typing import Annotated, Literal

import msgspec

from core.configuration.fields import number, text
from core.events import KeyPressed, PressRetracted
from core.feedback.config import CreditConfig
from core.feedback.delays import Delay
from core.feedback.keys import FeedbackKey, KeyConfig, PressGate
from core.feedback.layouts import KeyReader

NOBODY = -1
"""In place of a participant's number: the key belongs to none of them."""
MOST_PEOPLE = 8
"""There are 26 letters, and each participant needs three."""
_NAME = re.compile(r"[A-Za-z0-9_-]{1,32}")


class PersonConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One of several people at the keyboard: their keys, presses and delay."""

    name: Annotated[str, text("a code of letters, digits, - and _, at most 32")]
    """Code of the person, as on the screen; never a name. Their measured delay is found under it."""
    good: FeedbackKey = ""
    """Their key for +1; "" where their feedback is graded."""
    bad: FeedbackKey = ""
    """Their key for -1; "" where their feedback is graded."""
    graded: tuple[FeedbackKey, ...] = ()
    """Their five keys for -2, -1, 0, 1 and 2, in place of `good` and `bad`."""
    retract: FeedbackKey
    """Their key that takes their last accepted press back."""
    max_presses_per_episode: Annotated[int, number("presses", ge=0, le=1_000_000)] | None = None
    """Their accepted presses per watched episode; left out: as in [keys]."""
    delay: Delay | None = None
    """By which their presses are credited; left out: as in [agent.credit.delay]. With `delay_of` other than
    "rule" it is replaced by what was measured of them when a session starts."""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(
                f"name is a code of 1 to 32 letters, digits, - and _, never a person's name: {self.name!r}"
            )
        if bool(self.graded) == bool(self.good and self.bad) or bool(self.good) != bool(self.bad):
            raise ValueError(
                f"{self.name} needs either good and bad, or the five keys of graded; got good {self.good!r}, "
                f"bad {self.bad!r}, graded {list(self.graded)}"
            )


def keys_of_person(person: PersonConfig, shared: KeyConfig) -> KeyConfig:
    """Return the keys and limits of one person.

    Args:
        person: whose keys.
        shared: [keys] of the protocol: limits, and all times.

    Raises:
        ValueError: their keys are no letters, or cannot be told apart.
    """
    own: dict[str, object] = {"retract": person.retract, "graded": person.graded}
    if not person.graded:
        own |= {"good": person.good, "bad": person.bad}
    if person.max_presses_per_episode is not None:
        own["max_presses_per_episode"] = person.max_presses_per_episode
    try:
        return msgspec.structs.replace(shared, **own)
    except ValueError as error:
        raise ValueError(f"people: {person.name}: {error}") from error


def credit_of_person(person: PersonConfig, shared: CreditConfig) -> CreditConfig:
    """Return how one participant's presses become samples: as all participants', but by their own delay if
    they have one.
    """
    return shared if person.delay is None else msgspec.structs.replace(shared, delay=person.delay)


def check_people(people: Sequence[PersonConfig], shared: KeyConfig) -> None:
    """Refuse people who cannot be told apart.

    Args:
        people: of a protocol.
        shared: its [keys].

    Raises:
        ValueError: two have the same name, or the same key; with both names.
    """
    names: set[str] = set()
    owners: dict[str, str] = {}
    for person in people:
        if person.name in names:
            raise ValueError(f"two people are called {person.name}: each needs a code of their own")
        names.add(person.name)
        for letter in keys_of_person(person, shared).letters:
            if letter in owners:
                raise ValueError(
                    f"two people, {owners[letter]} and {person.name}, have the letter {letter!r}: every "
                    "person needs letters of their own"
                )
            owners[letter] = person.name
    if people and shared.wrong_press_rate > 0:
        raise ValueError(
            "[keys] wrong_press_rate asks one participant for wrong presses; with several people set it to 0"
        )


class PeopleGate:
    """The gates of several participants, to be used as one `core.feedback.keys.PressGate`.

    A press goes through the gate of the participant whose key it is. A key that nobody has is recorded as
    `NOBODY`'s.
    """

    def __init__(self, keys: Sequence[KeyConfig], *, numbers: Iterator[int] | None = None) -> None:
        """Set up a gate for each person.

        Args:
            keys: of each, all letters different; at least one.
            numbers: gives out the numbers of presses. None: from 0.
        """
        numbers = numbers or count()
        self.of_each = tuple(
            PressGate(config, person=person, numbers=numbers) for person, config in enumerate(keys)
        )
        """One gate per participant, in order."""
        self._nobody = PressGate(keys[0], person=NOBODY, numbers=numbers)
        self._owners = {letter: gate for gate in self.of_each for letter in gate.config.letters}
        self.reader = KeyReader()

    @property
    def reader(self) -> KeyReader:
        """Finds the key of the Latin layout where the keyboard is set to another alphabet."""
        return self._nobody.reader

    @reader.setter
    def reader(self, reader: KeyReader) -> None:
        for gate in self._all:
            gate.reader = reader

    @property
    def frame(self) -> int:
        """Frame on screen; -1 before the first."""
        return self._nobody.frame

    @frame.setter
    def frame(self, frame: int) -> None:
        for gate in self._all:
            gate.frame = frame

    @property
    def step(self) -> int:
        """Watched step on screen; -1 where none is."""
        return self._nobody.step

    @step.setter
    def step(self, step: int) -> None:
        for gate in self._all:
            gate.step = step

    @property
    def covered(self) -> bool:
        """Whether something lies over the game."""
        return self._nobody.covered

    @covered.setter
    def covered(self, covered: bool) -> None:
        for gate in self._all:
            gate.covered = covered

    @property
    def playing(self) -> bool:
        """Whether a watched episode has begun."""
        return self._nobody.playing

    @playing.setter
    def playing(self, playing: bool) -> None:
        for gate in self._all:
            gate.playing = playing

    @property
    def wrong_asked(self) -> bool:
        """Whether a wrong press is asked for: never of several participants (`check_people`)."""
        return False

    @property
    def presses_left(self) -> int:
        """How many presses all participants together have left of this episode's budgets."""
        return sum(gate.presses_left for gate in self.of_each)

    def episode_started(self) -> None:
        """Begin a watched episode: a new budget for each."""
        for gate in self._all:
            gate.episode_started()

    def left_of(self, person: int) -> int:
        """Return how many presses of this episode's budget a participant has left; 0 for `NOBODY`."""
        return self.of_each[person].presses_left if person >= 0 else 0

    def judge(
        self, key: str, time_ns: int, *, source: Literal["participant", "simulated"] = "participant"
    ) -> Iterator[KeyPressed | PressRetracted]:
        """Yield the record of a press and, where it takes one of the same person back, that retraction."""
        reading = self.reader.read(key)  # reading a key twice reads it the same way
        letter = key if reading is None else reading.letter
        return self._owners.get(letter, self._nobody).judge(key, time_ns, source=source)

    @property
    def _all(self) -> tuple[PressGate, ...]:
        return (*self.of_each, self._nobody)


def new_gate(keys: Sequence[KeyConfig], *, numbers: Iterator[int] | None = None) -> PressGate | PeopleGate:
    """Return the gate of one participant, or of several at one keyboard.

    Args:
        keys: of each participant, in order (`core.session.protocol.Protocol.keys_of_people`).
        numbers: gives out the numbers of presses. None: from 0.
    """
    return PressGate(keys[0], numbers=numbers) if len(keys) == 1 else PeopleGate(keys, numbers=numbers)
