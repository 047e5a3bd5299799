"""Intervals and paired comparisons."""

import numpy as np
import pytest
from scipy import stats

from core.numerics.streams import stream
from studies.statistics import (
    interquartile_mean_interval,
    mean_interval,
    median_interval,
    paired_difference,
    paired_ratio,
)


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
    # Percentile intervals of 60 skewed scores cover a little less than 95 %: about 93 %. Standard error 1.5
    # %.
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


def test_the_interquartile_mean_is_the_trimmed_mean_of_scipy():
    for n in (1, 3, 4, 7, 20, 41):
        values = stream(2, "scores", n).exponential(size=n)
        assert interquartile_mean_interval(values, rng=stream(1, "b")).estimate == pytest.approx(
            stats.trim_mean(values, 0.25)
        )


def test_one_enormous_score_moves_the_mean_but_not_median_and_interquartile_mean():
    values = np.arange(20.0)
    wild = np.append(values[:-1], 1e9)
    assert (
        interquartile_mean_interval(wild, rng=stream(1, "b")).estimate
        == interquartile_mean_interval(values, rng=stream(1, "b")).estimate
    )
    assert median_interval(wild, rng=stream(1, "b")).estimate == np.median(values)


@pytest.mark.parametrize(
    "interval", [mean_interval, median_interval, interquartile_mean_interval], ids=lambda f: f.__name__
)
def test_every_interval_encloses_its_estimate_and_follows_its_stream_alone(interval):
    values = stream(3, "scores").exponential(size=21)
    # Few resamples: the quantiles of many would be the same medians for every stream.
    found = interval(values, rng=stream(4, "b"), resamples=50)
    assert found.low < found.estimate < found.high
    assert interval(values, rng=stream(4, "b"), resamples=50) == found
    assert interval(values, rng=stream(5, "b"), resamples=50) != found
    wider = interval(values, rng=stream(4, "b"), resamples=50, level=0.99)
    assert wider.low <= found.low
    assert wider.high >= found.high


def test_the_bootstrap_of_the_mean_agrees_with_scipy():
    values = stream(3, "scores").exponential(size=40)
    ours = mean_interval(values, rng=stream(4, "b"), resamples=20_000)
    theirs = stats.bootstrap((values,), np.mean, method="percentile", n_resamples=20_000, rng=stream(5, "b"))
    # Quantiles of 20,000 resamples: standard errors of about 1.5 % of the half-width each; allow 4 of them.
    half_width = (ours.high - ours.low) / 2
    assert ours.low == pytest.approx(theirs.confidence_interval.low, abs=0.06 * half_width)
    assert ours.high == pytest.approx(theirs.confidence_interval.high, abs=0.06 * half_width)


def test_a_paired_ratio_is_blind_to_how_large_the_pairs_are():
    control = stream(1, "scores").exponential(size=30)
    ratio = paired_ratio(2.5 * control, control, rng=stream(1, "b"))
    assert (ratio.estimate, ratio.low, ratio.high) == pytest.approx((2.5, 2.5, 2.5))
    with pytest.raises(ValueError, match="> 0"):
        paired_ratio([1.0, 0.0], [1.0, 1.0], rng=stream(1, "b"))
