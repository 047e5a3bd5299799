"""The app of a live session: routes keys to the session and the session's events to the screens."""

import asyncio
import os
import signal
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from textual import constants, events

from arl_tui.driver import FlushClock, stamped_driver
from arl_tui.garbage import GarbageControl
from arl_tui.link import Link, Preparing, PressSuggested, Ready
from arl_tui.live import LiveSession, Occurrence, Tally
from arl_tui.once import after
from arl_tui.pace import pace_facts, pace_warning
from arl_tui.palette import palette_for
from arl_tui.plain_app import PlainApp
from arl_tui.recordings import new_path, rescue
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.play import PlayScreen
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.words import words_of
from core.clock import NS_PER_S, Clock, MonotonicClock, wall_time_utc
from core.episode import EpisodeEnded, EpisodeStarted
from core.keys import nanoseconds
from core.protocol import Protocol
from core.recording.recorder import Recorder
from core.recording.schema import Header, to_plain

PATIENCE_S = 20.0
"""The worker gets this long to say its last word."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sitting:
    """Who plays what, and where it is recorded."""

    protocol: Protocol
    root_seed: int
    participant: str
    """Pseudonym; never a name."""
    recordings: Path
    simulated: bool = False
    """A simulated participant presses keys, too."""
    source: Mapping[str, str] = field(default_factory=dict)
    """Where the credit rule comes from, for the recording's header."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What is left when the app has closed."""

    recording: Path | None
    """None where the session was never started."""
    tally: Tally
    trouble: str | None = None
    """Why the session ended early, if something failed."""
    warning: str = ""
    """What the experimenter is told of the pace, if presses often miss their step."""


class ArlApp(PlainApp[Outcome]):
    """A participant watches, presses keys, and can stop at any time."""

    CSS_PATH = "app.tcss"
    TITLE = "arl"

    def __init__(self, sitting: Sitting, link: Link, *, clock: Clock | None = None) -> None:
        """Prepare an app around a worker that has been started already.

        Args:
            sitting: who plays what.
            link: the worker.
            clock: of frames and of the session's own events; keys bring their own time (the monotonic clock's).
        """
        self._clock = clock or MonotonicClock()
        self._flush_clock = FlushClock(self._clock)
        super().__init__(driver_class=stamped_driver(self._flush_clock))
        self.sitting = sitting
        self.live = LiveSession(
            keys=sitting.protocol.keys,
            root_seed=sitting.root_seed,
            link=link,
            clock=self._clock,
            listener=self._on_occurrence,
            on_over=self._on_over,
        )
        self.live.take_stamps = self._take_stamps
        palette = palette_for(sitting.protocol.screen.palette, self.console.color_system)
        self.play = PlayScreen(sitting.protocol, self.live, palette)
        self.welcome = WelcomeScreen(sitting.protocol, sitting.participant, simulated=sitting.simulated)
        self._link = link
        self._garbage = GarbageControl()
        self._recorder: Recorder | None = None
        self._worker_ready: Ready | None = None
        self._stamps_without_driver: list[tuple[int, int]] = []
        self._simulated_keys: set[int] = set()
        self._ended_by: signal.Signals | None = None

    # --- life ---------------------------------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Listen to the worker, and to requests to end."""
        loop = asyncio.get_running_loop()
        self._flush_clock.on_stamp = lambda: _call_soon(loop, self.live.collect_frames)
        loop.set_exception_handler(self._on_loop_error)
        for number in (signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, self._end_by_signal, number)
        self.push_screen(self.welcome)
        self._link.listen(self.live.take_in, self.live.worker_lost)

    def on_unmount(self) -> None:
        """Leave the process as it was found."""
        self._garbage.restore()
        self._link.stop_listening()
        self._link.close()

    def begin(self) -> None:
        """Start the session: the participant has pressed the start key."""
        created_utc = wall_time_utc()
        path = new_path(self.sitting.recordings, self.sitting.participant, created_utc)
        try:
            self._recorder = Recorder(path, self._header(created_utc))
        except OSError as error:
            self._on_over(
                f"The recording cannot be written: {error}\nChoose another folder: --recordings DIR"
            )
            return
        self._garbage.first_paint()
        self.switch_screen(self.play)
        self.live.begin(self._recorder)

    def _end_by_signal(self, number: signal.Signals) -> None:
        """Save what there is and go: nobody will press a key on a closing screen."""
        self._ended_by = number
        if self.live.phase in ("running", "stopping"):
            self.ask_to_stop()
        else:
            self._link.close()
            self._go(Outcome(None, self.live.tally))

    def _go(self, outcome: Outcome) -> None:
        """Leave after a signal."""
        if self._ended_by == signal.SIGHUP:
            # The terminal is gone: writing to it fails, and Textual's reader would wait for it for ever.
            os._exit(128 + signal.SIGHUP)
        self.exit(outcome)

    def leave(self) -> None:
        """Close without having started."""
        self.exit(Outcome(None, self.live.tally))

    def _header(self, created_utc: str) -> Header:
        from arl_tui import facts  # Not needed before the first paint.
        from arl_tui.timing.kept import timing_facts

        name, resolution_ns = facts.clock_facts()
        stamps = "flush" if self._flush_clock.running else "queued"
        terminal = facts.terminal(
            self.size.width, self.size.height, stamps=stamps, frames_per_s=constants.MAX_FPS
        )
        protocol = self.sitting.protocol
        return Header(
            origin="live",
            created_utc=created_utc,
            clock=name,
            clock_resolution_ns=resolution_ns,
            started_ns=self._clock.now_ns(),
            participant=self.sitting.participant,
            root_seed=self.sitting.root_seed,
            protocol=to_plain(protocol),
            software=facts.software(),
            terminal=terminal | timing_facts(self.sitting.recordings, terminal, created_utc),
            departures=protocol.departures(),
            source=dict(self.sitting.source) | pace_facts(self._worker_ready),
        )

    # --- keys and frames ----------------------------------------------------------------------------------------

    async def on_event(self, event: events.Event) -> None:
        """Take every key press in, whatever screen is shown, before anything can be done with it."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            simulated = id(event) in self._simulated_keys
            self._simulated_keys.discard(id(event))
            self.live.press(
                key_name(event), nanoseconds(event.time), source="simulated" if simulated else "participant"
            )
        await super().on_event(event)

    def post_display_hook(self) -> None:
        """Note that a picture of the game has just been handed to the terminal's writer."""
        step = self.play.take_painted()
        if step is None:
            return
        frame = self.live.painted(step)
        if self._flush_clock.running:
            self._flush_clock.mark(frame)
        else:
            self._stamps_without_driver.append((frame, self._clock.now_ns()))
            self.call_later(self.live.collect_frames)

    def _take_stamps(self) -> list[tuple[int, int]]:
        stamps, self._stamps_without_driver = self._stamps_without_driver, []
        return stamps + self._flush_clock.take()

    def _press_simulated(self, key: str) -> None:
        event = events.Key(key, key)
        self._simulated_keys.add(id(event))
        self.post_message(event)

    # --- what happens -------------------------------------------------------------------------------------------

    def _on_occurrence(self, occurrence: Occurrence) -> None:
        match occurrence:
            case Preparing():
                self.welcome.show_progress(occurrence)
            case Ready():
                self._worker_ready = occurrence
                self.welcome.show_ready(occurrence)
            case EpisodeStarted():
                self._garbage.hold()
            case EpisodeEnded():
                self._garbage.collect()
            case PressSuggested(key=key, time_ns=time_ns):
                delay_s = max(0, time_ns - self._clock.now_ns()) / NS_PER_S
                after(self, delay_s, lambda: self._press_simulated(key))
        self.play.show(occurrence)
        if self._recorder is not None and self._recorder.failure is not None and self.live.phase == "running":
            # Nobody shall go on for minutes for a recording that is not written.
            self.ask_to_stop()

    def ask_to_stop(self) -> None:
        """End the session; the closing screen comes when the worker has said its last word."""
        self.live.stop()
        after(
            self,
            PATIENCE_S,
            lambda: self.live.give_up(f"The learner did not answer within {PATIENCE_S:.0f} s."),
        )

    def _on_over(self, trouble: str | None) -> None:
        self._link.stop_listening()
        self.run_worker(self._close_up(trouble), exclusive=True)

    async def _close_up(self, trouble: str | None) -> None:
        """Close worker and recording without blocking the screen, then show how it ended."""
        self._garbage.collect()
        await asyncio.to_thread(self._link.close)
        path = None
        if self._recorder is not None:
            path = self._recorder.path
            problem = await asyncio.to_thread(close_recorder, self._recorder)
            trouble = "\n\n".join(part for part in (problem, trouble) if part) or None
        sitting = self.sitting
        warning = "" if sitting.simulated else pace_warning(sitting.protocol, self._worker_ready)
        outcome = Outcome(path, self.live.tally, trouble, warning)
        if self._ended_by is not None:
            self._go(outcome)
            return
        while len(self.screen_stack) > 1:
            self.pop_screen()
        protocol = self.sitting.protocol
        self.push_screen(
            ClosingScreen(outcome, words_of(protocol.game), show_weight=protocol.screen.show_weight)
        )

    def _on_loop_error(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Fail loudly where a callback of the event loop fails: asyncio would only log it, behind the screen."""
        error = context.get("exception")
        if isinstance(error, Exception):
            self.call_later(_raise, error)
        else:
            loop.default_exception_handler(context)


def close_recorder(recorder: Recorder) -> str | None:
    """Close a recording; return what is wrong with it, and where the rest of it is."""
    try:
        recorder.close()
    except TimeoutError as error:
        return str(error)
    except OSError as error:
        try:
            rest = str(rescue(recorder.unwritten, recorder.path.stem))
        except OSError:
            rest = "nowhere: that failed, too"
        return f"The recording is not complete: {error}\nWhat could not be written to it is in {rest}"
    return None


def _raise(error: Exception) -> None:
    raise error


def key_name(event: events.Key) -> str:
    """Return the key as it is recorded: Shift and Caps Lock change a letter's character, not its key."""
    return event.key.lower() if len(event.key) == 1 else event.key


def _call_soon(loop: asyncio.AbstractEventLoop, callback: object) -> None:
    if not loop.is_closed():
        loop.call_soon_threadsafe(callback)  # type: ignore[arg-type]


def build_app(sitting: Sitting, link: Link, *, clock: Clock | None = None) -> ArlApp:
    """Return the app: the one factory, for the command line and for tests."""
    return ArlApp(sitting, link, clock=clock)
