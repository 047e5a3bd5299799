"""Learners side by side: whose turn it is, and whom the learner without the participant makes one believe."""

import numpy as np
import pytest

from core.combination.agent import ArlAgent
from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import AgentConfig, BootstrapConfig, SideBySide
from core.combination.ranking import EpisodeReport
from core.combination.window import DecisionWindow
from core.learners.cross_entropy import CrossEntropyConfig, CrossEntropyLearner
from core.numerics.streams import stream

RULE = SideBySide()
V = np.ones(2)


def learning(rule=RULE, root_seed=3):
    window = DecisionWindow(10, lambda rows, theta: rows @ theta, lambda rows, v: rows @ v)
    return BootstrapLearning(BootstrapConfig(trust=rule), window, root_seed=root_seed)


def report(episode, agreement, performance=5.0):
    return EpisodeReport(episode, np.zeros(2), performance, False, agreement)


def play(agreement, *, rule=RULE, episodes=1200, turns_at=0):
    """Return the w_h of each episode where the three learners agree with the participant as `agreement` says.

    Args:
        agreement: attitude -> signed agreement of that learner's episodes, give or take 0.1 at random.
        rule: settings.
        episodes: how many.
        turns_at: before this episode the learner without the participant agrees by the opposite number.
    """
    bootstrap, rng, used = learning(rule), stream(5, "agreement"), []
    for episode in range(episodes):
        used.append(bootstrap.w_h)
        attitude = bootstrap.w_h / rule.weight
        a = agreement[attitude] + float(rng.normal(0.0, 0.1))
        a = -a if episode < turns_at and attitude == 0.0 else a
        agreed = round(50 + 50 * float(np.clip(a, -1.0, 1.0)))
        bootstrap.record(report(episode, Agreement(100, agreed, 100 - agreed)), V)
    return np.array(used)


def shares(used):
    return [float((used == w_h).mean()) for w_h in (0.0, 1.0, -1.0)]


# Over 900 episodes: 4 standard errors of a fraction of 1/3, of 0.2, of 0.75 and of 0.05.
THIRD, FIFTH, MOST, FEW = 0.063, 0.054, 0.058, 0.03


def test_until_the_own_policy_has_warmed_up_each_learner_plays_a_third():
    used = play({0.0: 0.9, 1.0: 0.9, -1.0: 0.9}, rule=SideBySide(warm_up_episodes=400), episodes=900)
    assert used[0] == 0.0
    assert shares(used) == pytest.approx([1 / 3] * 3, abs=THIRD)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_participant_with_whom_the_own_policy_agrees_is_believed_and_an_adversary_the_other_way(sign):
    used = play({0.0: 0.4 * sign, 1.0: 0.0, -1.0: 0.0})[300:]
    own, believed, opposite = shares(used * sign)
    assert own == pytest.approx(0.2, abs=FIFTH)
    assert believed == pytest.approx(0.75, abs=MOST)
    assert opposite == pytest.approx(0.05, abs=FEW)


def test_agreement_within_the_margin_makes_nobody_believed():
    used = play({0.0: 0.08, 1.0: 0.9, -1.0: -0.9})[300:]
    assert shares(used) == pytest.approx([1 / 3] * 3, abs=THIRD)


def test_what_the_policy_agreed_to_before_it_knew_anything_is_forgotten():
    used = play({0.0: 0.4, 1.0: 0.0, -1.0: 0.0}, turns_at=100)
    assert (used[:100] != 0.0).any()
    assert (used[400:] == 1.0).mean() > 0.6
    assert (used[400:] == -1.0).mean() < 0.1


def test_the_weight_is_that_of_the_two_that_go_by_the_human():
    used = play({0.0: 0.4, 1.0: 0.0, -1.0: 0.0}, rule=SideBySide(weight=0.5))
    assert set(used) == {0.0, 0.5, -0.5}


def test_episodes_without_a_human_policy_change_nothing():
    bootstrap, fresh = learning(), learning()
    for episode in range(50):
        bootstrap.record(report(episode, None), None)
    assert bootstrap.w_h == 0.0
    for one in (bootstrap, fresh):
        one.record(report(50, Agreement(10, 5, 0)), V)
    assert bootstrap.w_h == fresh.w_h


def test_a_match_is_the_signed_one():
    bootstrap = learning()
    bootstrap.record(report(0, Agreement(10, 5, 2)), V)
    assert bootstrap.matches(V) == [pytest.approx(0.3)]


def test_the_fingerprint_tells_of_whose_turn_it_is():
    one, other = learning(root_seed=1), learning(root_seed=2)
    assert one.state_bytes() == other.state_bytes()
    differed = 0
    for episode in range(10):
        for bootstrap in (one, other):
            bootstrap.record(report(episode, Agreement(10, 5, 5)), V)
        if one.w_h != other.w_h:
            differed += 1
            assert one.state_bytes() != other.state_bytes()
    assert differed


def test_an_agent_with_one_learner_refuses_it():
    config = AgentConfig(bootstrap=BootstrapConfig(trust=RULE))
    learner = CrossEntropyLearner(CrossEntropyConfig(), n_weights=2, root_seed=1)
    with pytest.raises(ValueError, match="side by side"):
        ArlAgent(learner, config, n_feedback_features=2, root_seed=1)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"weight": 0.0}, "weight > 0"),
        ({"own_share": 0.0, "other_share": 0.0}, "shares"),
        ({"own_share": 0.9, "other_share": 0.2}, "shares"),
        ({"margin": 1.0}, "margin"),
        ({"episodes": 1}, "episodes"),
        ({"episodes": 61}, "warm_up_episodes"),
    ],
)
def test_impossible_settings_are_refused(changes, reason):
    with pytest.raises(ValueError, match=reason):
        SideBySide(**changes)
