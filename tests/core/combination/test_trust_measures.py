"""Eqs. 4 and 5, degree of match, signed weight and selection: by hand, and what must always hold."""

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from core.combination.agreement import Agreement, degree_of_match
from core.combination.trust.measures import (
    human_weight,
    next_human_weight,
    pulls,
    rank_human_weight,
    rank_test,
    selection_probabilities,
    signed_human_weight,
)
from core.numerics.streams import stream

PERFORMANCE = st.floats(0, 1e5)
MATCH = st.floats(0, 1)


def test_degree_of_match_by_hand() -> None:
    # 8 of 20 best, 3 of 20 worst
    counts = Agreement(20, 8, 3)
    assert degree_of_match(counts, "rate") == 0.4
    assert degree_of_match(counts, "signed") == 0.25
    # above chance: (0.4 - 0.2) / (1 - 0.2)
    assert degree_of_match(counts, "chance-corrected", 0.2) == pytest.approx(0.25)
    # below chance there is no match at all
    assert degree_of_match(counts, "chance-corrected", 0.5) == 0.0


def test_human_weight_by_hand() -> None:
    # Eq. 4: (10 * 1.0 + 30 * 0.5) / (10 + 30) = 25/40
    assert human_weight([10.0, 30.0], [1.0, 0.5]) == 0.625


def test_human_weight_is_the_plain_mean_until_some_policy_performs() -> None:
    # 0/0 in Eq. 4: (1.0 + 0.5) / 2
    assert human_weight([0.0, 0.0], [1.0, 0.5]) == 0.75
    assert human_weight([0.0, 1e-9], [1.0, 0.5]) == 0.5


def test_without_any_comparison_the_human_has_no_weight() -> None:
    assert human_weight([], []) == 0.0


def test_human_weight_is_one_if_all_policies_agree_with_the_human() -> None:
    assert human_weight([3.0, 0.1, 7.7], [1.0, 1.0, 1.0]) == 1.0


def test_equation_5_by_hand() -> None:
    # (20 * 0.5 + 60 * 0.9) / 80 = 64/80
    assert next_human_weight(20.0, 0.5, 60.0, 0.9) == pytest.approx(0.8)
    # an episode without performance changes nothing, one after such an episode decides alone
    assert next_human_weight(20.0, 0.5, 0.0, 0.9) == 0.5
    assert next_human_weight(0.0, 0.5, 60.0, 0.9) == 0.9
    # 0/0: the plain mean
    assert next_human_weight(0.0, 0.5, 0.0, 0.9) == pytest.approx(0.7)


def test_signed_weight_by_hand() -> None:
    # w = (1 * 0.2 + 3 * 0.6) / 4 = 0.5; sd of 0.2, 0.6 (n - 1) = 0.28284; sqrt(1 + 9) / 4 = 0.79057
    # se = 0.22361; gain 2, one standard error: 2 (0.5 - 0.22361) = 0.55279
    value = signed_human_weight([1.0, 3.0], [0.2, 0.6], gain=2.0, standard_errors=1.0)
    assert value == pytest.approx(0.55279, abs=1e-5)
    # the adversary's mirror image
    assert signed_human_weight([1.0, 3.0], [-0.2, -0.6], gain=2.0, standard_errors=1.0) == -value
    # three standard errors are more than the agreement itself
    assert signed_human_weight([1.0, 3.0], [0.2, 0.6], gain=2.0, standard_errors=3.0) == 0.0
    # a margin of 0.2 beside them: 2 (0.5 - 0.22361 - 0.2), and nothing where it is more than what is left
    margined = signed_human_weight([1.0, 3.0], [0.2, 0.6], gain=2.0, standard_errors=1.0, margin=0.2)
    assert margined == pytest.approx(0.15279, abs=1e-5)
    assert signed_human_weight([1.0, 3.0], [-0.2, -0.6], gain=2.0, standard_errors=1.0, margin=0.3) == 0.0
    # without performance episodes count alike: w = 0.4, se = 0.28284 / sqrt 2 = 0.2
    assert signed_human_weight([0, 0], [0.2, 0.6], gain=1.0, standard_errors=1.0) == pytest.approx(0.2)


def test_selection_is_proportional_to_performance_where_the_human_is_not_trusted() -> None:
    assert selection_probabilities([10, 30], pulls([1.0, 0.0], 0.0)) == [0.25, 0.75]


def test_selection_rises_with_the_match_to_a_trusted_human() -> None:
    # 10 (1 + 0.5 * 1) = 15, 30 (1 + 0.5 * 0) = 30
    assert selection_probabilities([10, 30], pulls([1.0, 0.0], 0.5)) == pytest.approx([1 / 3, 2 / 3])
    # an adversary, w_h = -0.5, opposed by the first policy: the same
    assert selection_probabilities([10, 30], pulls([-1.0, 0.0], -0.5)) == pytest.approx([1 / 3, 2 / 3])


def test_a_policy_never_compared_counts_as_the_others_on_average() -> None:
    # mean of 0.2 and 0.6 is 0.4: factors 1.2, 1.4, 1.6
    assert selection_probabilities([1, 1, 1], pulls([0.2, None, 0.6], 1.0)) == pytest.approx(
        [1.2 / 4.2, 1.4 / 4.2, 1.6 / 4.2]
    )
    assert selection_probabilities([1, 3], pulls([None, None], 1.0)) == [0.25, 0.75]


def test_selection_is_defined_without_performance_and_against_full_distrust() -> None:
    assert selection_probabilities([0, 0], pulls([None, None], 0.0)) == [0.5, 0.5]
    # 0 (1 + 1 * 1) and 0 (1 + 1 * 0), policies alike: 2/3, 1/3
    assert selection_probabilities([0, 0], pulls([1.0, 0.0], 1.0)) == pytest.approx([2 / 3, 1 / 3])
    # both factors are max(0, 1 - 2 * 1) = 0: performance decides
    assert selection_probabilities([1, 3], pulls([1.0, 1.0], -2.0)) == [0.25, 0.75]


@given(st.lists(st.tuples(PERFORMANCE, MATCH), min_size=1, max_size=12))
def test_human_weight_lies_within_the_matches(policies: list[tuple[float, float]]) -> None:
    performance, match = [pm for pm, _ in policies], [m for _, m in policies]
    assert min(match) - 1e-12 <= human_weight(performance, match) <= max(match) + 1e-12


@given(st.lists(st.tuples(PERFORMANCE, MATCH), min_size=1, max_size=12), st.randoms(use_true_random=False))
def test_human_weight_does_not_depend_on_the_order_of_policies(
    policies: list[tuple[float, float]], rng
) -> None:  # type: ignore[no-untyped-def]
    other = list(policies)
    rng.shuffle(other)
    assert human_weight(*map(list, zip(*policies, strict=True))) == human_weight(
        *map(list, zip(*other, strict=True))
    )


@given(PERFORMANCE, MATCH, PERFORMANCE, MATCH)
@example(5e-324, 0.5, 0.0, 1.0)  # a product that rounds to 0
def test_equation_5_moves_towards_the_episodes_match(
    pm_before: float, w_before: float, pm: float, m: float
) -> None:
    after = next_human_weight(pm_before, w_before, pm, m)
    assert min(w_before, m) - 1e-12 <= after <= max(w_before, m) + 1e-12


@given(
    st.lists(st.tuples(PERFORMANCE, st.none() | st.floats(-1, 1)), min_size=1, max_size=12), st.floats(-2, 2)
)
def test_selection_probabilities_are_probabilities(
    policies: list[tuple[float, float | None]], w_h: float
) -> None:
    probabilities = selection_probabilities([pm for pm, _ in policies], pulls([m for _, m in policies], w_h))
    assert math.fsum(probabilities) == pytest.approx(1.0)
    assert min(probabilities) >= 0


@pytest.mark.statistical
def test_a_useless_participant_is_hardly_ever_trusted_by_the_signed_rule() -> None:
    rng = stream(1, "useless")
    trusted = 0
    for _ in range(400):
        performance = rng.exponential(100, size=200).tolist()
        agreement = rng.choice([-0.1, 0.0, 0.1], size=200).tolist()
        trusted += signed_human_weight(performance, agreement, gain=2.0, standard_errors=2.0) != 0
    # Beyond 2 standard errors lie 4.6 %; 400 draws have a standard error of 1.05 %, and heavy-tailed weights
    # shift the rate a little: allow 4.6 % + 4 * 1.05 %.
    assert trusted / 400 < 0.088


def test_what_cannot_be_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="one match per performance"):
        human_weight([1.0], [])
    with pytest.raises(ValueError, match="performance is finite"):
        human_weight([float("-inf")], [0.5])
    with pytest.raises(ValueError, match="at least 2 episodes"):
        signed_human_weight([1.0], [0.5], gain=1.0, standard_errors=1.0)
    with pytest.raises(ValueError, match="no policy"):
        selection_probabilities([], pulls([], 0.0))
    with pytest.raises(ValueError, match="counts >= 0"):
        Agreement(0, 0, 0)
    with pytest.raises(ValueError, match="more agreements"):
        Agreement(3, 4, 0)


def test_negative_performances_count_by_how_far_they_lie_above_the_lowest() -> None:
    # -100 counts 0, -40 counts 60, -80 counts 20: (60 * 0.9 + 20 * 0.1) / 80.
    assert human_weight([-100.0, -40.0, -80.0], [0.5, 0.9, 0.1]) == pytest.approx(0.7)
    assert human_weight([-7.0, -7.0], [0.2, 0.6]) == pytest.approx(0.4)
    assert selection_probabilities([-100.0, -40.0, -80.0], [0.0] * 3) == [0.0, 0.75, 0.25]
    assert selection_probabilities([-5.0, -5.0], [0.0, 1.0]) == [pytest.approx(1 / 3), pytest.approx(2 / 3)]


@given(
    st.lists(
        st.tuples(st.integers(-1000, -1), st.sampled_from([-1.0, -0.5, 0.25, 1.0])), min_size=3, max_size=9
    )
)
def test_rules_do_not_care_where_the_zero_of_negative_performances_lies(pairs) -> None:
    # All of them lower by 500 points: the differences are what they were, in whole numbers.
    match = [m for _, m in pairs]
    here, there = [float(pm) for pm, _ in pairs], [float(pm - 500) for pm, _ in pairs]
    assert human_weight(here, match) == human_weight(there, match)
    assert selection_probabilities(here, match) == selection_probabilities(there, match)
    fixed = {"gain": 2.0, "standard_errors": 1.0}
    assert signed_human_weight(here, match, **fixed) == signed_human_weight(there, match, **fixed)
    for signed in (True, False):
        assert rank_human_weight(here, match, **fixed, signed=signed) == rank_human_weight(
            there, match, **fixed, signed=signed
        )
    assert rank_test(here[:1], here[1:]) == rank_test(there[:1], there[1:])


def test_of_negative_performances_the_better_episodes_decide_about_a_signed_weight() -> None:
    # Praised episodes took 100 steps, blamed ones 200: the participant is right.
    performance, agreement = [-100.0, -200.0] * 20, [0.5, -0.5] * 20
    w = signed_human_weight(performance, agreement, gain=1.0, standard_errors=0.0)
    # Those of -200 are the lowest and count nothing.
    assert w == pytest.approx(0.5)


def test_of_gains_and_costs_each_counts_by_how_far_it_lies_above_the_lowest() -> None:
    # -10 counts 0, 30 counts 40, 0 counts 10: (40 * 0.9 + 10 * 0.4) / 50.
    assert human_weight([-10.0, 30.0, 0.0], [0.1, 0.9, 0.4]) == pytest.approx(0.8)
    assert selection_probabilities([-10.0, 30.0, 0.0], [0.0] * 3) == pytest.approx([0.0, 0.8, 0.2])
    # w_h m = 1 doubles the last one: 40 to 20.
    assert selection_probabilities([-10.0, 30.0, 0.0], [1.0, 0.0, 1.0]) == pytest.approx([0.0, 2 / 3, 1 / 3])
    # A single policy is the lowest and the highest: its match counts in full.
    assert human_weight([-5.0], [0.3]) == pytest.approx(0.3)


def test_ranks_of_negative_performances_by_hand() -> None:
    # The better the episode the higher the match: r = 1, less 1 / sqrt(4 - 1).
    w = rank_human_weight(
        [-200.0, -150.0, -120.0, -110.0], [0.1, 0.2, 0.5, 0.9], gain=2.0, standard_errors=1.0, signed=False
    )
    assert w == pytest.approx(2.0 * (1.0 - 1.0 / math.sqrt(3.0)))
    # One better episode among three: rank 4 of 4, mean 2.5, variance 1 * 3 * 5 / 12.
    assert rank_test([-100.0], [-300.0, -200.0, -150.0]) == pytest.approx(1.5 / math.sqrt(15.0 / 12.0))


def test_equation_5_takes_the_plain_mean_where_a_performance_is_negative() -> None:
    assert next_human_weight(-200.0, 0.2, -199.0, 0.6) == pytest.approx(0.4)
    # Of a gain and a cost, either way round, and of the first comparison, before which performance is 0.
    assert next_human_weight(10.0, 0.2, -5.0, 0.6) == pytest.approx(0.4)
    assert next_human_weight(-5.0, 0.2, 10.0, 0.6) == pytest.approx(0.4)
    assert next_human_weight(0.0, 0.0, -200.0, 0.8) == pytest.approx(0.4)


@given(st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1, 1)), min_size=2, max_size=9))
def test_a_weight_stays_in_the_range_of_the_matches_whatever_the_performances(pairs) -> None:
    performance, match = [pm for pm, _ in pairs], [m for _, m in pairs]
    # A mean of equal numbers may lie one rounding beside them.
    assert min(match) - 1e-12 <= human_weight(performance, match) <= max(match) + 1e-12
    probabilities = selection_probabilities(performance, match)
    assert min(probabilities) >= 0
    assert sum(probabilities) == pytest.approx(1.0)
