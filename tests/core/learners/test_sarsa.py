"""Sarsa on a chain of three states, by hand: updates, SMDP discounting, traces, Monte Carlo."""

import numpy as np
import pytest

from core.learners.sarsa import (
    NOT_YET,
    SarsaConfig,
    action_values,
    decide,
    end_episode,
    frozen,
    greedy_or_random,
    last_value,
    learn_beside,
    new_sarsa,
    reward_of,
)
from core.numerics.streams import stream
from core.numerics.tile_coding import Range, find_windows, tile_coder

CHAIN = tile_coder((Range(0.0, 2.5, 1.0),), n_tilings=1)


def chain(n_learners=1, n_actions=1, **settings):
    settings = {"step_size": 0.5, "exploration": 0.0} | settings
    return new_sarsa(SarsaConfig(**settings), CHAIN, n_learners, n_actions)


def visit(sarsa, state, time, k=0, rng=None):
    windows = np.zeros(1, np.int64)
    find_windows(CHAIN, np.array([float(state)]), windows)
    return decide(sarsa, k, windows, time, rng or stream(1, "policy"))


def test_each_decision_moves_the_last_value_towards_reward_plus_next_value():
    sarsa = chain()
    sarsa.weights[0, 0] = [10.0, 4.0, 0.0]
    visit(sarsa, 0, 0)
    visit(sarsa, 1, 3)  # Q0 += 0.5 * (3 + 4 - 10) = 8.5
    assert sarsa.weights[0, 0].tolist() == [8.5, 4.0, 0.0]
    visit(sarsa, 2, 5)  # Q1 += 0.5 * (2 + 0 - 4) = 3
    assert sarsa.weights[0, 0].tolist() == [8.5, 3.0, 0.0]
    end_episode(sarsa, 9)  # Q2 += 0.5 * (4 + 0 - 0) = 2
    assert sarsa.weights[0, 0].tolist() == [8.5, 3.0, 2.0]
    assert sarsa.last_time[0] == NOT_YET


def test_the_step_size_is_shared_among_the_active_tiles():
    coder = tile_coder((Range(0.0, 2.5, 1.0), Range(0.0, 2.5, 1.0)), n_tilings=4)
    sarsa = new_sarsa(SarsaConfig(step_size=0.5, exploration=0.0), coder, 1, 1)
    windows = np.zeros(2, np.int64)
    find_windows(coder, np.array([1.0, 2.0]), windows)
    decide(sarsa, 0, windows, 0, stream(1, "policy"))
    end_episode(sarsa, 8)  # error 8, half of it learned, over 2 * 4 tiles: 0.5 each
    assert set(sarsa.weights.ravel()) == {0.0, 0.5}
    out = np.zeros(1)
    action_values(sarsa, 0, windows, out)
    assert out[0] == 4.0


def test_an_option_of_three_cycles_discounts_three_times():
    # Reward 1 + 0.5 + 0.25 = 1.75, next value 8 * 0.5^3 = 1: Q0 += 0.5 * (1.75 + 1 - 0)
    sarsa = chain(discount=0.5)
    sarsa.weights[0, 0] = [0.0, 8.0, 0.0]
    visit(sarsa, 0, 0)
    visit(sarsa, 1, 3)
    assert sarsa.weights[0, 0, 0] == pytest.approx(1.375)
    assert reward_of(3, 0.5) == pytest.approx(1.75)
    assert reward_of(3, 1.0) == 3.0


def test_traces_carry_an_error_back_by_lambda_per_decision():
    sarsa = chain(trace_decay=0.5)
    sarsa.weights[0, 0] = [0.0, 0.0, 6.0]
    visit(sarsa, 0, 0)
    visit(sarsa, 1, 2)  # error 2: Q0 = 1
    visit(sarsa, 2, 3)  # error 1 + 6 - 0 = 7: Q1 = 3.5, Q0 = 1 + 0.5 * 3.5
    assert sarsa.weights[0, 0].tolist() == [2.75, 3.5, 6.0]
    end_episode(sarsa, 4)  # error 1 - 6 = -5: Q2 = 3.5, Q1 -= 1.25, Q0 -= 0.625
    assert sarsa.weights[0, 0].tolist() == [2.125, 2.25, 3.5]


def test_traces_end_with_the_episode():
    sarsa = chain(trace_decay=0.9)
    visit(sarsa, 0, 0)
    end_episode(sarsa, 1)
    before = sarsa.weights[0, 0, 0]
    visit(sarsa, 1, 0)
    end_episode(sarsa, 7)
    assert sarsa.weights[0, 0, 0] == before
    assert not sarsa.traces.any()


def test_the_trace_at_an_options_end_decays_with_the_options_length():
    # gamma 0.5 and an option of 2 cycles: the trace of state 0 becomes 0.25 * lambda.
    sarsa = chain(trace_decay=0.8, discount=0.5)
    visit(sarsa, 0, 0)
    visit(sarsa, 1, 2)
    assert sarsa.traces[0, 0].tolist() == pytest.approx([0.2, 1.0, 0.0])


def test_traces_replace_or_accumulate_only_once_a_state_is_revisited():
    ends = {}
    for replacing in (True, False):
        sarsa = chain(trace_decay=1.0, replacing_traces=replacing)
        visit(sarsa, 0, 0)
        visit(sarsa, 1, 1)
        once = sarsa.traces[0, 0].tolist()
        visit(sarsa, 0, 2)
        ends[replacing] = (once, sarsa.traces[0, 0].tolist())
    assert ends[True][0] == ends[False][0] == [1.0, 1.0, 0.0]
    assert ends[True][1] == [1.0, 1.0, 0.0]
    assert ends[False][1] == [2.0, 1.0, 0.0]


def test_a_replacing_trace_clears_the_other_actions():
    sarsa = chain(n_actions=2, trace_decay=1.0)
    sarsa.weights[0, :, 0] = [0.0, 5.0]
    visit(sarsa, 0, 0)
    sarsa.weights[0, :, 0] = [9.0, 5.0]
    visit(sarsa, 0, 1)
    assert sarsa.traces[0, :, 0].tolist() == [1.0, 0.0]


def test_sarsa_of_one_with_accumulating_traces_is_every_visit_monte_carlo():
    # With a step size too small to matter within the episode, the summed changes are those of Monte Carlo.
    step = 1e-9
    sarsa = chain(step_size=step, trace_decay=1.0, replacing_traces=False, initial_value=1.5)
    visits = [(0, 0), (1, 2), (0, 3), (2, 7), (1, 8)]
    for state, time in visits:
        visit(sarsa, state, time)
    end_episode(sarsa, 12)
    expected = np.zeros(3)
    for state, time in visits:
        expected[state] += (12 - time) - 1.5
    changes = (sarsa.weights[0, 0] - 1.5) / step
    np.testing.assert_allclose(changes, expected, rtol=1e-5)


def test_a_learner_that_looks_on_learns_what_its_own_choice_would_be_worth():
    sarsa = chain(n_actions=2)
    sarsa.weights[0] = [[0.0, 4.0, 0.0], [10.0, 8.0, 0.0]]
    windows = np.zeros(1, np.int64)

    def look_on(state, action, own, time):
        find_windows(CHAIN, np.array([float(state)]), windows)
        before = 0.0 if sarsa.last_time[0] == NOT_YET else last_value(sarsa, 0)
        action_values(sarsa, 0, windows, sarsa.values[0])
        learn_beside(sarsa, 0, windows, action, own, time, before)

    look_on(0, 1, 0, 0)
    look_on(1, 0, 1, 3)  # what was done: Q0(1) += 0.5 * (3 + Q1(own = 1) - 10) = 10.5
    assert sarsa.weights[0].tolist() == [[0.0, 4.0, 0.0], [10.5, 8.0, 0.0]]
    end_episode(sarsa, 9)  # and in state 1 action 0 was done: Q1(0) += 0.5 * (6 - 4) = 5
    assert sarsa.weights[0].tolist() == [[0.0, 5.0, 0.0], [10.5, 8.0, 0.0]]


def test_learners_are_independent_unless_they_share_weights():
    for shared in (False, True):
        sarsa = chain(n_learners=2, shared_weights=shared)
        visit(sarsa, 0, 0, k=0)
        visit(sarsa, 1, 0, k=1)
        end_episode(sarsa, 4)
        if shared:
            assert sarsa.weights.tolist() == [[[2.0, 2.0, 0.0]]]
        else:
            assert sarsa.weights.tolist() == [[[2.0, 0.0, 0.0]], [[0.0, 2.0, 0.0]]]


def test_a_learner_that_never_decided_learns_nothing_at_the_end():
    sarsa = chain(n_learners=2)
    visit(sarsa, 0, 0, k=0)
    end_episode(sarsa, 4)
    assert not sarsa.weights[1].any()


def test_frozen_learners_act_alike_and_do_not_learn():
    sarsa = chain(n_actions=2)
    sarsa.weights[0] = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
    still = frozen(sarsa)
    assert [visit(still, 0, 0), visit(still, 1, 5)] == [0, 1]
    end_episode(still, 9)
    assert sarsa.weights[0].tolist() == [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
    assert sarsa.last_time[0] == NOT_YET


@pytest.mark.statistical
def test_ties_and_exploration_are_uniform():
    rng = stream(3, "policy")
    n = 6000
    tied = np.bincount([greedy_or_random(np.array([1.0, 0.0, 1.0]), 0.0, rng) for _ in range(n)], minlength=3)
    explored = np.bincount([greedy_or_random(np.array([1.0, 0, 0]), 0.3, rng) for _ in range(n)], minlength=3)
    # Binomial standard errors: sqrt(n / 4) = 39 and sqrt(n * 0.1 * 0.9) = 23; allow 4 of them.
    assert tied[1] == 0
    assert abs(tied[0] - n / 2) < 156
    assert abs(explored[1] - n * 0.1) < 93
    assert abs(explored[2] - n * 0.1) < 93


@pytest.mark.parametrize("wrong", [{"discount": 0.0}, {"trace_decay": 1.1}, {"step_size": -1.0}])
def test_impossible_settings_are_refused(wrong):
    with pytest.raises(ValueError, match="discount in"):
        SarsaConfig(**wrong)


def test_an_impossible_exploration_is_refused():
    with pytest.raises(ValueError, match="fraction of decisions"):
        SarsaConfig(exploration=2.0)
