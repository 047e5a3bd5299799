"""Tests, effect sizes and corrections, held against scipy and closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from core.numerics.streams import stream
from studies.comparison import (
    holm,
    paired_effect_size,
    probability_interval,
    probability_of_improvement,
    sign_flip_p,
)
from studies.statistics import Interval


def test_the_probability_of_improvement_is_mann_whitney_s_u_over_the_pairs():
    first, second = stream(1, "a").integers(0, 9, size=23), stream(1, "b").integers(2, 9, size=17)
    u = stats.mannwhitneyu(first, second).statistic
    assert probability_of_improvement(first, second) == pytest.approx(u / (23 * 17))


@given(
    st.lists(st.integers(-5, 5), min_size=1, max_size=8), st.lists(st.integers(-5, 5), min_size=1, max_size=8)
)
def test_what_one_side_wins_the_other_loses(first, second):
    assert probability_of_improvement(first, second) + probability_of_improvement(
        second, first
    ) == pytest.approx(1)


def test_equal_conditions_improve_with_probability_one_half_and_disjoint_ones_with_certainty():
    assert probability_of_improvement([3.0, 3.0], [3.0]) == 0.5
    assert probability_of_improvement([4.0, 5.0], [1.0, 2.0]) == 1.0
    interval = probability_interval([4.0, 5.0], [1.0, 2.0], rng=stream(1, "b"))
    assert interval == Interval(1.0, 1.0, 1.0)


def test_the_interval_of_the_probability_follows_its_stream():
    first, second = stream(1, "a").normal(1, 1, size=20), stream(1, "b").normal(0, 1, size=20)
    assert probability_interval(first, second, rng=stream(2, "b")) == probability_interval(
        first, second, rng=stream(2, "b")
    )
    found = probability_interval(first, second, rng=stream(2, "b"))
    assert found.low < found.estimate < found.high
    assert found != probability_interval(first, second, rng=stream(3, "b"))


def test_sign_flips_give_the_exact_p_value_of_a_few_pairs():
    # All four differences have one sign: 2 of 16 patterns are as extreme.
    p = sign_flip_p([1.0, 2.0, 3.0, 4.0], rng=stream(1, "flips"), flips=100_000)
    # standard error sqrt(0.125 * 0.875 / 100000) = 0.001; allow 4 of them
    assert p == pytest.approx(2 / 16, abs=0.0042)


def test_sign_flips_agree_with_scipy_s_permutation_test():
    differences = stream(4, "differences").normal(0.4, 1.0, size=12)
    theirs = stats.permutation_test(
        (differences, np.zeros(12)),
        lambda x, y: np.mean(x - y),
        permutation_type="samples",
        n_resamples=np.inf,
    )
    # standard error at p ~ 0.1 with 50,000 flips: 0.0013; allow 4 of them
    assert sign_flip_p(differences, rng=stream(1, "flips"), flips=50_000) == pytest.approx(
        theirs.pvalue, abs=0.0055
    )


def test_no_difference_at_all_is_no_evidence():
    assert sign_flip_p(np.zeros(5), rng=stream(1, "flips"), flips=100) == 1.0


@pytest.mark.statistical
def test_sign_flips_raise_a_false_alarm_as_often_as_they_say():
    alarms = sum(
        sign_flip_p(stream(7, "null", k).standard_t(3, size=20), rng=stream(7, "flips", k), flips=400) < 0.05
        for k in range(400)
    )
    # standard error sqrt(0.05 * 0.95 / 400) = 0.011; allow 4 of them
    assert alarms / 400 == pytest.approx(0.05, abs=0.044)


def test_holm_s_correction_by_hand():
    # Sorted: 0.01 * 3, 0.02 * 2, 0.04 * 1; never falling.
    assert holm([0.04, 0.01, 0.02]).tolist() == pytest.approx([0.04, 0.03, 0.04])
    assert holm([0.5, 0.9]).tolist() == pytest.approx([1.0, 1.0])
    assert holm([]).tolist() == []


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_lies_between_no_correction_and_bonferroni_and_keeps_the_order(p_values):
    p, adjusted = np.array(p_values), holm(p_values)
    assert (adjusted >= p).all()
    assert (adjusted <= np.minimum(p * len(p), 1.0) + 1e-12).all()
    assert (np.diff(adjusted[np.argsort(p, kind="stable")]) >= 0).all()


def test_the_paired_effect_size_is_the_t_statistic_over_the_root_of_n():
    differences = stream(2, "differences").normal(1.0, 2.0, size=15)
    t = stats.ttest_1samp(differences, 0.0).statistic
    assert paired_effect_size(differences) == pytest.approx(t / np.sqrt(15))
    assert paired_effect_size([1.0, 1.0]) == np.inf
    assert paired_effect_size([0.0, 0.0]) == 0.0


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda: probability_of_improvement([], [1.0]), "two rows"),
        (lambda: sign_flip_p([np.nan], rng=stream(1, "x")), "finite"),
        (lambda: holm([1.5]), "in \\[0, 1\\]"),
        (lambda: paired_effect_size([1.0]), "at least 2"),
    ],
)
def test_what_cannot_be_compared_is_refused(call, reason):
    with pytest.raises(ValueError, match=reason):
        call()
