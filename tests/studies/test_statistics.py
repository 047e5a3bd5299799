"""Intervals and paired comparisons."""

import numpy as np
import pytest

from core.streams import stream
from studies.statistics import mean_interval, paired_difference


def test_one_result_is_its_own_interval():
    interval = mean_interval([4.0], rng=stream(1, "bootstrap"))
    assert (interval.estimate, interval.low, interval.high) == (4.0, 4.0, 4.0)


def test_the_same_stream_gives_the_same_interval_and_another_does_not():
    values = stream(1, "values").exponential(size=30)
    assert mean_interval(values, rng=stream(2, "b")) == mean_interval(values, rng=stream(2, "b"))
    assert mean_interval(values, rng=stream(2, "b")) != mean_interval(values, rng=stream(3, "b"))


def test_the_interval_of_normal_results_agrees_with_theory():
    values = stream(1, "values").normal(10.0, 2.0, size=400)
    interval = mean_interval(values, rng=stream(2, "b"), resamples=8000)
    half_width = 1.96 * values.std() / 20
    # The quantile of 8,000 resamples has a standard error of about 2 % of the half-width; allow 4 of them.
    assert interval.high - interval.estimate == pytest.approx(half_width, rel=0.1)
    assert interval.estimate - interval.low == pytest.approx(half_width, rel=0.1)


@pytest.mark.statistical
def test_the_interval_covers_the_mean_of_exponential_scores_about_as_often_as_it_says():
    covered = 0
    for trial in range(300):
        values = stream(5, "scores", trial).exponential(3.0, size=60)
        interval = mean_interval(values, rng=stream(5, "b", trial), resamples=500)
        covered += interval.low <= 3.0 <= interval.high
    # Percentile intervals of 60 skewed scores cover a little less than 95 %: about 93 %. Standard error 1.5 %.
    assert 0.87 <= covered / 300 <= 0.98


def test_a_paired_difference_is_blind_to_what_both_share():
    seeds = stream(1, "seeds").exponential(100.0, size=50)
    difference = paired_difference(seeds + 1.0, seeds, rng=stream(1, "b"))
    assert difference.low == pytest.approx(1.0)
    assert difference.high == pytest.approx(1.0)


@pytest.mark.parametrize("values", [[], [[1.0]], [1.0, np.nan]])
def test_unusable_results_are_refused(values):
    with pytest.raises(ValueError, match="results"):
        mean_interval(values, rng=stream(1, "b"))


def test_pairs_need_equal_numbers():
    with pytest.raises(ValueError, match="got 2 and 1"):
        paired_difference([1.0, 2.0], [1.0], rng=stream(1, "b"))
