"""Which key presses count as feedback: the one rule used by the live screen and by simulated sessions.

A terminal reports no key releases, and a held key as a flood of presses: the first repeat after 250-660 ms,
then one every 25-40 ms. The rule here recognises such a run from its intervals and takes the press that
opened it back.
"""

from collections.abc import Iterator
from itertools import count
from typing import Annotated, ClassVar, Literal

import msgspec

from core.configuration.fields import number, text
from core.events import KeyPressed, PressRetracted
from core.feedback.layouts import KeyReader
from core.numerics.clock import NS_PER_MS, NS_PER_S

FeedbackKey = Annotated[str, text("one lower-case letter a-z")]
GRADES = (-2.0, -1.0, 0.0, 1.0, 2.0)
"""What the keys of graded feedback say, in their order."""
RepeatDelay = Annotated[int, number("milliseconds", ge=0, le=1_000_000, usual=(0, 5000))]


class KeyConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Keys and limits of feedback."""

    good: Annotated[str, text("one lower-case letter a-z")] = "j"
    """Key for +1: a lower-case letter (digits and punctuation occur in terminals' own replies)."""
    bad: Annotated[str, text("one lower-case letter a-z")] = "f"
    """Key for -1."""
    retract: Annotated[str, text("one lower-case letter a-z")] = "u"
    """Key that takes the last accepted press back."""
    graded: tuple[FeedbackKey, ...] = ()
    """Five keys for -2, -1, 0, 1 and 2 in place of `good` and `bad`, such as ["d", "f", "g", "h", "j"]. []:
    two keys. 0 says "neither": H of the step is 0 (`docs/decisions/graded-feedback.md`)."""
    max_presses_per_episode: Annotated[int, number("presses", ge=0, le=1_000_000)] = 5
    """Accepted presses per watched episode (paper, section 4: at most 5 in Tetris, 2 in Keepaway)."""
    refractory_ms: Annotated[int, number("milliseconds", ge=0, le=1_000_000, usual=(0, 2000))] = 100
    """A press of the same key within this time of the one before is a repeat."""
    repeat_interval_ms: Annotated[int, number("milliseconds", ge=0, le=1_000_000, usual=(0, 2000))] = 80
    """Two intervals shorter than this in a row are a held key."""
    repeat_delay_ms: tuple[RepeatDelay, RepeatDelay] = (200, 700)
    """A held key's first repeat comes this long after the press itself."""
    wrong_press_rate: Annotated[float, number(ge=0, le=1)] = 0.0
    """Fraction of steps' feedback the participant is asked to give wrongly (paper, section 4: about 0.1)."""

    LATER: ClassVar[frozenset[str]] = frozenset({"graded"})
    """Settings that came after version 0.2: at their defaults they are not written to recordings."""

    def __post_init__(self) -> None:
        for key in (self.good, self.bad, *self.letters):
            if len(key) != 1 or not key.islower() or not key.isascii():
                raise ValueError(f"a feedback key is one lower-case letter a-z, got {key!r}")
        check_letters(self)
        if self.max_presses_per_episode < 0:
            raise ValueError(f"max_presses_per_episode is >= 0, got {self.max_presses_per_episode}")
        if not 0.0 <= self.wrong_press_rate <= 1.0:
            raise ValueError(f"wrong_press_rate is a fraction in [0, 1], got {self.wrong_press_rate}")

    @property
    def meanings(self) -> dict[str, float]:
        """What each key says: 1 and -1, or -2 to 2 where feedback is graded; the worst first."""
        if self.graded:
            return dict(zip(self.graded, GRADES, strict=True))
        return {self.bad: -1.0, self.good: 1.0}

    @property
    def letters(self) -> tuple[str, ...]:
        """All keys that mean something: those of feedback, and the one that takes a press back."""
        return (*(self.graded or (self.good, self.bad)), self.retract)

    def value(self, key: str) -> float | None:
        """Return the feedback that `key` means: 1.0 or -1.0, or -2.0 to 2.0 where it is graded; else None."""
        return self.meanings.get(key)

    def key_of(self, value: float) -> str:
        """Return the key that says a value.

        Raises:
            KeyError: none does.
        """
        by_value = {said: key for key, said in self.meanings.items()}
        return by_value[value]


def check_letters(keys: KeyConfig) -> None:
    """Refuse keys that cannot be told apart, and any other number of grades than five.

    Raises:
        ValueError: with what came.
    """
    if keys.graded and len(keys.graded) != len(GRADES):
        raise ValueError(
            f"graded takes five keys, for -2, -1, 0, 1 and 2, or none; got {len(keys.graded)}: "
            f"{', '.join(keys.graded)}"
        )
    if len(set(keys.letters)) < len(keys.letters):
        names = "graded and retract need six" if keys.graded else "good, bad and retract need three"
        raise ValueError(f"{names} different keys, got {', '.join(keys.letters)}")


class PressGate:
    """Turns raw key presses into records, and says of each whether it counts.

    One instance per session; `episode_started` gives a new budget. The gate knows the screen only through
    what the caller tells it: which frame and step are shown, and whether they are covered.
    """

    def __init__(self, config: KeyConfig, *, person: int = 0, numbers: Iterator[int] | None = None) -> None:
        """Set up the gate of one person.

        Args:
            config: keys and limits.
            person: who presses, where several do.
            numbers: gives out the numbers of presses; gates of one session share it. None: from 0.
        """
        self.config = config
        self._person = person
        self._numbers = numbers or count()
        self.reader = KeyReader()
        """Finds the key of the Latin layout where the keyboard is set to another alphabet."""
        self.frame = -1
        self.step = -1
        self.covered = False
        self.playing = False
        self.wrong_asked = False
        self._accepted: list[KeyPressed] = []
        self._last_of_key: dict[str, KeyPressed] = {}
        self._short_intervals = 0

    @property
    def presses_left(self) -> int:
        """How many presses of this episode's budget are left."""
        return self.config.max_presses_per_episode - len(self._accepted)

    def left_of(self, person: int) -> int:
        """Return `presses_left` for any number: one participant uses this gate."""
        return self.presses_left

    def episode_started(self) -> None:
        """Begin a watched episode: a new budget; presses count from here on."""
        self.playing = True
        self._accepted.clear()

    def judge(
        self, key: str, time_ns: int, *, source: Literal["participant", "simulated"] = "participant"
    ) -> Iterator[KeyPressed | PressRetracted]:
        """Yield the record of a press and, where it takes an earlier one back, that retraction."""
        reading = self.reader.read(key)
        letter = key if reading is None else reading.letter
        value = self.config.value(letter)
        record = KeyPressed(
            press=next(self._numbers),
            time_ns=time_ns,
            key=key,
            value=value,
            frame=self.frame,
            step=self.step,
            verdict=self._verdict(key, time_ns, value),
            asked_wrong=self.wrong_asked and value is not None,
            source=source,
            person=self._person,
            read_as="" if reading is None else reading.letter,
            layout="" if reading is None else reading.layout,
        )
        opener = self._opener_of_held_key(record)
        self._last_of_key[key] = record
        if record.verdict == "accepted":
            self._accepted.append(record)
            self.wrong_asked = False
        yield record
        if opener is not None:
            self._accepted.remove(opener)
            yield PressRetracted(press=opener.press, time_ns=time_ns, reason="auto-repeat")
        if letter == self.config.retract and self.playing and not self.covered and self._accepted:
            last = self._accepted.pop()
            yield PressRetracted(press=last.press, time_ns=time_ns, reason="participant")

    def _verdict(
        self, key: str, time_ns: int, value: float | None
    ) -> Literal["accepted", "other", "repeat", "no-presses-left", "covered", "not-playing"]:
        if value is None:
            return "other"
        last = self._last_of_key.get(key)
        if last is not None and time_ns - last.time_ns < self.config.refractory_ms * NS_PER_MS:
            return "repeat"
        if not self.playing:
            return "not-playing"
        if self.covered:
            return "covered"
        return "accepted" if self.presses_left > 0 else "no-presses-left"

    def _opener_of_held_key(self, record: KeyPressed) -> KeyPressed | None:
        """Return the accepted press that turns out to be a held key's first repeat, once its run is
        recognised.
        """
        last = self._last_of_key.get(record.key)
        if last is None:
            return None
        if record.time_ns - last.time_ns >= self.config.repeat_interval_ms * NS_PER_MS:
            self._short_intervals = 0
            return None
        self._short_intervals += 1
        if self._short_intervals != 2:
            return None
        return self._first_repeat(record)

    def _first_repeat(self, record: KeyPressed) -> KeyPressed | None:
        """Return the last accepted press of this key if one like it came a repeat delay before it."""
        same = [press for press in self._accepted if press.key == record.key]
        if len(same) < 2:
            return None
        low_ms, high_ms = self.config.repeat_delay_ms
        gap_ns = same[-1].time_ns - same[-2].time_ns
        return same[-1] if low_ms * NS_PER_MS <= gap_ns <= high_ms * NS_PER_MS else None


class WrongPressPlan:
    """Says before which feedback the participant is asked for a deliberately wrong press (paper, section 4).

    One number of the stream "wrong-press" is drawn at the start and after each accepted press of the
    participant.
    """

    def __init__(self, rate: float, root_seed: int) -> None:
        """Draw for the first press.

        Args:
            rate: fraction of presses that are to be wrong, in [0, 1]; 0 draws nothing.
            root_seed: of the session, >= 0.
        """
        self._rate = rate
        self._root_seed = root_seed
        self._draws: Iterator[float] | None = None
        self._next_is_wrong = self._draw()

    def due(self, gate: PressGate) -> bool:
        """Return whether to ask now, when a step has been taken; the gate then knows that it was asked."""
        if not self._next_is_wrong or gate.wrong_asked or gate.presses_left <= 0:
            return False
        self.asked(gate)
        return True

    def asked(self, gate: PressGate) -> None:
        """Note that the participant has been asked, in a session that goes on: the press is still to be
        made.
        """
        self._next_is_wrong = False
        gate.wrong_asked = True

    def accepted(self) -> None:
        """Draw for the press after one that was accepted."""
        self._next_is_wrong = self._draw()

    def _draw(self) -> bool:
        if self._rate == 0.0:
            return False
        if self._draws is None:
            self._draws = _uniform_draws(self._root_seed)
        return next(self._draws) < self._rate


def _uniform_draws(root_seed: int) -> Iterator[float]:
    """Yield the numbers in [0, 1) of the stream that says which presses are asked to be wrong."""
    from core.numerics.streams import stream  # not at the top: the first picture need not wait for numpy

    rng = stream(root_seed, "wrong-press")
    while True:
        yield float(rng.random())


def nanoseconds(event_time_s: float) -> int:
    """Return a message's time (seconds of the monotonic clock) in nanoseconds."""
    return round(event_time_s * NS_PER_S)
