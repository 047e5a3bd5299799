"""Sarsa one step at a time: the kernels' learner, with another side choosing."""

import numpy as np
import pytest

from core.domain import Choices
from core.learners.contract import StepwiseLearner
from core.learners.sarsa import SarsaConfig, decide, end_episode, last_value, new_sarsa, take_action
from core.learners.sarsa_learner import SarsaLearner
from core.numerics.streams import stream
from core.numerics.tile_coding import Range, from_runs, tile_coder

CODER = tile_coder((Range(0.0, 4.0, 1.0), Range(0.0, 2.0, 1.0)), 4)


def choices(windows, actor: int = 0, time: int = 0) -> Choices:
    # The middle of the cell whose last window this is.
    observation = CODER.low + (np.array(windows) - CODER.offset + 0.5) / CODER.cells_per_unit
    return Choices(np.empty((3, 0)), np.zeros((3, 1)), np.zeros(3, np.bool_), actor, time, observation)


def learner(**settings) -> SarsaLearner:
    pupil = SarsaLearner(SarsaConfig(**settings), CODER, n_learners=2, n_actions=3, reward_is_time=True)
    pupil.begin_episode(rng=stream(0, "test"))
    return pupil


def test_it_is_a_stepwise_learner():
    assert isinstance(learner(), StepwiseLearner)


@pytest.mark.parametrize("settings", [{}, {"trace_decay": 0.8}, {"shared_weights": True, "exploration": 0.3}])
def test_alone_it_is_the_compiled_learner_bit_for_bit(settings):
    pupil = learner(**settings)
    compiled = new_sarsa(SarsaConfig(**settings), CODER, 2, 3)
    world = stream(1, "world")
    for episode in range(20):
        pupil.begin_episode(rng=stream(2, episode))
        rng = stream(2, episode)
        time = 0
        for _ in range(10):
            time += int(world.integers(1, 9))
            actor = int(world.integers(2))
            windows = np.array([world.integers(0, 16), CODER.offset[1] + world.integers(0, 8)])
            decision = choices(windows, actor, time)
            action = pupil.act(pupil.values(decision), -1)
            pupil.took(decision, action, 0.0)
            assert action == decide(compiled, actor, windows, time, rng)
        pupil.end_episode(time + 3, terminated=True)
        end_episode(compiled, time + 3)
    np.testing.assert_array_equal(pupil.sarsa.weights, compiled.weights)
    assert pupil.sarsa.weights.any()


def test_it_learns_from_what_was_done_not_from_what_it_would_have_done():
    # alpha 0.5 over 8 tiles; the option of 4 cycles, taken by another side, is worth 0 and leads to a value
    # of 0.
    pupil = learner(step_size=0.5, exploration=0.0)
    pupil.took(choices([0, 16], time=0), 2, 0.0)
    pupil.took(choices([8, 20], time=4), 1, 0.0)
    assert pupil.values(choices([0, 16])).tolist() == [0.0, 0.0, pytest.approx(0.5 * 4)]


def test_taking_an_action_learns_towards_the_value_of_that_action_by_hand():
    sarsa = new_sarsa(SarsaConfig(step_size=0.5, discount=0.9), CODER, 1, 3)
    first, second = np.array([0, 16]), np.array([8, 20])
    take_action(sarsa, 0, first, 2, 0, 0.0)
    sarsa.values[0] = [5.0, 3.0, 7.0]
    before = last_value(sarsa, 0)
    take_action(sarsa, 0, second, 1, 2, before)
    # Reward of two cycles at gamma 0.9 is 1 + 0.9; then 0.81 of the value of the action taken: 1.9 + 2.43 =
    # 4.33.
    assert last_value(sarsa, 0) == 0.0
    assert pupil_value(sarsa, first, 2) == pytest.approx(0.5 * 4.33)
    assert sarsa.last_action[0] == 1
    assert sarsa.last_time[0] == 2


def pupil_value(sarsa, windows, action: int) -> float:
    return sum(sarsa.weights[0, action, first : first + 4].sum() for first in windows)


def test_the_preferred_action_is_taken_unless_it_explores():
    pupil = learner(exploration=0.25)
    taken = [pupil.act(np.array([9.0, 0.0, 0.0]), 1) for _ in range(4000)]
    # An exploring decision takes any of three: 1/4 * 2/3 take another one. Standard error 0.0059; allow 4.
    assert np.mean(np.array(taken) != 1) == pytest.approx(1 / 6, abs=0.024)
    assert set(taken) == {0, 1, 2}


def test_asking_is_not_learning():
    pupil = learner()
    before = pupil.state_digest()
    for _ in range(5):
        pupil.act(pupil.values(choices([0, 16], time=3)), -1)
    assert pupil.state_digest() == before


def test_of_an_episode_that_was_broken_off_the_last_options_teach_nothing():
    pupil = learner()
    pupil.took(choices([0, 16], time=0), 0, 0.0)
    pupil.end_episode(50, terminated=False)
    assert not pupil.sarsa.weights.any()
    pupil.took(choices([0, 16], time=0), 0, 0.0)
    pupil.end_episode(50, terminated=True)
    assert pupil.sarsa.weights.any()


def test_what_it_exports_is_all_it_has_learned():
    pupil = learner()
    for time in (0, 4, 9):
        pupil.took(choices([time, 16], actor=time % 2, time=time), time % 3, 0.0)
    exported = pupil.export()
    shape = tuple(int(length) for length in exported["sarsa-shape"])
    weights = from_runs(exported["sarsa-starts"], exported["sarsa-values"], int(np.prod(shape)))
    np.testing.assert_array_equal(weights.reshape(shape), pupil.sarsa.weights)
    assert weights.any()


def test_it_learns_from_rewards_of_either_sign_and_from_how_long_they_took_by_hand():
    # alpha 0.5; learner 0 decides at 0 and 3, learner 1 at 1; gamma 0.9. Option of 0: -1 at once, 0.9 * 4 at
    # time 1.
    pupil = SarsaLearner(
        SarsaConfig(step_size=0.5, discount=0.9, exploration=0.0), CODER, n_learners=2, n_actions=3
    )
    pupil.begin_episode(rng=stream(0, "test"))
    pupil.took(choices([0, 16], actor=0, time=0), 2, -1.0)
    pupil.took(choices([0, 16], actor=1, time=1), 0, 4.0)
    pupil.took(choices([8, 20], actor=0, time=3), 1, -2.0)
    assert pupil.values(choices([0, 16]))[2] == pytest.approx(0.5 * (-1.0 + 0.9 * 4.0))
    pupil.end_episode(5, terminated=True)
    # Of 1: 4 at once, 0.81 * -2 at time 3. Of 0's last option: -2.
    assert pupil.values(choices([0, 16], actor=1))[0] == pytest.approx(0.5 * (4.0 - 0.81 * 2.0))
    assert pupil.values(choices([8, 20]))[1] == pytest.approx(0.5 * -2.0)
