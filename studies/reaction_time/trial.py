"""One trial as a state machine: times and keys in, what to show and one record out. No screen, no own clock.

    quiet -> foreperiod -> asked -> shown -> (confirming) -> done

The screen calls `poll` often and does what it says, reports the flush of the stimulus's frame (`flushed`) and
hands over every key with the time in its message (`pressed`). A key is judged by its own time, never by when
it arrived: keys that come while the flush is not yet known wait for it, and a time-out is final only after
late mail had time.
"""

from typing import Literal

import msgspec

from core.numerics.clock import NS_PER_MS, NS_PER_S, Clock, seconds
from studies.reaction_time.protocol import BlockPlan, Schedule, Status, TrialPlan, TrialRecord

Phase = Literal["quiet", "foreperiod", "asked", "shown", "confirming", "done"]


class TrialTiming(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Limits for keys of a terminal, which reports no releases: a held key is a run of presses."""

    quiet_ms: int = 150
    """A trial starts only after this long without keys: a held key must be let go first."""
    repeat_interval_ms: int = 80
    """Presses of one key closer than this are a held key (terminals send one every 25 to 40 ms)."""
    repeat_delay_ms: int = 700
    """The first repeat of a held key comes at most this long after the press (terminals: 200 to 700 ms)."""
    late_mail_ms: int = 100
    """A key whose time lies before the time-out may arrive this much after it."""


class Action(msgspec.Struct, frozen=True):
    """What the screen does now."""

    kind: Literal["wait", "release keys", "show stimulus", "finished"]
    until_ns: int | None = None
    """Nothing happens before this time unless a key comes; None where it is not known."""


class Trial:
    """Runs one trial; a new instance for each."""

    def __init__(
        self,
        plan: TrialPlan,
        block: BlockPlan,
        schedule: Schedule,
        clock: Clock,
        timing: TrialTiming | None = None,
    ) -> None:
        self.plan = plan
        self.phase: Phase = "quiet"
        self._block = block
        self._schedule = schedule
        self._clock = clock
        self._timing = timing or TrialTiming()
        self._presses: list[tuple[int, str]] = []
        self._other_presses = 0
        self._last_key_ns = clock.now_ns()
        self._started_ns = self._last_key_ns
        self._asked_ns: int | None = None
        self._flushed_ns: int | None = None
        self._frame_interval_ns: int | None = None
        self._response: tuple[int, str] | None = None
        self._is_repeat = False
        self._record: TrialRecord | None = None

    @property
    def record(self) -> TrialRecord:
        """The finished trial."""
        if self._record is None:
            raise ValueError(f"trial {self.plan.index} is not finished: it is in phase {self.phase!r}")
        return self._record

    def poll(self) -> Action:
        """Return what to do now; "show stimulus" is said once, then the flush is awaited."""
        now = self._clock.now_ns()
        if self.phase == "quiet":
            ready = self._last_key_ns + self._timing.quiet_ms * NS_PER_MS
            if now < ready:
                return Action("release keys", ready)
            self.phase, self._started_ns = "foreperiod", now
        if self.phase == "foreperiod":
            due = self._started_ns + round(self.plan.foreperiod_s * NS_PER_S)
            if now < due:
                return Action("wait", due)
            return self._ask(now)
        if self.phase == "asked":
            return Action("wait")
        if self.phase == "shown":
            due = self._deadline_ns() + self._timing.late_mail_ms * NS_PER_MS
            if now < due:
                return Action("wait", due)
            self._finish(now)
        if self.phase == "confirming":
            assert self._response is not None
            due = (
                self._response[0] + (self._timing.repeat_interval_ms + self._timing.late_mail_ms) * NS_PER_MS
            )
            if now < due:
                return Action("wait", due)
            self._finish(now)
        return Action("finished")

    def flushed(self, time_ns: int, frame_interval_ns: int | None = None) -> None:
        """Note that the stimulus's frame went to the terminal at `time_ns`."""
        if self.phase != "asked":
            raise ValueError(f"no stimulus was asked for: trial {self.plan.index} is in phase {self.phase!r}")
        self._flushed_ns = time_ns
        self._frame_interval_ns = frame_interval_ns
        self.phase = "shown"
        self._look_for_response()

    def pressed(self, key: str, time_ns: int) -> None:
        """Take a key with its message's own time."""
        if self.phase == "done":
            return
        if self.phase == "quiet":
            self._last_key_ns = max(self._last_key_ns, time_ns)
            return
        if key not in self._schedule.allowed_keys:
            self._other_presses += 1
            return
        self._presses.append((time_ns, key))
        self._presses.sort()
        if self.phase in ("shown", "confirming"):
            self._look_for_response()

    def abandon(self, reason: str) -> TrialRecord | None:
        """Stop the trial, e.g. because the participant leaves; its record, or None if it has not begun."""
        if self.phase == "quiet":
            return None
        if self.phase != "done":
            self._finish(self._clock.now_ns(), comment=f"abandoned: {reason}")
        return self.record

    def _ask(self, now: int) -> Action:
        self._asked_ns = now
        if self.plan.catch:  # nothing is shown: the wait begins at once
            self.phase = "shown"
            return Action("wait", self._deadline_ns())
        self.phase = "asked"
        return Action("show stimulus")

    def _onset_ns(self) -> int | None:
        return self._asked_ns if self.plan.catch else self._flushed_ns

    def _deadline_ns(self) -> int:
        onset = self._onset_ns()
        assert onset is not None
        return onset + round(self._schedule.config.time_out_s * NS_PER_S)

    def _look_for_response(self) -> None:
        """Judge the first allowed key from the onset on; a possible repeat waits for one more key."""
        onset = self._onset_ns()
        assert onset is not None
        after = [press for press in self._presses if onset <= press[0] <= self._deadline_ns()]
        if not after:
            return
        self._response = after[0]
        time_ns, key = after[0]
        earlier = [t for t, k in self._presses if k == key and t < time_ns]
        following = [t for t, k in after[1:] if k == key]
        gap = time_ns - earlier[-1] if earlier else None
        close = self._timing.repeat_interval_ms * NS_PER_MS
        if gap is not None and gap < close:
            self._is_repeat = True
        elif gap is not None and gap <= self._timing.repeat_delay_ms * NS_PER_MS:
            self._is_repeat = bool(following) and following[0] - time_ns < close
            if not self._is_repeat:
                self.phase = "confirming"
                return
        self._finish(self._clock.now_ns())

    def _status(self) -> Status:
        expected = self.plan.expected_keys
        if self._response is None:
            return "ok" if not expected else "time-out"
        onset = self._onset_ns()
        assert onset is not None
        if self._is_repeat:
            return "repeat"
        if self._response[1] not in expected:
            return "wrong key"
        if seconds(self._response[0] - onset) < self._schedule.config.least_rt_s:
            return "anticipation"
        return "ok"

    def _finish(self, now: int, comment: str = "") -> None:
        onset = self._onset_ns()
        key_ns, key = self._response if self._response is not None else (None, None)
        rt_s = seconds(key_ns - onset) if key_ns is not None and onset is not None else None
        self.phase = "done"
        self._record = TrialRecord(
            trial=self.plan.index,
            block=self._block.index,
            task=self._schedule.config.task,
            practice=self._block.practice,
            catch=self.plan.catch,
            condition=self.plan.condition,
            stimulus=self.plan.stimulus,
            expected_keys=self.plan.expected_keys,
            foreperiod_s=self.plan.foreperiod_s,
            started_ns=self._started_ns,
            asked_ns=self._asked_ns,
            flushed_ns=self._flushed_ns,
            key=key,
            key_ns=key_ns,
            rt_s=rt_s,
            status=self._status(),
            early_presses=sum(onset is None or t < onset for t, _ in self._presses),
            other_presses=self._other_presses,
            frame_interval_ns=self._frame_interval_ns,
            time_out_s=self._schedule.config.time_out_s,
            ended_ns=now,
            comment=comment,
        )
