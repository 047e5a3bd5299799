"""The app of a calibration: leads a participant through the tasks, from the first page to the fit."""

import asyncio
import signal
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec
from textual import constants, events

from arl_tui.app.driver import FlushClock, stamped_driver
from arl_tui.app.garbage import GarbageControl
from arl_tui.app.plain_app import PlainApp
from arl_tui.calibration.fitting import FitOrder, Fitted
from arl_tui.calibration.helper import HelperError, ask_helper
from arl_tui.calibration.pages import (
    HindrancePage,
    OldSessionPage,
    PausePage,
    SummaryPage,
    WaitingPage,
    WelcomePage,
    page_before,
)
from arl_tui.calibration.plan import PLANNED, CalibrationSetup, Part, new_parts, unfinished
from arl_tui.calibration.texts import key_reminder
from arl_tui.calibration.trial_screen import TrialScreen
from arl_tui.calibration.trial_store import TrialStore
from arl_tui.calibration.views import BoxView
from arl_tui.games.panel import SMALLEST
from arl_tui.games.registry import screens_called
from arl_tui.games.trial_view import TrialView
from arl_tui.language import later
from arl_tui.palette import palette_for
from arl_tui.screens.covers import SmallWindowScreen, fits_into
from arl_tui.screens.page import PageScreen
from arl_tui.session_app import key_name
from core.feedback.keys import nanoseconds
from core.numerics.clock import Clock, MonotonicClock, wall_time_utc
from studies.reaction_time.protocol import Schedule
from studies.reaction_time.trial import TrialTiming
from studies.reaction_time.trial_log import TrialFileError

ANY_FRAME = -1
"""Mark of a frame without a stimulus."""
Helper = Callable[[str, object], Awaitable[bytes]]


@dataclass(frozen=True, slots=True)
class CalibrationOutcome:
    """What is left when the app has closed."""

    files: tuple[Path, ...]
    """Trial files that were written to."""
    finished: bool
    fitted: Fitted
    trouble: str | None = None


class CalibrationApp(PlainApp[CalibrationOutcome]):
    """Tasks, one after another, and what came of them."""

    CSS_PATH = "../app.tcss"
    TITLE = "arl calibrate"

    def __init__(
        self,
        setup: CalibrationSetup,
        *,
        clock: Clock | None = None,
        helper: Helper = ask_helper,
        timing: TrialTiming | None = None,
        theme: str = "dark",
    ) -> None:
        """Prepare.

        Args:
            setup: who does what.
            clock: of trials and frames; keys bring their own time (the monotonic clock's).
            helper: asks another process; see `arl_tui.calibration.helper`.
            timing: limits for keys.
            theme: of the pages (`arl_tui.themes`).
        """
        self._clock = clock or MonotonicClock()
        self._flush_clock = FlushClock(self._clock)
        super().__init__(driver_class=stamped_driver(self._flush_clock), theme=theme, language=setup.language)
        self._setup = setup
        self._helper = helper
        self._timing = timing
        self._garbage = GarbageControl()
        self._store = TrialStore(setup)
        self._stamps_without_driver: list[tuple[int, int]] = []
        self._last_flush_ns: int | None = None
        self._stopping = False
        self._asked: dict[str, asyncio.Future[bytes]] = {}
        """What another process has begun to prepare while pages are read, by module."""

    # --- keys and frames ------------------------------------------------------------------------------------

    def on_mount(self) -> None:
        """Listen to flushes and to requests to end, and begin."""
        self._flush_clock.on_stamp = lambda: self.soon(self._take_flushes)
        self.run_worker(self._conduct(), exclusive=True, name="conduct")

    def on_unmount(self) -> None:
        """Leave the process as it was found."""
        for task in self._asked.values():
            task.cancel()
        self._garbage.restore()
        self._store.close(finished=False)

    async def on_event(self, event: events.Event) -> None:
        """Hand every key press to the running trial before anything else is done with it."""
        if isinstance(event, events.Key) and not event.is_forwarded and isinstance(self.screen, TrialScreen):
            reading = self.reader.read(key_name(event))
            key = key_name(event) if reading is None else reading.letter
            self.screen.key_pressed(key, nanoseconds(event.time))
        await super().on_event(event)

    def post_display_hook(self) -> None:
        """Note that a frame has just been handed to the terminal's writer, and whose stimulus it shows."""
        screen = self.screen_stack[-1] if self.screen_stack else None
        shown = screen.take_drawn() if isinstance(screen, TrialScreen) else ANY_FRAME
        if self._flush_clock.running:
            self._flush_clock.mark(shown)
        else:
            self._stamps_without_driver.append((shown, self._clock.now_ns()))
            self.call_later(self._take_flushes)

    def _take_flushes(self) -> None:
        stamps, self._stamps_without_driver = self._stamps_without_driver, []
        for shown, time_ns in stamps + self._flush_clock.take():
            interval_ns = None if self._last_flush_ns is None else time_ns - self._last_flush_ns
            self._last_flush_ns = time_ns
            screen = self.screen_stack[-1] if self.screen_stack else None
            if shown != ANY_FRAME and isinstance(screen, TrialScreen):
                screen.flushed(shown, time_ns, interval_ns)

    # --- the course -----------------------------------------------------------------------------------------

    async def _conduct(self) -> None:
        setup = self._setup
        if setup.hindrances and not await self._ask(HindrancePage(setup.hindrances)):
            self.exit(CalibrationOutcome((), False, Fitted()))
            return
        parts, resumed = await self._parts()
        self._prepare_games(parts)
        if not await self._ask(WelcomePage(parts, setup.participant, resumed=resumed)):
            self.exit(CalibrationOutcome((), False, Fitted()))
            return
        finished = True
        for part in parts:
            try:
                finished = await self._run_part(part)
            except (OSError, TrialFileError, HelperError) as error:
                finished, self._store.trouble = False, str(error)
            if not finished or self._store.trouble is not None:
                break
        fitted = await self._fit()
        trouble = self._store.trouble
        finished = finished and trouble is None
        await self._ask(SummaryPage(fitted, finished=finished, trouble=trouble))
        self.exit(CalibrationOutcome(tuple(self._store.files), finished, fitted, trouble))

    def _prepare_games(self, parts: tuple[Part, ...]) -> None:
        """Let the game of feedback-lag be prepared while the first pages are read."""
        for part in parts:
            if part.schedule.config.task == "feedback lag" and not part.complete:
                module = screens_called(part.schedule.config.game).judging_module
                self._asked[module] = asyncio.ensure_future(self._helper(module, part.schedule))
                # A caller that waits for it gets its error; if none waits for it, none gets it.
                self._asked[module].add_done_callback(lambda task: task.cancelled() or task.exception())

    async def _ask(self, page: PageScreen) -> bool:
        answer = await self.push_screen_wait(page)
        return bool(answer)

    async def _parts(self) -> tuple[tuple[Part, ...], bool]:
        """Return what is to be done, and whether that goes on with an earlier calibration."""
        old = unfinished(self._setup, wall_time_utc())
        if old is not None and (not old.is_old or await self._ask(OldSessionPage(old))):
            return old.parts, True
        return new_parts(self._setup), False

    async def _run_part(self, part: Part) -> bool:
        """Run what is left of one task; return whether it went to its end."""
        schedule, done = part.schedule, set(part.done)
        if part.complete:
            assert part.path is not None
            self._store.complete.append(part.path)
            return True
        view = await self._view(schedule)
        if view is None:
            return False
        finished = await self._run_blocks(part, schedule, done, view)
        self._store.close(finished=finished)
        return finished

    async def _run_blocks(self, part: Part, schedule: Schedule, done: set[int], view: TrialView) -> bool:
        n_trials = len(schedule.trials)
        fresh, last_block = True, -1
        while len(done) < n_trials and self._store.trouble is None:
            next_trial = next(plan.index for plan in schedule.trials if plan.index not in done)
            block = schedule.block_of(next_trial)
            if block.index != last_block:
                page = page_before(schedule, block, len(done), fresh=fresh, resumed=bool(part.done))
                if not await self._ask(page):
                    return False
            if not fits_into(SMALLEST, self.size) and not await self._ask(SmallWindowScreen(SMALLEST)):
                return False
            if not self._store.is_open:
                self._store.open(part, self._facts())
            plans = [plan for plan in block.trials if plan.index not in done]
            screen = TrialScreen(
                schedule,
                block,
                plans,
                view,
                clock=self._clock,
                garbage=self._garbage,
                keep=lambda record: self._store.keep(record, done),
                study=block.index != last_block,
                timing=self._timing,
            )
            self._garbage.first_paint()
            if not await self.push_screen_wait(screen) and (
                self._stopping or not await self._ask(PausePage(key_reminder(schedule.config)))
            ):
                return False
            view = view.renewed()
            fresh, last_block = False, block.index
        return True

    async def _view(self, schedule: Schedule) -> TrialView | None:
        """Return what trials look like; None where nobody waited for the game to get ready."""
        if schedule.config.task != "feedback lag":
            return BoxView()
        answer = await self._wait_for(
            screens_called(schedule.config.game).judging_module,
            schedule,
            WaitingPage(later("Getting ready"), later("The game is being prepared: some seconds.")),
        )
        if answer is None:
            return None
        palette = palette_for(
            "standard", self.console.color_system, no_color=self.no_color, theme=self.theme_name
        )
        return screens_called(schedule.config.game).trial_view(answer, schedule, palette)

    async def _wait_for(self, module: str, question: object, page: WaitingPage) -> bytes | None:
        """Ask another process while a page says so; None where the participant would not wait.

        Raises:
            HelperError: the process failed.
        """
        task = self._asked.pop(module, None) or asyncio.ensure_future(self._helper(module, question))
        task.add_done_callback(lambda _: self.call_later(page.leave, True))
        try:
            if not await self._ask(page):
                return None
            return await task
        finally:
            task.cancel()

    def _facts(self) -> dict[str, str]:
        from arl_tui.app import facts  # Not needed before the first paint.
        from arl_tui.timing.kept import timing_facts

        stamps = "flush" if self._flush_clock.running else "queued"
        terminal = facts.terminal(
            self.size.width, self.size.height, stamps=stamps, frames_per_s=constants.MAX_FPS
        )
        found = facts.software() | terminal
        if self.theme_name != "dark":
            found["theme"] = self.theme_name
        found |= timing_facts(self._setup.recordings, terminal, wall_time_utc())
        name, resolution_ns = facts.clock_facts()
        found |= {"clock": name, "clock_resolution_ns": str(resolution_ns), PLANNED: self._setup.planned}
        if self._setup.language != "en":
            found["language"] = self._setup.language
        if self._setup.hindrances:
            found["hindrances"] = " and ".join(self._setup.hindrances)
        return found

    def end_by_signal(self, number: signal.Signals) -> None:
        """Keep what there is and close: the window is gone, or the system asks for it."""
        self._stopping = True
        if isinstance(self.screen, TrialScreen):
            self.screen.interrupt("window closed")
        self.call_later(self._leave_by_signal, number)

    def _leave_by_signal(self, number: signal.Signals) -> None:
        self._store.close(finished=False)
        if number == getattr(signal, "SIGHUP", None):
            self.leave_at_once()
        self.exit(CalibrationOutcome(tuple(self._store.files), False, Fitted()), return_code=128 + number)

    async def _fit(self) -> Fitted:
        if not self._store.complete:
            return Fitted()
        order = FitOrder(
            recordings=str(self._setup.recordings),
            participant=self._setup.participant,
            files=tuple(str(path) for path in self._store.complete),
        )
        page = WaitingPage(later("That was it"), later("Your times are being worked out ..."))
        try:
            answer = await self._wait_for("arl_tui.calibration.fitting", order, page)
        except HelperError as error:
            return Fitted(failures={"all": f"{error}. The trials are kept: fit them with --refit."})
        if answer is None:
            return Fitted(failures={"all": "Nobody waited. The trials are kept: fit them with --refit."})
        return msgspec.json.decode(answer, type=Fitted)
