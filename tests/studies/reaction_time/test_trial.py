import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.numerics.clock import NS_PER_MS, ManualClock
from studies.reaction_time.protocol import BlockPlan, Schedule, TaskConfig, TrialPlan
from studies.reaction_time.trial import Trial

FOREPERIOD_MS = 1000
QUIET_MS = 150
ASKED_MS = QUIET_MS + FOREPERIOD_MS
ONSET_MS = ASKED_MS + 20


class Stage:
    """A trial with a screen that flushes 20 ms after being asked, on a clock in whole milliseconds."""

    def __init__(self, expected=("j",), *, catch=False, task="choice"):
        config = TaskConfig(task=task, time_out_s=2.0)
        stimulus = "" if catch else ">>>"
        plan = TrialPlan(
            index=0, foreperiod_s=1.0, stimulus=stimulus, condition="c", expected_keys=expected, catch=catch
        )
        block = BlockPlan(index=0, practice=False, trials=(plan,))
        schedule = Schedule(config=config, root_seed=0, allowed_keys=("f", "j"), blocks=(block,))
        self.clock = ManualClock()
        self.trial = Trial(plan, block, schedule, self.clock)

    def at(self, time_ms):
        self.clock.advance_to_ns(round(time_ms * NS_PER_MS))
        return self.trial.poll()

    def show(self):
        """Run up to the flushed stimulus."""
        self.at(QUIET_MS)
        assert self.at(ASKED_MS).kind == "show stimulus"
        self.clock.advance_to_ns(ONSET_MS * NS_PER_MS)
        self.trial.flushed(ONSET_MS * NS_PER_MS, 16 * NS_PER_MS)
        return self

    def press(self, key, time_ms, *, arrives_ms=None):
        self.clock.advance_to_ns(round((time_ms if arrives_ms is None else arrives_ms) * NS_PER_MS))
        self.trial.pressed(key, round(time_ms * NS_PER_MS))
        return self

    def run(self, presses, flush_delay_ms=20):
        """Play presses [(ms, key)] in order of time against a polling screen; return the record."""
        pending = sorted(presses)
        for now in range(0, 4000, 5):
            self.clock.advance_to_ns(now * NS_PER_MS)
            while pending and pending[0][0] <= now:
                time_ms, key = pending.pop(0)
                self.trial.pressed(key, time_ms * NS_PER_MS)
            action = self.trial.poll()
            if action.kind == "show stimulus":
                flush_at = now + flush_delay_ms
            if self.trial.phase == "asked" and now >= flush_at:
                self.trial.flushed(now * NS_PER_MS)
            if action.kind == "finished":
                return self.trial.record
        raise AssertionError(f"not finished: {self.trial.phase}")


def test_a_right_key_is_timed_from_the_flush_by_the_keys_own_time():
    stage = Stage().show().press("j", ONSET_MS + 312, arrives_ms=ONSET_MS + 340)
    record = stage.trial.record
    assert (record.status, record.key, record.rt_s) == ("ok", "j", pytest.approx(0.312))
    assert record.flushed_ns == ONSET_MS * NS_PER_MS
    assert record.asked_ns == ASKED_MS * NS_PER_MS
    assert record.frame_interval_ns == 16 * NS_PER_MS
    assert stage.trial.poll().kind == "finished"


@pytest.mark.parametrize(
    ("key", "rt_ms", "status"),
    [("j", 99.9, "anticipation"), ("j", 100.1, "ok"), ("f", 400, "wrong key"), ("j", 2000, "ok")],
)
def test_keys_are_judged_by_what_they_are_and_when(key, rt_ms, status):
    assert Stage().show().press(key, ONSET_MS + rt_ms).trial.record.status == status


def test_nobody_presses_and_the_trial_times_out_after_late_mail_had_time():
    stage = Stage().show()
    assert stage.at(ONSET_MS + 2000).kind == "wait"
    assert stage.at(ONSET_MS + 2100).kind == "finished"
    assert (stage.trial.record.status, stage.trial.record.rt_s) == ("time-out", None)


def test_a_key_in_time_that_arrives_late_still_counts_and_a_late_key_does_not():
    in_time = Stage().show()
    in_time.at(ONSET_MS + 2050)
    assert in_time.press("j", ONSET_MS + 1999, arrives_ms=ONSET_MS + 2060).trial.record.status == "ok"
    late = Stage().show().press("j", ONSET_MS + 2001)
    late.at(ONSET_MS + 2100)
    assert late.trial.record.status == "time-out"


def test_early_presses_are_counted_and_the_first_key_after_the_onset_answers():
    stage = Stage()
    stage.at(QUIET_MS)
    stage.press("f", 300).press("f", 1000 + 100)
    stage.show().press("j", ONSET_MS + 300).press("f", ONSET_MS + 310)
    assert (stage.trial.record.early_presses, stage.trial.record.key) == (2, "j")


def test_a_key_between_asking_and_flushing_is_early():
    stage = Stage()
    stage.at(QUIET_MS)
    stage.at(ASKED_MS)
    stage.press("j", ASKED_MS + 5)
    stage.trial.flushed(ONSET_MS * NS_PER_MS)
    assert stage.trial.phase == "shown"
    # The same key again, too soon to rule out that it is still held: decided when nothing follows.
    stage.press("j", ONSET_MS + 400)
    assert stage.trial.phase == "confirming"
    assert stage.at(ONSET_MS + 400 + 180).kind == "finished"
    assert (stage.trial.record.early_presses, stage.trial.record.status) == (1, "ok")


def test_a_key_after_the_onset_that_arrives_before_the_news_of_the_flush_is_the_response():
    stage = Stage()
    stage.at(QUIET_MS)
    stage.at(ASKED_MS)
    stage.press("j", ONSET_MS + 250)
    stage.trial.flushed(ONSET_MS * NS_PER_MS)
    assert (stage.trial.record.rt_s, stage.trial.record.early_presses) == (pytest.approx(0.25), 0)


def test_keys_outside_the_allow_list_are_counted_and_answer_nothing():
    stage = Stage().show().press("x", ONSET_MS + 200).press("j", ONSET_MS + 300)
    assert (stage.trial.record.other_presses, stage.trial.record.rt_s) == (1, pytest.approx(0.3))


@pytest.mark.parametrize("delay_ms", [250, 500, 660])
@pytest.mark.parametrize("interval_ms", [25, 40])
def test_a_key_held_since_the_foreperiod_is_a_repeat_not_a_reaction(delay_ms, interval_ms):
    # Pressed shortly before the onset and held: the first repeat falls after the onset, the others follow.
    pressed_ms = ONSET_MS - 100
    held = [(pressed_ms, "j")] + [(pressed_ms + delay_ms + i * interval_ms, "j") for i in range(8)]
    record = Stage().run(held)
    assert (record.status, record.early_presses) == ("repeat", 1)


def test_a_run_already_under_way_at_the_onset_is_a_repeat():
    record = Stage().run([(ONSET_MS - 600, "j")] + [(ONSET_MS - 100 + 30 * i, "j") for i in range(10)])
    assert record.status == "repeat"


def test_a_held_key_keeps_the_trial_from_starting():
    stage = Stage()
    for time_ms in range(0, 600, 30):
        stage.press("j", time_ms)
        assert stage.trial.poll().kind == "release keys"
    assert stage.at(570 + 149).kind == "release keys"
    assert stage.at(570 + 150).kind == "wait"
    assert stage.trial.phase == "foreperiod"


@pytest.mark.parametrize("catch", [True, False])
def test_withholding_where_no_key_is_expected_is_right_and_pressing_is_wrong(catch):
    held_back = Stage((), catch=catch).run([])
    assert (held_back.status, held_back.key) == ("ok", None)
    pressed = Stage((), catch=catch).run([(ONSET_MS + 300, "j")])
    assert pressed.status == "wrong key"
    assert (pressed.flushed_ns is None) == catch


def test_a_trial_that_is_left_is_recorded_as_abandoned_once_it_has_begun():
    stage = Stage()
    assert stage.trial.abandon("stop key") is None
    stage.at(QUIET_MS)
    stage.at(500)
    record = stage.trial.abandon("stop key")
    assert record is not None
    assert record.comment == "abandoned: stop key"
    assert record.rt_s is None


def test_the_record_and_the_flush_are_refused_out_of_turn():
    stage = Stage()
    with pytest.raises(ValueError, match="not finished"):
        _ = stage.trial.record
    with pytest.raises(ValueError, match="no stimulus was asked for"):
        stage.trial.flushed(0)


def test_polling_tells_how_long_to_wait():
    stage = Stage()
    assert stage.at(0).until_ns == QUIET_MS * NS_PER_MS
    assert stage.at(QUIET_MS).until_ns == ASKED_MS * NS_PER_MS


@settings(max_examples=60)
@given(st.lists(st.tuples(st.integers(0, 3900), st.sampled_from("fjx")), max_size=12), st.booleans())
def test_any_keys_at_all_end_in_one_consistent_record(presses, catch):
    record = Stage(() if catch else ("j",), catch=catch).run(presses)
    onset = record.asked_ns if catch else record.flushed_ns
    assert onset is not None
    assert record.ended_ns >= onset
    if record.key is None:
        assert record.rt_s is None
        assert record.status == ("ok" if catch else "time-out")
    else:
        assert record.rt_s == pytest.approx((record.key_ns - onset) / 1e9)
        assert 0.0 <= record.rt_s <= record.time_out_s
        in_window = [t for t, k in presses if k != "x" and onset <= t * NS_PER_MS <= record.key_ns]
        assert min(in_window) * NS_PER_MS == record.key_ns
