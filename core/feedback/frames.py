"""Which frame of a session was on screen when: kept by the live screen, and followed again by replay."""

from collections import deque

from core.events import FrameShown

FRAMES_REMEMBERED = 256
"""About ten seconds: far more than a key's handler is ever late."""


class FrameLedger:
    """Which frame, and which step, was on screen at a time that has just passed."""

    def __init__(self, first: int = 0) -> None:
        """Begin with an empty screen.

        Args:
            first: number of the next frame.
        """
        self._steps: dict[int, int] = {}
        self._next_frame = first
        self._shown: deque[tuple[int, int, int]] = deque([(0, -1, -1)], maxlen=FRAMES_REMEMBERED)

    def painted(self, step: int) -> int:
        """Give the number of a frame that has been drawn, though it has not reached the terminal yet."""
        frame = self._next_frame
        self._next_frame += 1
        self._steps[frame] = step
        return frame

    def flushed(self, frame: int, time_ns: int) -> FrameShown:
        """Note when a frame's last byte left."""
        shown = FrameShown(frame=frame, step=self._steps.pop(frame), flushed_ns=time_ns)
        self.recorded(shown)
        return shown

    def recorded(self, shown: FrameShown) -> None:
        """Note a frame as a recording tells it."""
        self._shown.append((shown.flushed_ns, shown.frame, shown.step))

    def dropped(self, frame: int) -> None:
        """Note that a frame does not count: something else covered it."""
        self._steps.pop(frame, None)

    def cleared(self, time_ns: int) -> None:
        """Note that no frame is on screen from this time on."""
        self._shown.append((time_ns, -1, -1))

    def at(self, time_ns: int) -> tuple[int, int]:
        """Return (frame, step) on screen at `time_ns`; -1 where there was none."""
        for shown_ns, frame, step in reversed(self._shown):
            if shown_ns <= time_ns:
                return frame, step
        return -1, -1
