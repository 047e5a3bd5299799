"""The app under test: shows a stimulus, takes a key, with the driver and the time stamps of real sessions.

Run by the robot as `python -m arl_tui.timing.subject PLAN SEEN PARENT`; writes what it saw to the file SEEN.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import msgspec
from rich.segment import Segment
from textual import events
from textual.app import ComposeResult
from textual.geometry import Size
from textual.strip import Strip
from textual.widget import Widget

from arl_tui.app.driver import FlushClock, stamped_driver
from arl_tui.app.garbage import GarbageControl
from arl_tui.app.link import Begin, Crashed, FromWorker, Link, Picture, Ready
from arl_tui.app.once import after
from arl_tui.app.plain_app import PlainApp
from arl_tui.palette import STANDARD
from arl_tui.timing.plan import (
    ANSWER_KEY,
    GAP_S,
    SETTLE_S,
    START_UP_S,
    TIME_OUT_S,
    Answered,
    Plan,
    Seen,
    marker,
)
from arl_tui.widgets.board import TetrisBoard
from core.events import FrameShown
from core.feedback.keys import nanoseconds
from core.numerics.clock import MonotonicClock
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.system.processes import leave_with
from core.tetris.picture import Snapshot

FRAME_MS = 33
"""30 pictures per second."""


class Stimulus(Widget, can_focus=False):
    """One line: a trial's marker, or nothing."""

    DEFAULT_CSS = "Stimulus { height: 1; }"

    def __init__(self) -> None:
        super().__init__()
        self._number: int | None = None
        self._drawn: int | None = None

    def show(self, number: int | None) -> None:
        """Show a trial's marker with the next paint; None clears the line."""
        self._number = number
        self.refresh()

    def take_drawn(self) -> int | None:
        """Return the trial whose marker has been drawn since the last call."""
        drawn, self._drawn = self._drawn, None
        return drawn

    def render_line(self, y: int) -> Strip:
        """Return the line."""
        self._drawn = self._number
        text = "" if self._number is None else marker(self._number)
        return Strip([Segment(text.ljust(self.size.width), self.rich_style)])


AROUND = Size(2, 10)
"""Columns and lines that the board leaves free: in 80 x 30 a block is one line high, in 200 x 60 two, as in a
session of that size."""


class SubjectApp(PlainApp[str]):
    """Runs the trials of a plan; returns why it ended early, "" if it did not."""

    def __init__(self, plan: Plan, link: Link | None) -> None:
        """Prepare.

        Args:
            plan: the trials.
            link: the learner whose board is shown beside the stimulus; None shows none.
        """
        self._clock = MonotonicClock()
        self._flush_clock = FlushClock(self._clock)
        super().__init__(driver_class=stamped_driver(self._flush_clock))
        self.answers: list[Answered] = []
        self._plan = plan
        self._link = link
        self._garbage = GarbageControl()
        self._stimulus = Stimulus()
        self._board = TetrisBoard(palette=STANDARD, around=AROUND)
        self._marks: dict[int, Callable[[int], None]] = {}
        self._n_marks = 0
        self._began_ns = 0
        self._board_frames = 0
        self._step_drawn: int | None = None
        self._frames = 0
        self._trial = -1
        self._open = False
        self._flushed_ns: int | None = None

    def compose(self) -> ComposeResult:
        """Return the stimulus, and the board below it."""
        yield self._stimulus
        if self._link is not None:
            yield self._board

    def on_mount(self) -> None:
        """Listen to the flush clock and to the learner."""
        self._flush_clock.on_stamp = lambda: self.soon(self._collect_stamps)
        if self._link is None:
            self._settle()
        else:
            self._link.listen(self._on_worker, lambda reason: self.exit(reason))

    @property
    def waiting(self) -> bool:
        """Whether a stimulus has been asked for and not been answered."""
        return self._open

    def seen(self) -> Seen:
        """Return what has been seen so far."""
        return Seen(
            answers=tuple(self.answers),
            board_frames=self._board_frames,
            duration_ns=self._clock.now_ns() - self._began_ns,
        )

    def on_unmount(self) -> None:
        """Leave the learner alone."""
        self._garbage.restore()
        if self._link is not None:
            self._link.stop_listening()

    # --- the learner ----------------------------------------------------------------------------------------

    def _on_worker(self, message: FromWorker) -> None:
        match message:
            case Ready() if self._link is not None:
                self._link.send(Begin())
                self._settle()
            case Picture(step=step, view=Snapshot() as view):
                self._show_picture(step, self._board.show(view))
            case Crashed(error=error, trace=trace):
                self.exit(f"The learner's process has failed: {error}\n{trace}")

    def _show_picture(self, step: int, changed: bool) -> None:
        if changed or self._step_drawn is not None:
            self._step_drawn = step
            return
        # Nothing will be painted. Marked all the same: the news must not overtake that of an earlier picture.
        asked_ns = self._clock.now_ns()
        self._mark(lambda flushed_ns: self._seen(step, max(flushed_ns, asked_ns)))

    def _seen(self, step: int, flushed_ns: int) -> None:
        assert self._link is not None, "only a learner has steps"
        self._link.send(FrameShown(frame=self._frames, step=step, flushed_ns=flushed_ns))
        self._frames += 1

    # --- frames ---------------------------------------------------------------------------------------------

    def post_display_hook(self) -> None:
        """Ask for the flush time of what has just been drawn."""
        if self._stimulus.take_drawn() is not None:
            self._mark(self._stamp_stimulus)
        if self._step_drawn is not None:
            step, self._step_drawn = self._step_drawn, None
            self._board_frames += self._trial >= 0
            self._mark(lambda flushed_ns: self._seen(step, flushed_ns))

    def _mark(self, then: Callable[[int], None]) -> None:
        self._marks[self._n_marks] = then
        self._n_marks += 1
        self._flush_clock.mark(self._n_marks - 1)

    def _collect_stamps(self) -> None:
        for label, flushed_ns in self._flush_clock.take():
            self._marks.pop(label)(flushed_ns)

    def _stamp_stimulus(self, flushed_ns: int) -> None:
        if self._open and self._flushed_ns is None:
            self._flushed_ns = flushed_ns

    # --- trials ---------------------------------------------------------------------------------------------

    def _settle(self) -> None:
        self._garbage.first_paint()
        after(self, SETTLE_S, self._next_trial)

    def _next_trial(self) -> None:
        if self._trial < 0:
            self._began_ns = self._clock.now_ns()
        self._trial += 1
        if self._trial == len(self._plan.trials):
            self.exit("")
            return
        self._garbage.collect()
        self._garbage.hold()
        self._flushed_ns = None
        after(self, self._plan.trials[self._trial].foreperiod_ms / 1000, self._show)

    def _show(self) -> None:
        self._open = True
        trial = self._trial
        self._stimulus.show(trial)
        after(self, TIME_OUT_S, lambda: self._end_trial(trial, None))

    async def on_event(self, event: events.Event) -> None:
        """Take a key as a session does: with the message's own time."""
        if isinstance(event, events.Key) and not event.is_forwarded and event.key == ANSWER_KEY:
            self._end_trial(self._trial, nanoseconds(event.time))
        await super().on_event(event)

    def _end_trial(self, trial: int, key_ns: int | None) -> None:
        if not self._open or trial != self._trial:
            return
        self._collect_stamps()
        self._open = False
        self.answers.append(Answered(number=trial, flushed_ns=self._flushed_ns, key_ns=key_ns))
        self._stimulus.show(None)
        after(self, GAP_S, self._next_trial)


def board_protocol() -> Protocol:
    """Return a session that never stands still: an endless row of watched games at 30 pictures per second."""
    return Protocol(
        session=SessionConfig(episodes=100_000, unseen_between=0),
        screen=ScreenConfig(tick_ms=FRAME_MS, pause_between_episodes_s=0.1),
    )


def run(plan: Plan) -> tuple[str, Seen]:
    """Run the app in this terminal; return why it ended early ("" if it did not) and what it saw."""
    link = None
    if plan.condition == "beside a board":
        from arl_tui.worker import start_worker

        link = start_worker(board_protocol(), plan.root_seed)
    try:
        app = SubjectApp(plan, link)
        trouble = app.run()
        seen = app.seen()
    finally:
        if link is not None:
            link.close()
    return "the app closed without a result" if trouble is None else trouble, seen


def main(plan_path: str, seen_path: str, parent: str) -> None:
    """Run a plan from a file and write what was seen to another."""
    plan = msgspec.json.decode(Path(plan_path).read_bytes(), type=Plan)
    leave_with(int(parent), started_by_main_thread=True, longest_s=START_UP_S + plan.longest_s)
    trouble, seen = run(plan)
    if trouble:
        raise SystemExit(trouble)
    Path(seen_path).write_bytes(msgspec.json.encode(seen))


if __name__ == "__main__":
    main(*sys.argv[1:])
