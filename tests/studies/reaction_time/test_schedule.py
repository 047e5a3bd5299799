from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from core.numerics.streams import stream
from studies.reaction_time.protocol import RESPONSE_KEYS, Foreperiod, TaskConfig
from studies.reaction_time.schedule import describe, draw_foreperiods, expected_minutes, make_schedule
from studies.reaction_time.tasks import ALLOWED_KEYS, GRID_ROWS, MAKERS, WORDS

TASKS = list(MAKERS)


def scored(schedule):
    return [trial for block in schedule.blocks if not block.practice for trial in block.trials]


@settings(max_examples=40)
@given(
    st.sampled_from(TASKS), st.integers(0, 9), st.integers(1, 60), st.integers(1, 30), st.integers(0, 2**32)
)
def test_a_schedule_has_the_trials_asked_for_in_blocks_no_longer_than_allowed(
    task, practice, n, longest, seed
):
    config = TaskConfig(task=task, n_practice=practice, n_trials=n, trials_per_block=longest)
    schedule = make_schedule(config, seed)
    assert [trial.index for trial in schedule.trials] == list(range(practice + n))
    lengths = [len(block.trials) for block in schedule.blocks if not block.practice]
    assert sum(lengths) == n
    assert max(lengths) <= longest
    assert max(lengths) - min(lengths) <= 1
    assert [block.practice for block in schedule.blocks] == [
        bool(practice) and i == 0 for i in range(len(schedule.blocks))
    ]
    for trial in schedule.trials:
        assert config.foreperiod.least_s <= trial.foreperiod_s <= config.foreperiod.most_s
        assert set(trial.expected_keys) <= set(schedule.allowed_keys) <= set(RESPONSE_KEYS)
        assert schedule.block_of(trial.index).trials.count(trial) == 1


@pytest.mark.parametrize("task", TASKS)
def test_equal_seeds_give_equal_schedules_and_other_seeds_other_ones(task):
    config = TaskConfig(task=task)
    assert make_schedule(config, 3) == make_schedule(config, 3)
    assert make_schedule(config, 3) != make_schedule(config, 4)


@pytest.mark.statistical
def test_foreperiods_do_not_age():
    f = Foreperiod(least_s=1.0, mean_extra_s=0.8, most_s=4.0)
    drawn = draw_foreperiods(f, 20_000, rng=stream(1, "foreperiods"))
    assert stats.kstest(drawn, stats.truncexpon(3.0 / 0.8, loc=1.0, scale=0.8).cdf).pvalue > 0.001
    # Of those still waiting, equal shares end in every 0.2 s (well before the truncation): 1 - exp(-0.2 /
    # 0.8) = 0.221.
    for start in (1.0, 1.4, 1.8):
        waiting = drawn[drawn >= start]
        share = np.mean(waiting < start + 0.2)
        tail = 1.0 - np.exp(-(4.0 - start) / 0.8)
        assert share == pytest.approx(0.2212 / tail, abs=4 * np.sqrt(0.22 * 0.78 / waiting.size))


def test_catch_trials_show_nothing_and_expect_no_key():
    schedule = make_schedule(TaskConfig(task="memory search", n_trials=40, catch_rate=0.1), 1)
    catches = [trial for trial in scored(schedule) if trial.catch]
    assert len(catches) == 4
    assert all(trial.stimulus == "" and trial.expected_keys == () for trial in catches)
    assert all(trial.study_items for trial in catches)  # nothing gives them away before the stimulus is due


def test_go_no_go_has_its_share_of_go_and_no_catch_trials():
    trials = scored(make_schedule(TaskConfig(task="go/no-go", n_trials=40, go_rate=0.75), 1))
    assert Counter(trial.condition for trial in trials) == {"go": 30, "no-go": 10}
    assert not any(trial.catch for trial in trials)
    assert all((trial.expected_keys == ()) == (trial.condition == "no-go") for trial in trials)


def test_a_memory_probe_is_present_exactly_when_yes_is_expected():
    for trial in make_schedule(TaskConfig(task="memory search", catch_rate=0.0), 5).trials:
        assert (trial.stimulus in trial.study_items) == (trial.expected_keys == ("j",))
        assert len(set(trial.study_items)) == len(trial.study_items)
        assert trial.condition.endswith(f"set size {len(trial.study_items)}")


def test_a_search_display_holds_one_target_or_none_and_the_stated_number_of_letters():
    for trial in make_schedule(TaskConfig(task="visual search", catch_rate=0.0, set_sizes=(4, 9)), 5).trials:
        assert trial.stimulus.count("\n") == GRID_ROWS - 1
        assert trial.stimulus.count("T") == (trial.expected_keys == ("j",))
        assert trial.condition.endswith(str(trial.stimulus.count("T") + trial.stimulus.count("L")))


def test_old_words_were_studied_in_their_block_and_new_ones_were_not():
    schedule = make_schedule(TaskConfig(task="recognition", catch_rate=0.0), 5)
    for block in schedule.blocks:
        assert len(set(block.study_items)) == 16
        for trial in block.trials:
            assert (trial.stimulus in block.study_items) == (trial.expected_keys == ("j",))


def test_set_sizes_and_answers_are_balanced():
    trials = make_schedule(
        TaskConfig(task="memory search", n_practice=0, n_trials=36, trials_per_block=36, catch_rate=0.0), 2
    )
    assert set(Counter(trial.condition for trial in trials.trials).values()) == {6}


@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_feedback_lag_asks_for_judgements_of_good_and_bad_events(game):
    trials = scored(make_schedule(TaskConfig(task="feedback lag", game=game, catch_rate=0.0, n_trials=20), 2))
    assert Counter(trial.expected_keys for trial in trials) == {("j",): 10, ("f",): 10}


@pytest.mark.parametrize("task", TASKS)
def test_the_dry_run_prints_every_trial_and_the_length(task):
    schedule = make_schedule(TaskConfig(task=task), 7)
    text = describe(schedule)
    assert text.count("->") == len(schedule.trials)
    assert text.count("-- break --") == len(schedule.blocks) - 1
    assert "(practice)" in text
    assert f"{expected_minutes(schedule):.1f} min" in text
    assert 1.0 < expected_minutes(schedule) < 12.0


def test_the_word_list_is_large_enough_for_the_longest_study_list():
    assert len(set(WORDS)) == len(WORDS)
    assert len(WORDS) >= 24 + 60  # new words of one block must not repeat before a block's worth
    assert set(ALLOWED_KEYS) == set(MAKERS)


@pytest.mark.parametrize(
    "wrong",
    [
        {"n_trials": 0},
        {"catch_rate": 0.9},
        {"go_rate": 1.0},
        {"time_out_s": 0.05},
        {"set_sizes": (0,)},
        {"n_studied": 99},
        {"trials_per_block": 0},
    ],
)
def test_a_configuration_that_cannot_run_is_refused(wrong):
    with pytest.raises(ValueError, match="expected"):
        TaskConfig(**wrong)


def test_a_foreperiod_that_ends_before_it_begins_is_refused():
    with pytest.raises(ValueError, match="least_s < most_s"):
        Foreperiod(least_s=3.0, most_s=2.0)


def test_a_trial_out_of_the_schedule_has_no_block():
    with pytest.raises(IndexError, match="trials 0 to 47"):
        make_schedule(TaskConfig(), 1).block_of(48)
