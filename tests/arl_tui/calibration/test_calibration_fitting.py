"""What becomes of the trials: delays kept per task, and what stops only itself."""

from pathlib import Path

import numpy as np
import pytest

from arl_tui.calibration.fitting import FitOrder, fit_files, is_late
from arl_tui.calibration.group import GroupOrder, fit_group
from arl_tui.commands.credit import settle_credit
from arl_tui.participants import choose_credit, read_delays
from core.feedback.credit import GammaDelay
from core.session.protocol_reading import protocol_from
from studies.reaction_time.sample import FitError
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.calibrating import quick
from tests.arl_tui.trial_files import judgements, record_of, write_session


def test_a_fit_is_kept_per_task_and_pooled_from_five_people_on(tmp_path: Path) -> None:
    schedule = make_schedule(quick("feedback-lag", n_trials=30, time_out_s=3.0), 3)
    means = [0.55, 0.6, 0.65, 0.7, 0.75]
    paths = [
        write_session(tmp_path, f"P{k}", schedule, judgements(k, 30, mean), planned="feedback-lag")
        for k, mean in enumerate(means)
    ]
    order = FitOrder(recordings=str(tmp_path), participant="P4", files=(str(paths[4]),))
    (delay,) = fit_files(order).delays
    assert delay.n_observed == 30
    assert delay.mean_s.low < np.mean(judgements(4, 30, 0.75)) < delay.mean_s.high
    assert delay.pooled is not None
    assert delay.pooled_people == 5
    own, pooled = (d.offset_s + d.shape * d.scale_s for d in (delay.delay, delay.pooled))
    assert pooled < own  # the slowest of five is pulled towards the others
    assert read_delays(tmp_path, "P4") is not None
    assert choose_credit("participant", tmp_path, "P4").delay == delay.delay
    assert isinstance(choose_credit("pooled", tmp_path, "P4").delay, GammaDelay)


def test_a_participant_without_trials_has_the_middle_of_the_group(tmp_path: Path) -> None:
    schedule = make_schedule(quick("feedback-lag", n_trials=30, time_out_s=3.0), 3)
    for k, mean in enumerate([0.55, 0.6, 0.65, 0.7, 0.75]):
        write_session(tmp_path, f"P{k}", schedule, judgements(k, 30, mean), planned="feedback-lag")
    group = fit_group(GroupOrder(recordings=str(tmp_path), game="tetris"))
    assert group.n_people == len(group.files) == 5
    means = [np.mean(judgements(k, 30, mean)) for k, mean in enumerate([0.55, 0.6, 0.65, 0.7, 0.75])]
    assert group.delay.mean_s == pytest.approx(np.mean(means), rel=0.05)
    protocol = protocol_from({"delay_of": "feedback-lag", "delay_if_missing": "pooled"}, to_run=True)
    settled, source = settle_credit(protocol, None, tmp_path, "P9")
    assert settled.agent.credit.delay == group.delay
    assert source["credit"] == "pooled"
    assert source["credit_people"] == "5"
    assert source["credit_files"].split() == list(group.files)
    assert source["credit_missing"] == "P9 has no measured delay: pooled"
    with pytest.raises(FitError, match="at least 5"):
        fit_group(GroupOrder(recordings=str(tmp_path), game="keepaway"))


def test_too_few_answers_are_a_failure_with_its_reason_and_do_not_stop_other_tasks(tmp_path: Path) -> None:
    few = write_session(tmp_path, "P1", make_schedule(quick("simple"), 3), [0.3, 0.31])
    enough = write_session(
        tmp_path,
        "P1",
        make_schedule(quick("choice", n_trials=20), 3),
        judgements(1, 20, 0.5),
        planned="choice",
    )
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=(str(few), str(enough))))
    assert "2 usable responses" in fitted.failures["simple"]
    assert [delay.task for delay in fitted.delays] == ["choice"]
    assert fitted.delays[0].pooled is None


def test_numerical_trouble_in_one_task_leaves_the_others_and_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from studies.reaction_time import fit

    fit_as_usual = fit.fit_participant

    def fail_at_first(*arguments):
        monkeypatch.setattr(fit, "fit_participant", fit_as_usual)
        raise ValueError("f(a) and f(b) must have different signs")

    monkeypatch.setattr(fit, "fit_participant", fail_at_first)
    paths = [
        str(
            write_session(
                tmp_path, "P1", make_schedule(quick(name, n_trials=8), 3), judgements(1, 8, 0.5), planned=name
            )
        )
        for name in ("simple", "choice")
    ]
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=tuple(paths)))
    assert "different signs" in fitted.failures["simple"]
    assert [delay.task for delay in fitted.delays] == ["choice"]


def test_somebody_elses_damaged_file_stops_the_pooling_only(tmp_path: Path) -> None:
    schedule = make_schedule(quick("simple", n_trials=8), 3)
    own = write_session(tmp_path, "P1", schedule, judgements(1, 8, 0.4))
    write_session(tmp_path, "P2", schedule, [0.3]).write_text("rubbish\n")
    fitted = fit_files(FitOrder(recordings=str(tmp_path), participant="P1", files=(str(own),)))
    assert "P2-simple" in fitted.failures["simple, pooled"]
    assert [delay.n_observed for delay in fitted.delays] == [8]


def test_a_stimulus_is_late_when_it_came_long_after_its_foreperiod() -> None:
    schedule = make_schedule(quick("simple"), 3)
    due_ns = 5 * 10**9 + round(schedule.trials[0].foreperiod_s * 1e9)
    times = {"started_ns": 5 * 10**9, "asked_ns": due_ns + 10**6}
    assert not is_late(record_of(schedule, 0, 0.3, **times, flushed_ns=due_ns + 59 * 10**6))
    assert is_late(record_of(schedule, 0, 0.3, **times, flushed_ns=due_ns + 61 * 10**6))
    assert not is_late(record_of(schedule, 0, None, **times, flushed_ns=None))
