"""Shows a match at any speed: which picture is due at a moment of the clock. No widgets, no terminal."""

from typing import Final, Protocol

from core.keepaway.picture import PitchFrame, between
from core.keepaway.pitch import CYCLE_NS, ONGOING
from core.numerics.clock import NS_PER_S, Clock

SPEEDS: Final = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Offered by keys; any other may be asked for."""
SLOWEST, FASTEST = 0.02, 20.0
REST_S: Final = 1.5
"""How long an episode's last picture stays, seconds of the clock."""
MOST_CYCLES: Final = 20
"""Cycles made up for at once; a longer delay is not made up for."""

Values = tuple[tuple[str, float], ...]


class Source(Protocol):
    """A match that is played cycle by cycle (`core.keepaway.viewed_match.ViewedMatch`)."""

    frame: PitchFrame

    def step(self) -> PitchFrame:
        """Play a cycle, or set up the next episode after the last one."""
        ...

    def next_episode(self) -> PitchFrame:
        """Set up the next episode."""
        ...

    def values(self) -> Values:
        """Return what the policy thinks of each option."""
        ...


class Playback:
    """Plays a source cycle by cycle, one cycle ahead of what is shown, so that it can show what lies
    between.
    """

    def __init__(self, source: Source, clock: Clock, *, speed: float = 1.0, rest_s: float = REST_S) -> None:
        """Stand at the first picture.

        Args:
            source: what is played.
            clock: of the one who watches.
            speed: simulated seconds per second.
            rest_s: how long an episode's last picture stays.
        """
        self.ends: list[tuple[float, int]] = []
        """Of the episodes shown to the end: duration in seconds, OUT or TAKEN."""
        self.values: Values = source.values()
        """What the policy thinks of the options at the picture shown."""
        self._source = source
        self._clock = clock
        self._rest_ns = round(rest_s * NS_PER_S)
        self._speed = 1.0
        self.speed = speed
        self._paused = False
        self._looked_ns = clock.now_ns()
        self._shown = source.frame
        self._into_cycle_ns = 0.0
        """Simulated time since the picture shown, at most a cycle; in the last picture, time of the clock."""
        self._prepare()

    # --- what is shown --------------------------------------------------------------------------------------

    def picture(self) -> PitchFrame:
        """Return the picture that is due now."""
        now_ns = self._clock.now_ns()
        passed_ns, self._looked_ns = now_ns - self._looked_ns, now_ns
        if not self._paused:
            self._advance(passed_ns)
        return between(self._shown, self._next, self._into_cycle_ns / CYCLE_NS if self._sliding else 0.0)

    def _advance(self, passed_ns: float) -> None:
        for _ in range(MOST_CYCLES):
            pace = self._speed if self._sliding else 1.0
            length_ns = CYCLE_NS if self._sliding else self._rest_ns
            self._into_cycle_ns += passed_ns * pace
            if self._into_cycle_ns < length_ns:
                return
            passed_ns = (self._into_cycle_ns - length_ns) / pace
            self._go_on()

    @property
    def _sliding(self) -> bool:
        return self._shown.ended == ONGOING

    def _go_on(self) -> None:
        """Show the next picture, and play the one after it."""
        self._shown, self.values = self._next, self._next_values
        if self._shown.ended != ONGOING:
            self.ends.append((self._shown.time_s, self._shown.ended))
        self._prepare()

    def _prepare(self) -> None:
        self._into_cycle_ns = 0.0
        self._next = self._source.step()
        self._next_values = self._source.values()

    # --- what is asked for ----------------------------------------------------------------------------------

    @property
    def paused(self) -> bool:
        """Whether time stands still; may be set."""
        return self._paused

    @paused.setter
    def paused(self, paused: bool) -> None:
        self.picture()
        self._paused = paused

    @property
    def speed(self) -> float:
        """Simulated seconds per second; may be set at any time."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if not SLOWEST <= speed <= FASTEST:
            raise ValueError(f"a speed is {SLOWEST:g} to {FASTEST:g} times real time, got {speed:g}")
        self._speed = speed

    def faster(self) -> None:
        """Take the next higher speed."""
        self.speed = next((speed for speed in SPEEDS if speed > self._speed), max(self._speed, SPEEDS[-1]))

    def slower(self) -> None:
        """Take the next lower speed."""
        lower = [speed for speed in SPEEDS if speed < self._speed]
        self.speed = lower[-1] if lower else min(self._speed, SPEEDS[0])

    def step(self) -> None:
        """Pause, and show the next whole cycle."""
        self.paused = True
        self._go_on()

    def next_episode(self) -> None:
        """Leave this episode for the next one."""
        self.picture()
        # The source may have set the next episode up already.
        self._shown = self._source.frame if self._next_has_begun() else self._source.next_episode()
        self.values = ()
        self._prepare()

    def _next_has_begun(self) -> bool:
        return self._source.frame.episode > self._shown.episode
