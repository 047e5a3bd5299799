"""Runs the trials of one block: shows what the trial says, tells it of keys and flushes, hands its record
on.
"""

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from typing import ClassVar

import msgspec
from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Center, Horizontal, Vertical
from textual.screen import Screen
from textual.widgets import Static

from arl_tui.app.garbage import GarbageControl
from arl_tui.calibration.texts import LET_GO, key_reminder, practice_word, session_keys
from arl_tui.games.panel import SMALLEST
from arl_tui.games.trial_view import TrialView
from arl_tui.language import tr
from arl_tui.screens.covers import fits_into
from core.numerics.clock import NS_PER_S, Clock, seconds
from studies.reaction_time.protocol import BlockPlan, Schedule, TrialPlan, TrialRecord
from studies.reaction_time.trial import Trial, TrialTiming

GAP_S = 0.4
"""From the end of a trial to the next one."""
WORD_S = 1.2
"""How long a word about a practice trial stands."""
PATIENCE_S = 1.0
"""A participant who still holds a key after this long is asked to let go."""


class TrialScreen(Screen[bool], inherit_bindings=False):
    """One block. Its result: whether it went to its end."""

    BINDING_GROUP_TITLE = "Trials"
    AUTO_FOCUS = None
    ALLOW_SELECT = False
    BINDINGS: ClassVar[list[BindingType]] = [
        # Help comes on the page that says that the trial waits.
        Binding("p,q,f1,ctrl+q,ctrl+c", "interrupt", "Pause", id="trial.pause", tooltip="Pause, or stop"),
    ]
    DEFAULT_CSS = """
    TrialScreen { align: center middle; }
    TrialScreen #trial { width: auto; height: auto; }
    TrialScreen .game { layout: horizontal; }
    TrialScreen #words { width: 44; height: auto; margin-left: 2; }
    TrialScreen #words Static { width: 100%; text-align: center; }
    TrialScreen #progress { height: 1; margin-bottom: 1; color: $foreground 70%; }
    TrialScreen #word { height: 1; margin: 1 0; }
    TrialScreen #reminder { height: 2; }
    TrialScreen #session { height: 1; margin-top: 1; color: $foreground 65%; }
    TrialScreen Center { width: 44; height: auto; }
    """

    def __init__(
        self,
        schedule: Schedule,
        block: BlockPlan,
        plans: Sequence[TrialPlan],
        view: TrialView,
        *,
        clock: Clock,
        garbage: GarbageControl,
        keep: Callable[[TrialRecord], bool],
        study: bool = True,
        timing: TrialTiming | None = None,
    ) -> None:
        """Prepare the block.

        Args:
            schedule: of the task.
            block: the block.
            plans: those of its trials that are still to be run.
            view: what trials look like.
            clock: of the trials: the one of flushes and keys.
            garbage: held back during trials.
            keep: writes a record to the disk; False where the disk failed and no trial may follow.
            study: whether the block's words are shown first.
            timing: limits for keys.
        """
        super().__init__()
        self._schedule = schedule
        self._block = block
        self._plans = plans
        self._view = view
        self._clock = clock
        self._garbage = garbage
        self._keep = keep
        self._study_items = block.study_items if study else ()
        self._timing = timing
        self._trial: Trial | None = None
        self._news = asyncio.Event()
        self._left = False
        self._word = Static(id="word")
        self._progress = Static(id="progress")

    def compose(self) -> ComposeResult:
        """Lay out stimulus, one line of words, and the keys."""
        task = self._schedule.config.task
        reminder = Static(key_reminder(self._schedule.config), id="reminder")
        session = Static(session_keys(), id="session")
        if task == "feedback lag":
            with Horizontal(id="trial", classes="game"):
                yield self._view.widget
                with Vertical(id="words"):
                    yield self._progress
                    yield reminder
                    yield self._word
                    yield session
        else:
            with Vertical(id="trial"), Vertical(id="words"):
                yield self._progress
                with Center():
                    yield self._view.widget
                yield self._word
                yield reminder
                yield session

    def on_mount(self) -> None:
        """Begin."""
        self.run_worker(self._run(), exclusive=True, name="trials")

    # --- what comes in --------------------------------------------------------------------------------------

    def key_pressed(self, key: str, time_ns: int) -> None:
        """Take a key in, with its message's own time."""
        if self._trial is not None:
            self._trial.pressed(key, time_ns)
            self._news.set()

    def take_drawn(self) -> int:
        """Return the trial whose stimulus has just been painted; -1 where none has."""
        return self._view.take_drawn()

    def flushed(self, trial: int, time_ns: int, frame_interval_ns: int | None) -> None:
        """Note that the painted stimulus of a trial went to the terminal."""
        running = self._trial
        if running is not None and running.plan.index == trial and running.phase == "asked":
            running.flushed(time_ns, frame_interval_ns)
            self._news.set()

    def action_interrupt(self) -> None:
        """Give the running trial up and leave; it will be run again."""
        self.interrupt("pause asked for")

    def on_resize(self, event: events.Resize) -> None:
        """Give up where the stimulus may not be seen whole."""
        if not fits_into(SMALLEST, event.size):
            self.interrupt("window too small")

    def interrupt(self, reason: str) -> None:
        """Give the running trial up and leave."""
        if self._left:
            return
        record = None if self._trial is None else self._trial.abandon(reason)
        if record is not None:
            self._keep(self._noted(record))
        self._leave(False)

    def _leave(self, finished: bool) -> None:
        if not self._left:
            self._left = True
            self._trial = None
            self._garbage.collect()
            self.workers.cancel_node(self)
            self.dismiss(finished)

    # --- trials ---------------------------------------------------------------------------------------------

    async def _run(self) -> None:
        for item in self._study_items:
            await self._show_item(item)
        for plan in self._plans:
            self._tell_progress(plan)
            for item in plan.study_items:
                await self._show_item(item)
            self._garbage.hold()
            record = await self._run_trial(plan)
            if self._left:
                return
            self._garbage.collect()
            self._trial = None
            if not self._keep(self._noted(record)):
                break
            await self._rest(record)
        self.call_later(self._leave, True)

    async def _run_trial(self, plan: TrialPlan) -> TrialRecord:
        trial = Trial(plan, self._block, self._schedule, self._clock, self._timing)
        self._trial = trial
        begun_ns = self._clock.now_ns()
        started_ns: int | None = None
        presented_ns = 0
        while True:
            self._news.clear()
            action = trial.poll()
            now_ns = self._clock.now_ns()
            if action.kind == "finished":
                return trial.record
            if action.kind == "show stimulus":
                self._view.present(plan)
                presented_ns = now_ns
            elif action.kind == "release keys":
                self._view.wait(plan, 0)
                self._word.update(tr(LET_GO) if seconds(now_ns - begun_ns) > PATIENCE_S else "")
            due_ns = action.until_ns
            if trial.phase == "foreperiod" or (plan.catch and trial.phase == "shown"):
                if started_ns is None:
                    started_ns = now_ns
                    self._word.update("")
                due_ns = self._tick(plan, now_ns - started_ns, now_ns, due_ns)
            elif trial.phase in ("shown", "confirming"):
                due_ns = self._follow(plan, now_ns - presented_ns, now_ns, due_ns)
            await self._wait_until(due_ns)

    def _tick(self, plan: TrialPlan, elapsed_ns: int, now_ns: int, due_ns: int | None) -> int | None:
        """Show what is seen now, and return when to come back."""
        if self._view.tick_ns is None:
            self._view.wait(plan, 0)
            return due_ns
        tick, over_ns = divmod(elapsed_ns - self._view.early_ns(plan), self._view.tick_ns)
        self._view.wait(plan, tick)
        next_ns = now_ns + self._view.tick_ns - over_ns
        return next_ns if due_ns is None else min(due_ns, next_ns)

    def _follow(self, plan: TrialPlan, elapsed_ns: int, now_ns: int, due_ns: int | None) -> int | None:
        """Show what comes after the stimulus, and return when to come back."""
        if self._view.tick_ns is None:
            return due_ns
        tick, over_ns = divmod(elapsed_ns, self._view.tick_ns)
        self._view.follow(plan, tick)
        next_ns = now_ns + self._view.tick_ns - over_ns
        return next_ns if due_ns is None else min(due_ns, next_ns)

    async def _wait_until(self, due_ns: int | None) -> None:
        """Wait for a key or a flush, at most until `due_ns`."""
        timeout_s = None if due_ns is None else max(0, due_ns - self._clock.now_ns()) / NS_PER_S
        with contextlib.suppress(TimeoutError):
            # Not `wait_for`, which forgets a cancellation that comes together with the news.
            async with asyncio.timeout(timeout_s):
                await self._news.wait()

    async def _rest(self, record: TrialRecord) -> None:
        self._view.rest()
        if self._block.practice:
            self._word.update(practice_word(record))
            await asyncio.sleep(WORD_S)
            self._word.update("")
        else:
            await asyncio.sleep(GAP_S)

    async def _show_item(self, item: str) -> None:
        self._view.study(item)
        await asyncio.sleep(self._schedule.config.study_item_s)
        self._view.rest()
        # An item that comes twice, or two that look alike, must be seen as two.
        await asyncio.sleep(0.2)

    def _noted(self, record: TrialRecord) -> TrialRecord:
        note = self._view.note(self._schedule.trials[record.trial])
        parts = [part for part in (record.comment, note) if part]
        return msgspec.structs.replace(record, comment="; ".join(parts))

    def _tell_progress(self, plan: TrialPlan) -> None:
        if self._block.practice:
            position = self._block.trials.index(plan) + 1
            self._progress.update(
                tr("Practice: {position} of {trials}", position=position, trials=len(self._block.trials))
            )
            return
        scored = [
            trial.index for block in self._schedule.blocks if not block.practice for trial in block.trials
        ]
        self._progress.update(tr("{done} of {all}", done=scored.index(plan.index) + 1, all=len(scored)))
