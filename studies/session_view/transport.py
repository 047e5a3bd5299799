"""Where the viewer is in a recording, and how it moves: play, pause, scrub, step, speed. No widgets."""

from typing import Final

from core.numerics.clock import Clock
from studies.session_view.session import Kind, SessionView

SPEEDS: Final = (1 / 8, 1 / 4, 1 / 2, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Recorded seconds per second."""


class Transport:
    """A position on a recording's clock that moves with a clock of the present."""

    def __init__(self, session: SessionView, clock: Clock, *, speed: float = 1.0) -> None:
        """Stand at the first frame, paused.

        Args:
            session: what is looked at.
            clock: of the one who looks.
            speed: recorded seconds per second, one of SPEEDS.
        """
        self.session = session
        self.speed = speed
        self.playing = False
        self._clock = clock
        self._looked_ns = clock.now_ns()
        self._at = float(session.times("frame")[0] if len(session.frames) else session.start_ns)

    @property
    def time_ns(self) -> int:
        """Where it stands, on the recording's clock."""
        return int(self._at)

    def tick(self) -> int:
        """Go on by the time that has passed; return where it stands. At the end it pauses."""
        now_ns = self._clock.now_ns()
        passed, self._looked_ns = now_ns - self._looked_ns, now_ns
        if self.playing:
            self._at += passed * self.speed
            if self._at >= self.session.end_ns:
                self._at, self.playing = float(self.session.end_ns), False
        return self.time_ns

    def toggle(self) -> None:
        """Play or pause; at the end, play from the beginning."""
        self.tick()
        if not self.playing and self.time_ns >= self.session.end_ns:
            self._at = float(self.session.start_ns)
        self.playing = not self.playing

    def seek(self, time_ns: float) -> None:
        """Go to a time; beyond the ends, to the end."""
        self.tick()
        self._at = float(min(max(time_ns, self.session.start_ns), self.session.end_ns))

    def move(self, kind: Kind, by: int = 1) -> None:
        """Pause and go to the next (or, with `by` < 0, previous) frame, step, press or game."""
        self.tick()
        self.playing = False
        self.seek(self.session.following(kind, self.time_ns, by))

    def go_to_press(self, n: int) -> bool:
        """Pause and go to the n-th press, from 1; return whether there is one."""
        times = self.session.times("press")
        if not 1 <= n <= len(times):
            return False
        self.playing = False
        self.seek(int(times[n - 1]))
        return True

    def faster(self, by: int = 1) -> None:
        """Take the next higher speed, or with `by` < 0 the next lower one."""
        self.tick()
        place = SPEEDS.index(self.speed) + by
        self.speed = SPEEDS[min(max(place, 0), len(SPEEDS) - 1)]
