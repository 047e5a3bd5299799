"""Policy gradient, without a game."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.combination.config import ADVISE, EXPONENTIAL, LINEAR, LINEAR_RAW
from core.combination.preference import fill_logits
from core.learners.policy_gradient import PolicyGradient, PolicyGradientConfig, PolicyGradientLearner
from core.learners.policy_gradient_kernels import (
    BASELINE,
    fill_score,
    invert_positive,
    learn_from_reward,
    remember_score,
)
from core.numerics.softmax import drawn, exponential, softmax
from core.numerics.streams import stream
from tests.naive import policy_gradient as naive

FORMS = (LINEAR, LINEAR_RAW, EXPONENTIAL, ADVISE)


def learner(n=2, **changes) -> PolicyGradient:
    return PolicyGradient(PolicyGradientConfig(**changes), scales=np.ones(n))


def policy(rows, theta, human=None, w_h=0.0, form=LINEAR, ruled_out=None):
    """Logits, gains, reference and probabilities of one decision."""
    n = len(rows)
    out = np.zeros(n, dtype=bool) if ruled_out is None else np.asarray(ruled_out)
    env = rows @ theta
    human = np.zeros(n) if human is None else np.asarray(human, dtype=float)
    logits, gains, shares = np.empty(n), np.empty(n), np.empty(n)
    reference = fill_logits(env, human, out, n, form, 1.0, w_h, logits, gains)
    softmax(logits, out, n, shares)
    return logits, gains, reference, shares


def score_of(rows, theta, action, **how):
    _, gains, reference, shares = policy(rows, theta, **how)
    out = np.empty(rows.shape[1])
    fill_score(rows, gains, shares, len(rows), action, reference, out)
    return out


@given(x=st.floats(-700.0, 0.0))
def test_the_exponential_is_that_of_the_library_to_a_few_bits(x):
    assert exponential(x) == pytest.approx(math.exp(x), rel=4e-16)


def test_the_exponential_is_1_at_0_and_0_far_below():
    assert exponential(0.0) == 1.0
    assert exponential(-701.0) == exponential(-math.inf) == 0.0


def test_a_softmax_by_hand():
    out = np.empty(3)
    softmax(np.array([0.0, math.log(3.0), 99.0]), np.array([False, False, True]), 3, out)
    np.testing.assert_allclose(out, [0.25, 0.75, 0.0], rtol=1e-15)


def test_where_all_actions_are_ruled_out_the_first_is_certain():
    out = np.empty(2)
    softmax(np.array([0.0, 1.0]), np.array([True, True]), 2, out)
    assert out.tolist() == [1.0, 0.0]


def test_a_point_falls_into_the_share_of_its_action():
    shares = np.array([0.25, 0.0, 0.5, 0.25, 0.0])
    points = [0.0, 0.24, 0.25, 0.74, 0.75, 0.999999]
    assert [drawn(shares, 5, point) for point in points] == [0, 0, 2, 2, 3, 3]
    # Rounding may leave the sum a little below 1: the last action that can be drawn.
    assert drawn(np.array([0.5, 0.4, 0.0]), 3, 0.95) == 1


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("w_h", [0.0, 0.7, -0.7])
def test_logits_are_those_of_the_slow_twin(form, w_h):
    rng = stream(3, "logits", form)
    for _ in range(20):
        rows, theta, human = rng.normal(size=(6, 3)), 2 * rng.normal(size=3), rng.normal(size=6)
        out = rng.random(6) < 0.3
        if out.all():
            continue
        logits, _, _, shares = policy(rows, theta, human=human, w_h=w_h, form=form, ruled_out=out)
        expected = naive.logits(rows @ theta, human, w_h, form, ~out)
        difference = logits[~out] - expected
        np.testing.assert_allclose(difference, difference[0], atol=1e-12)  # a constant does not matter
        np.testing.assert_allclose(shares[~out], naive.probabilities(expected), rtol=1e-12)
        assert not shares[out].any()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("w_h", [0.0, 0.8, -0.8])
def test_the_score_is_the_gradient_of_the_log_probability(form, w_h):
    # R's spread stays below 1 here, so the participant's part of the linear form does not depend on theta.
    rng = stream(5, "score", form)
    rows, theta, human = rng.normal(size=(5, 3)) / 4, rng.normal(size=3) / 2, rng.normal(size=5)
    how = {"human": human, "w_h": w_h, "form": form, "ruled_out": [False, True, False, False, False]}
    for action in (0, 2, 3, 4):
        score = score_of(rows, theta, action, **how)
        for i in range(3):
            step = np.zeros(3)
            step[i] = 1e-6
            above, below = (math.log(policy(rows, theta + s, **how)[3][action]) for s in (step, -step))
            assert score[i] == pytest.approx((above - below) / 2e-6, abs=1e-7)


@pytest.mark.parametrize("baseline", [0.0, 0.7])
def test_over_all_trajectories_the_gradient_is_that_of_the_expected_return(baseline):
    """Two decisions of a task whose second decision and rewards depend on the first action."""
    rng = stream(7, "tiny task")
    first, second = rng.normal(size=(2, 2)), rng.normal(size=(2, 3, 2))
    rewards_1, rewards_2 = rng.normal(size=2), rng.normal(size=(2, 3))
    theta = np.array([0.4, -0.3])

    def expected_return(weights):
        p_1 = naive.probabilities(first @ weights)
        return sum(
            p_1[a] * (rewards_1[a] + naive.probabilities(second[a] @ weights) @ rewards_2[a])
            for a in range(2)
        )

    total = np.zeros(2)
    for a, b in itertools.product(range(2), range(3)):
        pupil = learner(trace_decay=1.0, baseline_rate=0.0, update="episode")
        pupil.memory.weights[:] = theta
        pupil.memory.numbers[BASELINE] = baseline
        pupil.begin_episode()
        chance = naive.probabilities(first @ theta)[a] * naive.probabilities(second[a] @ theta)[b]
        for rows, action, reward in ((first, a, rewards_1[a]), (second[a], b, rewards_2[a, b])):
            remember_score(pupil.memory, score_of(rows, theta, action))
            learn_from_reward(pupil.memory, reward)
        total += chance * pupil.memory.gradient
    exact = [
        (expected_return(theta + step) - expected_return(theta - step)) / 2e-6 for step in np.eye(2) * 1e-6
    ]
    np.testing.assert_allclose(total, exact, atol=1e-8)


@pytest.mark.parametrize("update", ["step", "episode"])
def test_two_steps_by_hand(update):
    pupil = learner(n=1, step_size=0.5, trace_decay=0.5, baseline_rate=0.25, update=update)
    pupil.begin_episode()
    remember_score(pupil.memory, np.array([2.0]))  # e = 2
    learn_from_reward(pupil.memory, 1.0)  # advantage 1 - 0, baseline 0.25
    remember_score(pupil.memory, np.array([-3.0]))  # e = 1 - 3 = -2
    learn_from_reward(pupil.memory, 2.25)  # advantage 2, baseline 0.75
    pupil.end_episode()
    # 1 * 2 + 2 * (-2) = -2, times 0.5: the same sum whenever the weights move
    assert pupil.memory.gradient.tolist() == [-2.0]
    assert pupil.weights.tolist() == [-1.0]
    assert pupil.memory.numbers[BASELINE] == 0.75
    pupil.begin_episode()
    assert not pupil.memory.trace.any()
    assert pupil.memory.numbers[BASELINE] == 0.75


def test_weights_are_in_the_features_own_units():
    pupil = PolicyGradient(PolicyGradientConfig(), scales=[2.0, 4.0])
    pupil.memory.weights[:] = [1.0, 1.0]
    assert pupil.weights.tolist() == [0.5, 0.25]


def test_the_inverse_is_an_inverse():
    factor = stream(2, "matrix").normal(size=(5, 5))
    matrix, out = factor @ factor.T + 0.1 * np.eye(5), np.empty((5, 5))
    invert_positive(matrix, out)
    np.testing.assert_allclose(out @ matrix, np.eye(5), atol=1e-10)


def test_the_natural_gradient_solves_by_the_mean_outer_product_of_the_scores():
    pupil = learner(update="episode", natural=True, step_size=1.0, trace_decay=0.0, baseline_rate=0.0)
    scores, rewards = np.array([[1.0, 0.5], [-0.5, 2.0], [0.3, 0.3]]), [1.0, 2.0, -1.0]
    pupil.begin_episode()
    for score, reward in zip(scores, rewards, strict=True):
        remember_score(pupil.memory, score)
        learn_from_reward(pupil.memory, reward)
    pupil.end_episode()
    fisher = scores.T @ scores / 3 + 0.001 * np.eye(2)
    np.testing.assert_allclose(pupil.weights, np.linalg.solve(fisher, scores.T @ rewards), rtol=1e-10)


def test_the_natural_gradient_does_not_depend_on_the_scale_of_a_feature():
    """What the policy does after an episode is the same for metres and millimetres, but for the ridge."""
    values = []
    for unit in (1.0, 1000.0):
        pupil = learner(
            update="episode",
            natural=True,
            fisher_ridge=1e-12,
            step_size=0.1,
            trace_decay=0.0,
            baseline_rate=0.0,
        )
        pupil.begin_episode()
        rows = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]) * [unit, 1.0]
        for action, reward in ((0, 1.0), (1, 0.0), (2, 2.0), (0, 0.5)):
            remember_score(pupil.memory, score_of(rows, np.zeros(2), action))
            learn_from_reward(pupil.memory, reward)
        pupil.end_episode()
        values.append(rows @ pupil.weights)
    np.testing.assert_allclose(values[0], values[1], rtol=1e-6)


@pytest.mark.statistical
def test_a_bandit_is_learned():
    """Three arms of mean reward 0, 0.5, 1: after 2,000 pulls the best is taken nearly always."""
    rng = stream(11, "bandit")
    pupil, rows = learner(n=3, step_size=0.1), np.eye(3)
    for _ in range(2000):
        pupil.begin_episode()
        shares = policy(rows, pupil.memory.weights)[3]
        action = drawn(shares, 3, rng.random())
        remember_score(pupil.memory, score_of(rows, pupil.memory.weights, action))
        learn_from_reward(pupil.memory, 0.5 * action + rng.normal(scale=0.2))
        pupil.end_episode()
    assert policy(rows, pupil.memory.weights)[3][2] > 0.95


def test_weights_that_overflow_say_what_to_do():
    pupil = learner(step_size=1e308)
    pupil.begin_episode()
    remember_score(pupil.memory, np.array([10.0, 0.0]))
    with np.errstate(over="ignore", invalid="ignore"):
        learn_from_reward(pupil.memory, 10.0)
    with pytest.raises(FloatingPointError, match="smaller step_size"):
        pupil.end_episode()


@pytest.mark.parametrize(
    "wrong",
    [
        {"step_size": -1.0},
        {"trace_decay": 1.5},
        {"baseline_rate": -0.1},
        {"fisher_rate": 0.0},
        {"fisher_ridge": 0.0},
    ],
)
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PolicyGradientConfig(**wrong)


def test_scales_must_be_positive():
    with pytest.raises(ValueError, match="scales are > 0"):
        PolicyGradient(PolicyGradientConfig(), scales=[1.0, 0.0])


def test_a_policy_is_proposed_until_its_performance_is_known():
    proposer = PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0, 2.0])
    first = proposer.propose()
    assert (first.policy_id, proposer.propose().policy_id) == (0, 0)
    proposer.gradient.memory.weights[:] = [1.0, 1.0]
    proposer.report(0, 3.0)
    assert proposer.propose().policy_id == 1
    assert first.weights.tolist() == [0.0, 0.0]
    assert proposer.propose().weights.tolist() == [1.0, 0.5]
    with pytest.raises(ValueError, match="policy 1 waits"):
        proposer.report(0, 1.0)
    with pytest.raises(ValueError, match="performance is finite"):
        proposer.report(1, math.nan)


def test_the_fingerprint_sees_every_part_of_the_state():
    seen = set()
    for part in ("weights", "trace", "gradient", "fisher", "precondition", "numbers"):
        proposer = PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0])
        getattr(proposer.gradient.memory, part)[...] = 7.0
        seen.add(proposer.state_digest())
    assert len(seen) == 6
