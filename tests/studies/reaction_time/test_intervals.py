import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, stats

from core.numerics.streams import stream
from studies.reaction_time.bootstrap import critical_values, percentile_intervals, resample
from studies.reaction_time.families import FAMILIES, GAMMA, SHIFTED_GAMMA, fit_family
from studies.reaction_time.fit import FitSettings, fit_participant
from studies.reaction_time.intervals import profile_interval, profile_intervals, profile_log_likelihood
from studies.reaction_time.quantities import QUANTITIES, gamma_quantities, quantities_of
from studies.reaction_time.sample import FitError, sample
from tests.naive import reaction_time as naive

PAPER = (2.5, 0.3, 0.0)
GO = (4.8, 0.065, 0.2)
"""About the pooled go reactions of 257 people."""


def draw(truth, n, *seed):
    shape, scale, offset = truth
    return sample(offset + stream(1, "intervals", *seed).gamma(shape, scale, n))


def test_what_the_papers_gamma_means_by_hand():
    # mean k * theta = 0.75, mode (k - 1) * theta = 0.45, sd = sqrt(2.5) * 0.3; median and 95 % point from
    # tables.
    found = {name: float(value) for name, value in gamma_quantities(*PAPER).items()}
    assert found["mean_s"] == pytest.approx(0.75)
    assert found["mode_s"] == pytest.approx(0.45)
    assert found["sd_s"] == pytest.approx(0.47434, abs=1e-5)
    assert found["q50_s"] == pytest.approx(0.653, abs=1e-3)
    assert found["q95_s"] == pytest.approx(1.66, abs=5e-3)


def test_a_shape_below_one_has_its_mode_at_the_offset():
    assert float(gamma_quantities(0.5, 0.3, 0.2)["mode_s"]) == pytest.approx(0.2)


@given(st.floats(1.0, 50.0), st.floats(0.01, 1.0), st.floats(0.0, 1.0))
def test_an_offset_moves_every_location_by_itself_and_no_width(shape, scale, offset):
    here, there = gamma_quantities(shape, scale, 0.0), gamma_quantities(shape, scale, offset)
    for name in ("mean_s", "mode_s", "q05_s", "q50_s", "q95_s"):
        assert float(there[name]) == pytest.approx(float(here[name]) + offset)
    assert float(there["sd_s"]) == float(here["sd_s"])


def naive_profile(x, waits, quantity, value, shifted):
    """Profile by a grid of offsets, and at each a search over log shape for what the constraint leaves
    open."""
    best = -np.inf
    for offset in np.linspace(0.0, x.min() - 1e-9, 300) if shifted else [0.0]:
        if quantity == "offset_s":
            offset = value

        def loss(log_k, offset=offset):
            k = np.exp(log_k)
            unit = {name: float(v) for name, v in gamma_quantities(k, 1.0, 0.0).items()}
            if quantity == "shape":
                k, scale = value, np.exp(log_k)
            elif quantity == "scale_s":
                scale = value
            else:
                scale = (value - (0.0 if quantity == "sd_s" else offset)) / unit[quantity]
            if scale <= 0.0:
                return 1e9
            return -naive.censored_log_likelihood(stats.gamma(k, loc=offset, scale=scale), x, waits)

        bounds = (-8.0, 2.0) if quantity == "shape" else (0.0 if shifted else -3.0, 8.0)
        best = max(best, -optimize.minimize_scalar(loss, bounds=bounds, method="bounded").fun)
    return best


@pytest.mark.parametrize("timed_out", [False, True])
@pytest.mark.parametrize(
    ("quantity", "factor"),
    [("shape", 0.7), ("scale_s", 1.3), ("mean_s", 1.05), ("sd_s", 0.9), ("q05_s", 0.95), ("q95_s", 1.1)],
)
def test_the_profile_of_each_quantity_agrees_with_a_naive_search(quantity, factor, timed_out):
    x = draw(PAPER, 40, "naive").observed_s
    data = sample(x[x < 1.2], np.full(np.count_nonzero(x >= 1.2), 1.2)) if timed_out else sample(x)
    value = factor * quantities_of(fit_family(GAMMA, data))[quantity]
    expected = naive_profile(data.observed_s, data.censored_s, quantity, value, shifted=False)
    assert profile_log_likelihood(data, GAMMA, quantity, value) == pytest.approx(expected, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("quantity", ["shape", "scale_s", "mean_s", "sd_s", "q05_s", "q50_s", "q95_s"])
def test_the_shifted_profile_agrees_with_a_naive_search(quantity):
    data = draw(GO, 40, "naive shifted")
    value = 1.05 * quantities_of(fit_family(SHIFTED_GAMMA, data))[quantity]
    expected = naive_profile(data.observed_s, data.censored_s, quantity, value, shifted=True)
    assert profile_log_likelihood(data, SHIFTED_GAMMA, quantity, value) == pytest.approx(expected, abs=1e-3)


@pytest.mark.jit
@pytest.mark.parametrize("family", [GAMMA, SHIFTED_GAMMA], ids=lambda family: family.name)
def test_the_profile_is_highest_at_the_fit_and_falls_by_the_cut_at_the_ends(family):
    data = draw(GO, 80, "ends")
    fit = fit_family(family, data)
    cut = stats.chi2.ppf(0.95, 1)
    for name, interval in profile_intervals(data, fit).items():
        centre = quantities_of(fit)[name]
        assert interval.low <= centre <= interval.high, name
        assert profile_log_likelihood(data, family, name, centre) == pytest.approx(
            fit.log_likelihood, abs=1e-5
        )
        for end, is_bound in ((interval.low, interval.low_is_bound), (interval.high, interval.high_is_bound)):
            if not is_bound:
                at_end = profile_log_likelihood(data, family, name, end)
                assert at_end == pytest.approx(fit.log_likelihood - cut / 2, abs=1e-3), name


def test_more_confidence_needs_a_wider_interval_and_more_trials_a_narrower_one():
    few, many = draw(PAPER, 30, "few"), draw(PAPER, 3000, "many")
    fit_few, fit_many = fit_family(GAMMA, few), fit_family(GAMMA, many)
    narrow, wide = (profile_interval(few, fit_few, "shape", level=level) for level in (0.8, 0.99))
    assert wide.low < narrow.low < narrow.high < wide.high
    tight = profile_interval(many, fit_many, "shape")
    assert tight.high / tight.low < (narrow.high / narrow.low) ** 0.5


@pytest.mark.jit
def test_an_interval_that_meets_the_edge_of_the_region_says_so():
    fast = sample(stream(2, "edge").gamma(30.0, 0.01, 40))  # hardly skewed: offset 0 is as good as any
    fit = fit_family(SHIFTED_GAMMA, fast)
    assert profile_interval(fast, fit, "offset_s").low_is_bound
    skewed = sample(0.3 + stream(2, "skewed").exponential(0.2, 40))
    assert profile_interval(skewed, fit_family(SHIFTED_GAMMA, skewed), "shape").low_is_bound


@pytest.mark.jit
def test_a_resample_has_the_trials_and_the_time_outs_of_the_data():
    x = draw(GO, 60, "resample").observed_s
    data = sample(x[x < 0.6], np.full(np.count_nonzero(x >= 0.6), 0.6))
    drawn = resample(fit_family(GAMMA, data), data, 20, rng=stream(1, "r"))
    assert all(one.n == 60 for one in drawn.samples)
    assert max(one.observed_s.max() for one in drawn.samples) < 0.6
    assert {float(w) for one in drawn.samples for w in one.censored_s} == {0.6}
    assert set(drawn.quantities) == set(QUANTITIES)


@pytest.mark.jit
def test_a_resample_without_responses_is_refused():
    data = sample([2.0, 2.1, 2.2, 2.3, 2.4], np.full(40, 0.5))
    fit = fit_family(GAMMA, data)
    with pytest.raises(FitError, match="lengthen the time-out"):
        resample(fit, data, 200, rng=stream(1, "r"))


@pytest.mark.jit
def test_simulated_samples_that_nobody_would_fit_are_drawn_again():
    # Five of ten trials had a response: every second simulated sample has fewer.
    data = sample([0.4, 0.5, 0.6, 0.7, 0.8], np.full(5, 0.9))
    drawn = resample(fit_family(GAMMA, data), data, 50, rng=stream(1, "r"))
    assert len(drawn.samples) == len(drawn.log_likelihoods) == 50
    assert min(one.observed_s.size for one in drawn.samples) == 5
    assert all(one.n == 10 for one in drawn.samples)


@pytest.mark.jit
def test_calibration_never_narrows_an_interval():
    data = draw(GO, 80, "calibrated")
    fit = fit_family(SHIFTED_GAMMA, data)
    cuts = critical_values(fit, resample(fit, data, 60, rng=stream(1, "c")))
    plain, wider = profile_intervals(data, fit), profile_intervals(data, fit, cuts=cuts)
    for name in cuts:
        assert wider[name].low <= plain[name].low + 1e-6
        assert wider[name].high >= plain[name].high - 1e-6


def binomial_tolerance(n: int) -> float:
    """Half-width within which the fraction of hits lies with probability 0.999 if coverage is 0.95."""
    return 3.29 * (0.95 * 0.05 / n) ** 0.5


def coverage(truth, family, n_people, n_trials, n_resamples):
    """Fraction of simulated participants whose interval holds the truth, by method and quantity."""
    true = {name: float(value) for name, value in gamma_quantities(*truth).items()}
    hits: dict[tuple[str, str], int] = {}
    for person in range(n_people):
        data = draw(truth, n_trials, "coverage", family.name, person)
        fit = fit_family(family, data)
        resamples = resample(fit, data, n_resamples, rng=stream(1, "coverage", person))
        cuts = critical_values(fit, resamples)
        methods = {
            "profile": profile_intervals(data, fit, cuts=cuts),
            "percentile": percentile_intervals(resamples),
        }
        for method, intervals in methods.items():
            for name, interval in intervals.items():
                hits[method, name] = hits.get((method, name), 0) + (
                    interval.low <= true[name] <= interval.high
                )
    return {key: count / n_people for key, count in hits.items()}


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(
    ("truth", "family"), [(PAPER, GAMMA), (GO, SHIFTED_GAMMA)], ids=["2-parameter", "shifted"]
)
def test_95_percent_intervals_hold_the_truth_for_95_percent_of_500_participants(truth, family):
    found = coverage(truth, family, n_people=500, n_trials=100, n_resamples=200)
    print({key: round(share, 3) for key, share in found.items()})
    # Percentiles of shape, scale, offset and 5 % point of the shifted gamma are too narrow: that is why the
    # profile intervals are calibrated (docs/trusting-a-fit.md has the measured coverage).
    too_narrow = {"offset_s"} if family is GAMMA else {"shape", "scale_s", "offset_s", "q05_s", "mode_s"}
    for (method, name), share in found.items():
        if method == "profile" or name not in too_narrow:
            assert share == pytest.approx(0.95, abs=binomial_tolerance(500)), (method, name)


@pytest.mark.jit
@pytest.mark.statistical
def test_intervals_of_the_mean_hold_the_truth_for_most_of_100_participants():
    hits = 0
    for person in range(100):
        data = draw(PAPER, 50, "mean", person)
        interval = profile_interval(data, fit_family(GAMMA, data), "mean_s")
        hits += interval.low <= 0.75 <= interval.high
    assert hits / 100 == pytest.approx(0.95, abs=binomial_tolerance(100))


def test_other_families_have_no_delay_intervals():
    data = draw(GO, 40, "other")
    with pytest.raises(ValueError, match="gamma and shifted gamma"):
        profile_log_likelihood(data, FAMILIES["Wald"], "mean_s", 0.5)


@pytest.mark.jit
@settings(max_examples=15)
@given(st.integers(0, 1000), st.sampled_from([GAMMA, SHIFTED_GAMMA]))
def test_no_value_of_a_quantity_beats_the_fit(seed, family):
    data = draw(GO, 30, "beat", seed)
    fit = fit_family(family, data)
    for name in ("shape", "scale_s", "mean_s", "sd_s", "q50_s"):
        for factor in (0.5, 0.9, 1.1, 3.0):
            value = factor * quantities_of(fit)[name]
            if name == "shape" and value < family.bound:
                continue
            assert profile_log_likelihood(data, family, name, value) <= fit.log_likelihood + 1e-6


def test_an_evenly_spaced_dozen_has_intervals_too() -> None:
    # Along a constant sd the likelihood of so narrow a sample has more tops than one.
    participant = fit_participant("P01", sample(0.300 + 0.007 * np.arange(2, 14)), FitSettings(n_resamples=0))
    sd = participant.gamma.estimates["sd_s"]
    interval = participant.gamma.profile["sd_s"]
    assert interval.low < sd < interval.high


def test_times_that_differ_by_a_hundredth_have_an_interval_of_their_sd() -> None:
    # The top along a constant sd is far narrower than the grid, and lower on it than a second top at tiny
    # shapes.
    times = sample(2.95 + 0.05 * stream(3, "narrow").beta(2.0, 1.0, 13))
    fit = fit_family(GAMMA, times)
    sd = quantities_of(fit)["sd_s"]
    assert profile_log_likelihood(times, GAMMA, "sd_s", sd) == pytest.approx(fit.log_likelihood, abs=1e-4)
    interval = profile_interval(times, fit, "sd_s")
    assert 0.5 * sd < interval.low < sd < interval.high < 2.0 * sd
