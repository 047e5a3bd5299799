"""Trust by trial: the presses say whether there is anything to try, the environment what to make of it."""

import numpy as np
import pytest
from scipy import stats

from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import BootstrapConfig, RankCorrelation, Tried
from core.combination.ranking import EpisodeReport
from core.combination.trust.measures import rank_human_weight, rank_test
from core.combination.window import DecisionWindow
from core.numerics.streams import stream

V = np.ones(2)


def learning(rule: Tried | RankCorrelation) -> BootstrapLearning:
    window = DecisionWindow(10, lambda rows, theta: rows @ theta, lambda rows, v: rows @ v)
    return BootstrapLearning(BootstrapConfig(trust=rule), window, root_seed=3)


def play(rule: Tried, helps: dict[float, float], *, consistency: float, episodes: int = 300) -> np.ndarray:
    """Let episodes have exponential performance with a mean that depends on w_h; return w_h of each
    episode."""
    bootstrap = learning(rule)
    rng = stream(5, "performance")
    used = []
    for episode in range(episodes):
        used.append(bootstrap.w_h)
        performance = float(rng.exponential(helps[bootstrap.w_h]))
        bootstrap.record(
            EpisodeReport(episode, np.zeros(2), performance, False, Agreement(10, 5, 0), consistency), V
        )
    return np.array(used)


def test_a_participant_who_helps_is_believed_soon_and_for_good():
    used = play(Tried(), {0.0: 1.0, 1.0: 5.0, -1.0: 0.2}, consistency=9.0)
    assert (used[100:] == 1.0).mean() > 0.9
    assert (used[100:] != -1.0).all()


def test_an_adversary_is_believed_the_other_way_round():
    used = play(Tried(), {0.0: 1.0, 1.0: 0.2, -1.0: 5.0}, consistency=9.0)
    assert (used[100:] == -1.0).mean() > 0.9


def test_nothing_is_tried_while_presses_cannot_be_told_from_random_ones():
    assert (play(Tried(), {0.0: 1.0, 1.0: 9.0, -1.0: 9.0}, consistency=2.0) == 0.0).all()


def test_a_consistent_participant_who_only_harms_costs_the_trials_and_no_more():
    used = play(Tried(trial_share=0.2), {0.0: 5.0, 1.0: 0.5, -1.0: 0.5}, consistency=9.0, episodes=1000)
    # standard error sqrt(0.2 * 0.8 / 1000) = 0.013; allow 4 of them
    assert (used != 0.0).mean() == pytest.approx(0.2, abs=0.052)
    assert abs(used.mean()) < 0.06


def test_belief_ends_when_the_environment_turns():
    bootstrap = learning(Tried())
    rng = stream(6, "performance")
    used = []
    for episode in range(900):
        used.append(bootstrap.w_h)
        best = 1.0 if episode < 300 else 0.0
        performance = float(rng.exponential(6.0 if bootstrap.w_h == best else 1.0))
        bootstrap.record(EpisodeReport(episode, np.zeros(2), performance, False, Agreement(10, 5, 0), 9.0), V)
    assert (np.array(used[150:300]) == 1.0).mean() > 0.85
    assert (np.array(used[700:]) == 1.0).mean() < 0.3


def test_control_episodes_go_on_while_a_participant_is_believed():
    used = play(Tried(control_share=0.25), {0.0: 1.0, 1.0: 5.0, -1.0: 0.2}, consistency=9.0, episodes=800)[
        200:
    ]
    # standard error sqrt(0.25 * 0.75 / 600) = 0.018; allow 4 of them
    assert (used == 0.0).mean() == pytest.approx(0.25, abs=0.07)


def test_episodes_without_a_human_policy_change_nothing():
    bootstrap = learning(Tried(minimum_episodes=2))
    for episode in range(50):
        bootstrap.record(EpisodeReport(episode, np.zeros(2), 3.0, False, None, 9.0), None)
    assert bootstrap.w_h == 0.0
    bootstrap.record(EpisodeReport(50, np.zeros(2), 3.0, False, Agreement(10, 5, 0), 9.0), V)
    other = learning(Tried(minimum_episodes=2))
    other.record(EpisodeReport(50, np.zeros(2), 3.0, False, Agreement(10, 5, 0), 9.0), V)
    assert bootstrap.w_h == other.w_h


def test_the_rank_test_is_scipy_s():
    rng = stream(1, "performances")
    for n, m in ((5, 40), (8, 8), (30, 3)):
        first, second = rng.integers(0, 6, size=n) + 1.0, rng.integers(0, 6, size=m) + 0.0
        z = rank_test(first.tolist(), second.tolist())
        theirs = stats.mannwhitneyu(first, second, use_continuity=False, method="asymptotic")
        assert 2 * stats.norm.sf(abs(z)) == pytest.approx(theirs.pvalue)
        assert np.sign(z) == np.sign(theirs.statistic - n * m / 2)
        assert rank_test(second.tolist(), first.tolist()) == pytest.approx(-z)
    assert rank_test([2.0, 2.0], [2.0]) == 0.0


@pytest.mark.parametrize("signed", [True, False])
def test_the_rank_correlation_is_spearman_s_less_its_standard_errors(signed):
    rng = stream(2, "pairs")
    for sign in (1.0, -1.0):
        performance = rng.integers(0, 9, size=60).astype(float)
        match = sign * performance + rng.normal(0, 3, size=60)
        r = stats.spearmanr(performance, match).statistic
        kept = max(0.0, abs(r) - 2 / np.sqrt(59))
        expected = 1.5 * np.sign(r) * kept if signed or r > 0 else 0.0
        found = rank_human_weight(
            performance.tolist(), match.tolist(), gain=1.5, standard_errors=2.0, signed=signed
        )
        assert found == pytest.approx(expected)


def test_policies_that_agree_and_do_better_earn_trust_by_rank_correlation():
    bootstrap = learning(RankCorrelation())
    for episode in range(40):
        agreed = episode % 10
        bootstrap.record(
            EpisodeReport(episode, np.zeros(2), float(agreed), False, Agreement(10, agreed, 0)), V
        )
    # r = 1 less 1 / sqrt(39), times 1.5
    assert bootstrap.w_h == pytest.approx(1.5 * (1 - 1 / np.sqrt(39)))


def test_equal_performances_say_nothing():
    assert (
        rank_human_weight([1.0] * 5, [0.1, 0.2, 0.3, 0.4, 0.5], gain=1, standard_errors=0, signed=True) == 0.0
    )


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"trial_share": 1.5}, "shares"),
        ({"weight": 0.0}, "weight > 0"),
        ({"minimum_episodes": 1}, "minimum_episodes"),
    ],
)
def test_impossible_settings_are_refused(changes, reason):
    with pytest.raises(ValueError, match=reason):
        Tried(**changes)
