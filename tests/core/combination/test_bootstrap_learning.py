"""The top policies, w_h under every trust rule, and the window of recent decisions."""

import math
from collections.abc import Callable

import msgspec
import numpy as np
import pytest

from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import (
    BootstrapConfig,
    Equation4,
    Equation5,
    FixedWeight,
    RankCorrelation,
    Signed,
    Tried,
    TrustRule,
)
from core.combination.ranking import EpisodeReport, draw_policy
from core.combination.trust.measures import selection_probabilities
from core.combination.window import DecisionWindow, exact_values
from core.domain import Choices
from core.numerics.streams import stream

HUMAN = np.array([1.0, 0.0])


def empty_window(capacity: int = 50) -> DecisionWindow:
    return DecisionWindow(capacity, exact_values, exact_values)


def learning(
    trust: TrustRule | None = None,
    *,
    window: DecisionWindow | None = None,
    top: int = 10,
    symmetric: bool = True,
) -> BootstrapLearning:
    config = BootstrapConfig(trust=trust or Equation4(), top_policies=top, symmetric=symmetric)
    return BootstrapLearning(config, window or empty_window(), root_seed=1)


def report(
    policy_id: int,
    performance: float,
    agreed: int | None = None,
    *,
    worst: int = 0,
    truncated: bool = False,
    theta: tuple[float, float] = (1.0, 0.0),
) -> EpisodeReport:
    """An episode of 10 decisions."""
    agreement = None if agreed is None else Agreement(10, agreed, worst)
    return EpisodeReport(policy_id, np.array(theta), performance, truncated, agreement)


def probabilities(bootstrap: BootstrapLearning) -> list[float]:
    """Of each ranked policy being played, with one participant."""
    return selection_probabilities([p.performance for p in bootstrap.ranked], bootstrap.pulls(HUMAN))


def choices(*rows: tuple[float, float]) -> Choices:
    """A decision in which both learners see the same two features."""
    features = np.array(rows)
    return Choices(features, features, np.zeros(len(rows), dtype=np.bool_))


def test_the_best_policies_are_kept_and_of_equal_ones_the_older() -> None:
    bootstrap = learning(top=3)
    for policy_id, performance in enumerate([5.0, 9.0, 5.0, 1.0, 7.0]):
        bootstrap.record(report(policy_id, performance), None)
    assert [(p.policy_id, p.performance) for p in bootstrap.ranked] == [(1, 9.0), (4, 7.0), (0, 5.0)]


def test_performance_of_a_policy_is_per_episode_that_came_to_its_end() -> None:
    bootstrap = learning()
    bootstrap.record(report(0, 100.0), None)
    bootstrap.record(report(1, 90.0), None)
    # (100 + 40) / 2 = 70: the policy falls behind
    bootstrap.record(report(0, 40.0), None)
    assert [(p.policy_id, p.performance) for p in bootstrap.ranked] == [(1, 90.0), (0, 70.0)]
    # 20 lines before the episode was stopped, and the policy had not died: (100 + 40 + 20) / 2
    bootstrap.record(report(0, 20.0, truncated=True), None)
    assert bootstrap.ranked[1].performance == 80.0
    # never died at all: at least what it did
    bootstrap.record(report(2, 30.0, truncated=True), None)
    assert bootstrap.ranked[2].performance == 30.0


def test_equation_4_over_the_top_policies_by_hand() -> None:
    bootstrap = learning()
    bootstrap.record(report(0, 10.0, agreed=10), HUMAN)
    assert bootstrap.w_h == 1.0
    bootstrap.record(report(1, 30.0, agreed=5), HUMAN)
    # Eq. 4: (10 * 1.0 + 30 * 0.5) / 40
    assert bootstrap.w_h == 0.625


def test_policies_never_compared_with_the_human_have_no_vote() -> None:
    bootstrap = learning()
    bootstrap.record(report(0, 1000.0), None)
    assert bootstrap.w_h == 0.0
    bootstrap.record(report(1, 10.0, agreed=4), HUMAN)
    assert bootstrap.w_h == 0.4


def test_a_policy_that_falls_out_of_the_top_has_no_vote_any_more() -> None:
    bootstrap = learning(top=1)
    bootstrap.record(report(0, 10.0, agreed=10), HUMAN)
    bootstrap.record(report(1, 30.0, agreed=5), HUMAN)
    assert bootstrap.w_h == 0.5


def test_playing_a_policy_again_refreshes_its_match() -> None:
    bootstrap = learning()
    bootstrap.record(report(0, 10.0, agreed=10), HUMAN)
    bootstrap.record(report(0, 10.0, agreed=2), HUMAN)
    assert bootstrap.w_h == 0.2
    # not compared this time: the last comparison stands
    bootstrap.record(report(0, 10.0), HUMAN)
    assert bootstrap.w_h == 0.2


def test_signed_match_in_equation_4_distrusts_an_adversary() -> None:
    bootstrap = learning(Equation4(match="signed"))
    bootstrap.record(report(0, 10.0, agreed=1, worst=6), HUMAN)
    assert bootstrap.w_h == -0.5


def test_chance_correction_by_a_given_level() -> None:
    bootstrap = learning(Equation4(match="chance-corrected", chance=0.2))
    bootstrap.record(report(0, 10.0, agreed=4), HUMAN)
    # above chance: (0.4 - 0.2) / 0.8
    assert bootstrap.w_h == pytest.approx(0.25)


def test_match_over_the_window_is_measured_with_the_human_policy_of_now() -> None:
    window = empty_window()
    # The participant likes the first feature. theta = (1, 0) agrees in both decisions, (0, 1) in the second
    # only.
    window.remember(choices((1, 0), (0, 1)))
    window.remember(choices((1, 1), (0, 0), (0.5, 0.5)))
    bootstrap = learning(Equation4(measured="window"), window=window)
    bootstrap.record(report(0, 10.0, theta=(1.0, 0.0)), HUMAN)
    assert bootstrap.w_h == 1.0
    bootstrap.record(report(1, 30.0, theta=(0.0, 1.0)), HUMAN)
    # Eq. 4: (10 * 1 + 30 * 0.5) / 40
    assert bootstrap.w_h == 0.625
    # The participant changed their mind: matches are 1 for theta = (0, 1) and 0.5 for (1, 0).
    bootstrap.record(report(2, 0.0, theta=(0.0, 1.0)), HUMAN[::-1].copy())
    assert bootstrap.w_h == pytest.approx((10 * 0.5 + 30 * 1.0) / 40)


def test_an_empty_window_is_no_evidence() -> None:
    for rule in (Equation4(measured="window"), Equation4(match="chance-corrected")):
        bootstrap = learning(rule)
        bootstrap.record(report(0, 10.0, agreed=10), HUMAN)
        assert bootstrap.w_h == 0.0


def test_window_counts_best_and_worst_choices() -> None:
    window = empty_window(capacity=2)
    window.remember(choices((9, 9), (0, 0)))  # falls out of the window
    window.remember(choices((1, 0), (0, 1)))
    window.remember(choices((0, 1), (1, 1), (2, 2)))
    assert len(window) == 2
    # theta = (0, 1): action 1 (human's worst of 1, 0), then action 2 (human's best of 0, 1, 2)
    assert window.compare(np.array([0.0, 1.0]), HUMAN) == Agreement(2, 1, 1)
    window.remember(choices((0, 0), (5, 5)))  # pushes out the decision that went against the participant
    assert window.compare(np.array([0.0, 1.0]), HUMAN) == Agreement(2, 2, 0)


def test_ruled_out_actions_are_nobodys_choice_in_the_window() -> None:
    window = empty_window()
    features = np.array([[3.0, 0.0], [2.0, 5.0], [1.0, 9.0]])
    window.remember(Choices(features, features, np.array([True, False, True])))
    assert window.compare(np.array([0.0, 1.0]), HUMAN) == Agreement(1, 1, 1)


@pytest.mark.statistical
def test_chance_agreement_of_random_policies_is_one_half_among_two_actions() -> None:
    rng = stream(5, "decisions")
    window = empty_window(capacity=400)
    for _ in range(400):
        window.remember(choices(*map(tuple, rng.normal(size=(2, 2)))))
    # Each of the 20 random policies agrees with the participant in (1 - angle/pi) of the decisions, angle
    # uniform on [0, pi]: mean 1/2, sd 1/sqrt(12). The mean of 20 has standard error 0.065.
    assert window.chance(HUMAN, rng=stream(6, "chance")) == pytest.approx(0.5, abs=4 * 0.065)


def test_estimated_chance_does_not_move_by_looking_at_it() -> None:
    window = empty_window()
    rng = stream(5, "decisions")
    for _ in range(30):
        window.remember(choices(*map(tuple, rng.normal(size=(4, 2)))))
    bootstrap = learning(Equation4(match="chance-corrected"), window=window)
    bootstrap.record(report(0, 10.0, agreed=10), HUMAN)
    before = bootstrap.state_bytes()
    assert bootstrap.matches(HUMAN) == bootstrap.matches(HUMAN)
    assert 0 < bootstrap.w_h <= 1.0
    assert bootstrap.state_bytes() == before


def test_equation_5_follows_the_two_latest_episodes() -> None:
    bootstrap = learning(Equation5())
    bootstrap.record(report(0, 20.0), None)
    # Before any comparison w_h^0 = 0, as for an agent that assumes no human: (20 * 0 + 20 * 0.8) / 40 = 0.4
    bootstrap.record(report(1, 20.0, agreed=8), HUMAN)
    assert bootstrap.w_h == pytest.approx(0.4)
    # (20 * 0.4 + 60 * 0.2) / 80 = 0.25
    bootstrap.record(report(2, 60.0, agreed=2), HUMAN)
    assert bootstrap.w_h == pytest.approx(0.25)


def test_cumulative_equation_5_is_equation_4_over_all_compared_episodes() -> None:
    bootstrap = learning(Equation5(cumulative=True))
    bootstrap.record(report(0, 500.0), None)
    for policy_id, (performance, agreed) in enumerate([(20.0, 8), (60.0, 2), (20.0, 10)]):
        bootstrap.record(report(policy_id + 1, performance, agreed), HUMAN)
    # Eq. 4: (20 * 0.8 + 60 * 0.2 + 20 * 1.0) / 100
    assert bootstrap.w_h == pytest.approx(0.48)


def test_signed_rule_waits_for_enough_episodes() -> None:
    bootstrap = learning(Signed(minimum_episodes=3))
    for policy_id in range(2):
        bootstrap.record(report(policy_id, 10.0, agreed=6, worst=1), HUMAN)
        assert bootstrap.w_h == 0.0
    bootstrap.record(report(2, 10.0, agreed=6, worst=1), HUMAN)
    # always 0.5, so no standard error: 2 * 0.5
    assert bootstrap.w_h == pytest.approx(1.0)


def test_signed_rule_forgets_old_episodes() -> None:
    bootstrap = learning(Signed(episodes=3, minimum_episodes=2))
    for _ in range(3):
        bootstrap.record(report(0, 10.0, agreed=0, worst=5), HUMAN)
    assert bootstrap.w_h == pytest.approx(-1.0)
    for _ in range(3):
        bootstrap.record(report(0, 10.0, agreed=5), HUMAN)
    assert bootstrap.w_h == pytest.approx(1.0)


def test_a_fixed_weight_takes_no_evidence() -> None:
    bootstrap = learning(FixedWeight(0.7))
    bootstrap.record(report(0, 10.0, agreed=0, worst=10), HUMAN)
    assert bootstrap.w_h == 0.7


def test_selection_uses_performance_and_match() -> None:
    bootstrap = learning(FixedWeight(0.5))
    bootstrap.record(report(0, 30.0, agreed=0), HUMAN)
    bootstrap.record(report(1, 10.0, agreed=10), HUMAN)
    # 30 * 1, 10 * 1.5
    assert probabilities(bootstrap) == pytest.approx([2 / 3, 1 / 3])
    asymmetric = learning(FixedWeight(0.5), symmetric=False)
    asymmetric.record(report(0, 30.0, agreed=0), HUMAN)
    asymmetric.record(report(1, 10.0, agreed=10), HUMAN)
    assert probabilities(asymmetric) == [0.75, 0.25]


@pytest.mark.statistical
def test_policies_are_drawn_with_their_probabilities() -> None:
    bootstrap = learning()
    for policy_id, performance in enumerate([60.0, 30.0, 10.0, 0.0]):
        bootstrap.record(report(policy_id, performance), None)
    n = 4000
    chances = probabilities(bootstrap)
    drawn = [draw_policy(bootstrap.ranked, chances, rng=stream(2, "policy", k)).policy_id for k in range(n)]
    # standard error at most sqrt(0.25/4000) = 0.008; allow 4 of them
    assert [drawn.count(policy_id) / n for policy_id in range(4)] == pytest.approx(
        [0.6, 0.3, 0.1, 0], abs=0.032
    )
    assert drawn.count(3) == 0


def test_the_fingerprint_tells_every_difference() -> None:
    reports = [
        report(0, 10.0, agreed=4),
        report(1, 10.0, agreed=4),
        report(0, 11.0, agreed=4),
        report(0, 10.0, agreed=5),
        report(0, 10.0, agreed=4, worst=1),
        report(0, 10.0, agreed=4, truncated=True),
        report(0, 10.0),
        report(0, 10.0, agreed=4, theta=(1.0, 1e-9)),
    ]
    fingerprints = set()
    for one in reports:
        bootstrap = learning()
        bootstrap.record(one, HUMAN)
        fingerprints.add(bootstrap.state_bytes())
    assert len(fingerprints) == len(reports)


@pytest.mark.parametrize(
    "rule",
    [
        Equation4(match="signed", measured="window"),
        Equation5(cumulative=True),
        Signed(gain=1.5),
        FixedWeight(0.3),
    ],
)
def test_trust_rules_survive_a_recordings_header(rule: TrustRule) -> None:
    config = BootstrapConfig(trust=rule)
    assert msgspec.json.decode(msgspec.json.encode(config), type=BootstrapConfig) == config


@pytest.mark.parametrize(("rule", "least"), [(Signed, 2), (RankCorrelation, 3), (Tried, 2)])
def test_a_rule_wants_enough_episodes_and_no_more_than_it_keeps(
    rule: Callable[..., TrustRule], least: int
) -> None:
    rule(minimum_episodes=least, episodes=least)
    reason = f"need {least} <= minimum_episodes <= episodes, got "
    with pytest.raises(ValueError, match=f"{reason}{least - 1} and 200"):
        rule(minimum_episodes=least - 1)
    with pytest.raises(ValueError, match=f"{reason}{least + 1} and {least}"):
        rule(minimum_episodes=least + 1, episodes=least)


@pytest.mark.parametrize("rule", [Signed, RankCorrelation])
@pytest.mark.parametrize(
    "changes",
    [
        {"gain": 0.0},
        {"gain": math.inf},
        {"gain": math.nan},
        {"standard_errors": -1.0},
        {"standard_errors": math.nan},
    ],
    ids=str,
)
def test_a_gain_brings_a_weight_nearer_and_errors_count_against_it(
    rule: Callable[..., TrustRule], changes: dict[str, float]
) -> None:
    with pytest.raises(ValueError, match="need gain > 0 and standard_errors >= 0: "):
        rule(**changes)


def test_what_cannot_be_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="chance"):
        Equation4(chance=1.0)
    with pytest.raises(ValueError, match="w_h is finite"):
        FixedWeight(float("inf"))
    with pytest.raises(ValueError, match="top_policies"):
        BootstrapConfig(top_policies=0)
    with pytest.raises(ValueError, match="performance is finite"):
        learning().record(report(0, float("nan")), None)
    with pytest.raises(ValueError, match="no decision"):
        empty_window().compare(HUMAN, HUMAN)


def test_a_rule_of_trust_that_nobody_has_written_is_not_taken_for_one_that_says_nothing() -> None:
    with pytest.raises((AssertionError, AttributeError)):
        learning(trust=object()).record(report(0, 1.0), None)  # type: ignore[arg-type]
