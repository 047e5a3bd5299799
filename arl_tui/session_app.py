"""The app of a live session: routes keys to the session and the session's events to the screens."""

import asyncio
import signal
from functools import partial
from pathlib import Path
from typing import Any

from textual import constants, events

from arl_tui.app.close_recording import CLOSING_S, close_recorder
from arl_tui.app.driver import FlushClock, stamped_driver
from arl_tui.app.gaps import LOOKS_PER_S, GapWatch
from arl_tui.app.garbage import GarbageControl
from arl_tui.app.link import Link, Preparing, PressSuggested, Ready, TakenFor
from arl_tui.app.live_session import LiveSession, Occurrence
from arl_tui.app.once import after
from arl_tui.app.outcome import SessionControls, SessionOutcome
from arl_tui.app.session_setup import SessionSetup
from arl_tui.games.pace import pace_facts, pace_warning
from arl_tui.games.registry import words_of
from arl_tui.language import changed_keys
from arl_tui.palette import palette_for
from arl_tui.recordings import create_new
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.overview import topics_of
from arl_tui.screens.play import PlayScreen
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.signing import NoKey, signer_in_use
from core.events import EpisodeEnded, EpisodeStarted, StopReason
from core.feedback.keys import nanoseconds
from core.numerics.clock import NS_PER_S, Clock, MonotonicClock, wall_time_utc
from core.recording.recorder import Recorder
from core.recording.schema import Header, to_plain

PATIENCE_S = 20.0
"""The worker gets this long to say its last word, seconds."""
SILENT_PATIENCE_S = 5.0
"""The same for a worker that had been silent for `SILENCE_S` when the end was asked for."""
SIGNAL_PATIENCE_S = 1.0
"""The same where a signal or a closed terminal ends the session: all must be over within 2 s."""
SILENCE_S = 2.0
"""After so many seconds without a word of the worker the screen says so."""
LOOK_S = 0.25
"""How often the disk and the worker are looked at, seconds."""
SAVING_S = 0.15
"""A press that is not in the file after this time is shown as being saved, seconds."""
BEHIND_S = 1.0
"""A disk that has not confirmed a press after this time is said to be behind, seconds."""


class ArlApp(SessionControls):
    """A participant watches, presses keys, and can stop at any time."""

    CSS_PATH = "app.tcss"
    TITLE = "arl"

    def __init__(self, setup: SessionSetup, link: Link, *, clock: Clock | None = None) -> None:
        """Prepare an app around a worker that has been started already.

        Args:
            setup: who plays what.
            link: the worker.
            clock: of frames and of the session's own events; keys bring their own time (the monotonic
                clock's).
        """
        self._clock = clock or MonotonicClock()
        self._flush_clock = FlushClock(self._clock)
        screen = setup.protocol.screen
        super().__init__(
            driver_class=stamped_driver(self._flush_clock), theme=screen.theme, language=screen.language
        )
        self.setup = setup
        self.live = LiveSession(
            keys=setup.protocol.keys_of_people,
            root_seed=setup.root_seed,
            link=link,
            clock=self._clock,
            listener=self._on_occurrence,
            on_over=self._on_over,
            earlier=() if setup.kept is None else setup.kept.events,
            asking=setup.protocol.agent.asking,
        )
        self.live.take_stamps = self._take_stamps
        self.live.gate.reader = self.reader
        palette = palette_for(
            screen.palette, self.console.color_system, no_color=self.no_color, theme=self.theme_name
        )
        self.play = PlayScreen(setup.protocol, self.live, palette, part=setup.part)
        if setup.kept is not None:
            self.play.go_on_after(setup.kept.outputs)
        self.welcome = WelcomeScreen(
            setup.protocol,
            setup.participant,
            simulated=setup.simulated,
            games_done=0 if setup.kept is None else setup.kept.games,
            practice=setup.practice,
            part=setup.part,
            overview=None if setup.study or setup.simulated else partial(topics_of, setup),
        )
        self._link = link
        self._garbage = GarbageControl()
        self._recorder: Recorder | None = None
        self._worker_ready: Ready | None = None
        self._stamps_without_driver: list[tuple[int, int]] = []
        self._simulated_keys: set[int] = set()
        self._outcome: SessionOutcome | None = None
        self._practised: set[tuple[int, bool]] = set()
        """Who has pressed a good or a bad key on time."""
        """Which keys have been pressed in time: True for the good one."""

    # --- life -----------------------------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Listen to the worker, and to requests to end."""
        loop = asyncio.get_running_loop()
        self._flush_clock.on_stamp = lambda: self.soon(self.live.collect_frames)
        loop.set_exception_handler(self._on_loop_error)
        self.push_screen(self.welcome)
        self._link.listen(self.live.take_in, self.live.worker_lost)
        self.set_interval(LOOK_S, self._look)

    def on_unmount(self) -> None:
        """Leave the process as it was found."""
        self._garbage.restore()
        self._link.stop_listening()
        self._link.close()

    def begin(self) -> None:
        """Start the session: the participant has pressed the start key."""
        created_utc = wall_time_utc()
        header = self._header(created_utc)

        def create(path: Path) -> Recorder:
            return Recorder(
                path,
                header,
                on_news=lambda: self.soon(self._on_disk_news),
                clock=self._clock,
                sign=sign,
            )

        try:
            sign = signer_in_use()
        except NoKey as error:
            self._on_over(str(error))
            return
        try:
            self._recorder = create_new(self.setup.recordings, self.setup.participant, created_utc, create)
        except OSError as error:
            self._on_over(
                f"The recording cannot be written: {error}\nChoose another folder: --recordings DIR"
            )
            return
        self._garbage.first_paint()
        self.switch_screen(self.play)
        self.live.find_gap = GapWatch(self._clock).look
        self.live.begin(self._recorder)
        self._look_at_the_time()

    def _look_at_the_time(self) -> None:
        """Notice a gap within a fifth of a second, whether anything else happens or not."""
        self.live.notice_gap()
        if self.live.phase == "running":
            after(self, 1.0 / LOOKS_PER_S, self._look_at_the_time)

    def end_by_signal(self, number: signal.Signals) -> None:
        """Save what there is and go: no participant will press a key on a closing screen."""
        if self.live.phase in ("running", "stopping"):
            gone = number == getattr(signal, "SIGHUP", None)
            self.ask_to_stop("window-closed" if gone else "signal", SIGNAL_PATIENCE_S)
        elif self._recorder is None or self._outcome is not None:
            self._link.close(SIGNAL_PATIENCE_S)
            self._go(self._outcome or SessionOutcome(None, self.live.tally))
        # Else the recording is being closed, and `_close_up` goes when that is done.

    def _go(self, outcome: SessionOutcome) -> None:
        """Leave after a signal."""
        if self.ended_by == getattr(signal, "SIGHUP", None):
            self.leave_at_once()
        self.exit(outcome, return_code=128 + (self.ended_by or 0))

    def leave(self) -> None:
        """Close without having started."""
        self.exit(SessionOutcome(None, self.live.tally))

    def _header(self, created_utc: str) -> Header:
        from arl_tui.app import facts  # Not needed before the first paint.
        from arl_tui.timing.kept import timing_facts

        name, resolution_ns = facts.clock_facts()
        stamps = "flush" if self._flush_clock.running else "queued"
        terminal = facts.terminal(
            self.size.width, self.size.height, stamps=stamps, frames_per_s=constants.MAX_FPS
        )
        if self.theme_name != "dark":
            terminal = terminal | {"theme": self.theme_name}
        protocol = self.setup.protocol
        if changed_keys():
            terminal["own_keys"] = ", ".join(f"{name} {key}" for name, key in changed_keys().items())
        return Header(
            origin="live",
            created_utc=created_utc,
            clock=name,
            clock_resolution_ns=resolution_ns,
            started_ns=self._clock.now_ns(),
            participant=self.setup.participant,
            root_seed=self.setup.root_seed,
            protocol=to_plain(protocol),
            software=facts.software(),
            terminal=terminal | timing_facts(self.setup.recordings, terminal, created_utc),
            departures=protocol.departures(),
            source=dict(self.setup.source) | pace_facts(self._worker_ready),
            study=dict(self.setup.study),
            participants=protocol.participants,
            resumes=None if self.setup.kept is None else self.setup.kept.resumes,
        )

    # --- keys and frames ------------------------------------------------------------------------------------

    async def on_event(self, event: events.Event) -> None:
        """Take every key press in, whatever screen is shown, before anything can be done with it."""
        if isinstance(event, events.Key) and not event.is_forwarded:
            simulated = id(event) in self._simulated_keys
            self._simulated_keys.discard(id(event))
            self.live.key_pressed(
                key_name(event), nanoseconds(event.time), source="simulated" if simulated else "participant"
            )
        elif isinstance(event, events.AppFocus | events.AppBlur):
            self.live.focus(isinstance(event, events.AppFocus))
        await super().on_event(event)

    def tell_about_keys(self, advice: str) -> None:
        """Leave it to the feedback bar where there is a game: a note over the game would hide it."""
        if self.screen is not self.play:
            super().tell_about_keys(advice)

    def post_display_hook(self) -> None:
        """Note that a picture of the game has just been handed to the terminal's writer."""
        step = self.play.take_painted()
        if self.play.take_question_painted():
            frame = self.live.question_painted()
        elif step is None:
            return
        else:
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

    # --- what happens ---------------------------------------------------------------------------------------

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
                needed = 2 * len(self.setup.protocol.keys_of_people)  # good and bad of each
                if self.setup.practice and len(self._practised) == needed:
                    self.ask_to_stop("practised")
            case TakenFor(step=step, value=value, person=person) if step >= 0 and value != 0:
                self._practised.add((person, value > 0))
            case PressSuggested(key=key, time_ns=time_ns):
                delay_s = max(0, time_ns - self._clock.now_ns()) / NS_PER_S
                after(self, delay_s, lambda: self._press_simulated(key))
        self.play.show(occurrence)

    def _on_disk_news(self) -> None:
        """Confirm the presses that are in the file by now; end the session where the disk has failed."""
        self.live.confirm()
        if self._recorder is not None and self._recorder.failure is not None and self.live.phase == "running":
            # A participant must not go on for minutes for a recording that is not written.
            self.ask_to_stop("disk-failed")
            self.play.show_disk_failure()

    def _look(self) -> None:
        """Say on the screen what the disk and the worker are late with."""
        if self._recorder is None or self.live.phase not in ("running", "stopping"):
            return
        self._on_disk_news()
        self._garbage.look(covered=self.live.gate.covered)
        late = self.live.unconfirmed_s() > SAVING_S or self._recorder.unsynced_s() > BEHIND_S
        self.play.feedback.show_saving(late and self._recorder.failure is None)
        silent_s = self.live.silent_s()
        self.play.show_silence(silent_s if silent_s > SILENCE_S and self.live.phase == "running" else None)

    def ask_to_stop(self, reason: StopReason = "participant", patience_s: float | None = None) -> None:
        """End the session; the closing screen comes when the worker has said its last word.

        Args:
            reason: for the recording.
            patience_s: how long to wait for that word, seconds; None decides by whether the worker answers.
        """
        if patience_s is None:
            patience_s = SILENT_PATIENCE_S if self.live.silent_s() > SILENCE_S else PATIENCE_S
        self.live.stop(reason)
        after(
            self,
            patience_s,
            lambda: self.live.give_up(f"The learner did not answer within {patience_s:.0f} s."),
        )

    def _on_over(self, trouble: str | None) -> None:
        self._link.stop_listening()
        self.run_worker(self._close_up(trouble), exclusive=True)

    async def _close_up(self, trouble: str | None) -> None:
        """Close worker and recording without blocking the screen, then show how it ended."""
        self._garbage.collect()
        gone = self.ended_by == getattr(signal, "SIGHUP", signal.SIGTERM)
        await asyncio.to_thread(self._link.close, SIGNAL_PATIENCE_S / 4 if gone else 2.0)
        path = kept = None
        if self._recorder is not None:
            closing_s = SIGNAL_PATIENCE_S / 2 if gone else CLOSING_S
            problem, path = await asyncio.to_thread(close_recorder, self._recorder, closing_s)
            kept = self._recorder.kept
            trouble = "\n\n".join(part for part in (problem, trouble) if part) or None
        setup = self.setup
        warning = "" if setup.simulated else pace_warning(setup.protocol, self._worker_ready)
        outcome = self._outcome = SessionOutcome(
            path, self.live.tally, trouble, kept=kept, warning=warning, stopped=self.live.stop_reason
        )
        if self.ended_by is not None:
            self._go(outcome)
            return
        while len(self.screen_stack) > 1:
            self.pop_screen()
        protocol = self.setup.protocol
        self.push_screen(
            ClosingScreen(
                outcome,
                words_of(protocol.game),
                show_weight=protocol.screen.show_weight,
                in_study=bool(self.setup.study),
                practice=self.setup.practice,
                protocol=protocol,
            )
        )

    def _on_loop_error(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Fail loudly where a callback of the event loop fails: asyncio would only log it, behind the
        screen.
        """
        error = context.get("exception")
        if isinstance(error, Exception):
            self.call_later(_raise, error)
        else:
            loop.default_exception_handler(context)


def _raise(error: Exception) -> None:
    raise error


def key_name(event: events.Key) -> str:
    """Return the key as it is recorded: Shift and Caps Lock change a letter's character, not its key."""
    return event.key.lower() if len(event.key) == 1 else event.key


def build_app(setup: SessionSetup, link: Link, *, clock: Clock | None = None) -> ArlApp:
    """Return the app: the one factory, for the command line and for tests."""
    return ArlApp(setup, link, clock=clock)
