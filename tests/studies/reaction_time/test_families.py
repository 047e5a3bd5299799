import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import special, stats

from core.numerics.streams import stream
from studies.reaction_time import gamma_functions, kernels
from studies.reaction_time.families import (
    EX_GAUSSIAN,
    FAMILIES,
    GAMMA,
    SHIFTED_GAMMA,
    compare,
    fit_all,
    fit_family,
    log_likelihood,
)
from studies.reaction_time.sample import FitError, sample
from tests.naive import reaction_time as naive
from tests.studies.reaction_time import real

SHIFTED = [family for family in FAMILIES.values() if family.shifted]


def times(seed: int, n: int = 60) -> np.ndarray:
    return 0.2 + stream(seed, "times").gamma(4.0, 0.07, n)


def test_a_gamma_fit_by_hand():
    # Gamma: scale = mean / shape and log k - digamma(k) = log(mean) - mean(log x).
    x = np.array([0.2, 0.3, 0.4, 0.5, 0.6])
    fit = fit_family(GAMMA, sample(x))
    k = fit.parameters["shape"]
    assert k * fit.parameters["scale_s"] == pytest.approx(0.4, rel=1e-12)
    assert math.log(k) - special.digamma(k) == pytest.approx(math.log(0.4) - np.log(x).mean(), rel=1e-9)
    assert fit.aic == pytest.approx(4.0 - 2.0 * fit.log_likelihood)
    assert fit.bic == pytest.approx(2.0 * math.log(5) - 2.0 * fit.log_likelihood)


def test_log_normal_and_wald_fits_by_hand():
    x = np.array([0.2, 0.3, 0.4, 0.5, 0.6])
    log_normal = fit_family(FAMILIES["log-normal"], sample(x)).parameters
    assert log_normal == pytest.approx({"mu": np.log(x).mean(), "sigma": np.log(x).std()})
    wald = fit_family(FAMILIES["Wald"], sample(x)).parameters
    # lambda = 1 / (mean of 1/x - 1 / mean)
    assert wald == pytest.approx({"mean_s": 0.4, "lambda_s": 1.0 / ((1.0 / x).mean() - 2.5)})


@pytest.mark.parametrize("x", [1e-3, 0.1, 1.0, 2.5, 7.9, 8.1, 40.0, 1e5])
def test_digamma_and_trigamma_agree_with_scipy(x):
    assert gamma_functions.digamma(x) == pytest.approx(special.digamma(x), rel=1e-12, abs=1e-12)
    assert gamma_functions.trigamma(x) == pytest.approx(special.polygamma(1, x), rel=1e-11)


@pytest.mark.parametrize("k", [0.01, 0.5, 1.0, 2.5, 30.0, 49.9, 50.1, 1e3, 1e6, 1e9])
def test_the_shape_equation_is_solved_over_eleven_decades(k):
    assert gamma_functions.gamma_shape(gamma_functions.log_minus_digamma(k)) == pytest.approx(k, rel=1e-9)


@pytest.mark.parametrize(
    ("k", "z"), [(2.0, 0.5), (2.0, 10.0), (30.0, 200.0), (0.5, 3.0), (1e4, 1.02e4), (5.0, 0.0)]
)
def test_the_gamma_survival_agrees_with_scipy(k, z):
    assert gamma_functions.log_gamma_survival(k, z) == pytest.approx(stats.gamma.logsf(z, k), rel=1e-9)


@pytest.mark.parametrize("family", FAMILIES.values(), ids=FAMILIES)
def test_the_reported_likelihood_is_that_of_the_reported_parameters(family):
    data = sample(times(1))
    fit = fit_family(family, data)
    assert log_likelihood(family, family.values(fit.parameters), data) == pytest.approx(
        fit.log_likelihood, abs=1e-7
    )


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", FAMILIES)
def test_fits_reach_the_top_found_by_the_naive_search(name, seed):
    x = np.sort(times(seed, n=25 + 10 * seed))
    assert fit_family(FAMILIES[name], sample(x)).log_likelihood >= naive.best_log_likelihood(name, x) - 1e-5


@pytest.mark.jit
@settings(max_examples=40)
@given(st.lists(st.floats(0.05, 5.0), min_size=6, max_size=40, unique=True), st.sampled_from(SHIFTED))
def test_a_shifted_fit_is_never_worse_than_the_same_family_inside_its_bounds_at_offset_zero(values, family):
    data = sample(values)
    fit = fit_family(family, data)
    at_zero = kernels.fit_at_offset(data.observed_s, 0.0, family.kernel, family.bound, np.empty(2))
    assert fit.log_likelihood >= at_zero - 1e-9
    assert 0.0 <= fit.parameters["offset_s"] < data.observed_s[0]


@pytest.mark.jit
@settings(max_examples=20)
@given(st.integers(0, 10_000), st.floats(0.2, 5.0), st.sampled_from(list(FAMILIES)))
def test_times_in_another_unit_give_the_same_fit(seed, factor, name):
    # x -> c x multiplies scales by c and takes n log c from the likelihood.
    x = times(seed, 30)
    one, other = fit_family(FAMILIES[name], sample(x)), fit_family(FAMILIES[name], sample(factor * x))
    if name != EX_GAUSSIAN.name or not (one.at_bound or other.at_bound):  # its least width is absolute
        assert other.log_likelihood == pytest.approx(one.log_likelihood - 30 * math.log(factor), abs=1e-4)


@pytest.mark.parametrize("name", FAMILIES)
def test_no_neighbour_of_a_censored_fit_is_better(name):
    family = FAMILIES[name]
    x = times(3, 60)
    data = sample(x[x < 0.55], np.full(np.count_nonzero(x >= 0.55), 0.55))
    assert data.censored_s.size > 5
    fit = fit_family(family, data)
    best = np.array(family.values(fit.parameters))
    rng = stream(4, "neighbours", name)
    for size in (0.1, 0.01, 0.001):
        for _ in range(20):
            near = best * (1.0 + size * rng.standard_normal(best.size))
            if family.shifted:
                near[2] = min(max(near[2], 0.0), data.observed_s[0] - 1e-9)
            if family.bound and family.kernel != kernels.LOG_NORMAL:
                near[0] = max(near[0], family.bound)
            assert log_likelihood(family, near.tolist(), data) <= fit.log_likelihood + 1e-5


def test_the_censored_gamma_agrees_with_scipys_censored_data():
    x = times(5, 80)
    seen, waits = x[x < 0.6], np.full(np.count_nonzero(x >= 0.6), 0.6)
    shape, _, scale = stats.gamma.fit(
        stats.CensoredData.right_censored(np.append(seen, waits), np.r_[seen * 0, waits]), floc=0
    )
    fit = fit_family(GAMMA, sample(seen, waits))
    assert fit.parameters["shape"] == pytest.approx(shape, rel=2e-3)
    assert fit.parameters["scale_s"] == pytest.approx(scale, rel=2e-3)
    assert (
        fit.log_likelihood
        >= naive.censored_log_likelihood(stats.gamma(shape, scale=scale), seen, waits) - 1e-9
    )


@pytest.mark.jit
def test_waiting_a_very_short_time_tells_nothing():
    x = times(6)
    alone = fit_family(SHIFTED_GAMMA, sample(x))
    with_waits = fit_family(SHIFTED_GAMMA, sample(x, [1e-6, 1e-6]))
    assert with_waits.log_likelihood == pytest.approx(alone.log_likelihood, abs=1e-6)
    assert with_waits.parameters == pytest.approx(alone.parameters, rel=1e-3)


@pytest.mark.statistical
def test_time_outs_taken_as_censored_do_not_shorten_the_delay():
    x = 0.2 + stream(8, "censored").gamma(4.0, 0.07, 4000)
    late = x >= 0.6
    data = sample(x[~late], np.full(late.sum(), 0.6))
    p = fit_family(GAMMA, data).parameters
    full = fit_family(GAMMA, sample(x)).parameters
    # The mean of all times is 0.48 s with standard error 0.0022; dropping late trials would give 0.43.
    assert p["shape"] * p["scale_s"] == pytest.approx(full["shape"] * full["scale_s"], abs=0.015)
    assert x[~late].mean() < 0.445


def test_an_exponential_sample_stops_at_the_bound_of_the_shape():
    x = 0.3 + stream(9, "exponential").gamma(0.6, 0.2, 200)
    fit = fit_family(SHIFTED_GAMMA, sample(x))
    assert fit.at_bound == ("shape", "offset_s")
    assert fit.parameters["shape"] == 1.0


@pytest.mark.parametrize(
    ("observed", "message"),
    [
        ([0.3, 0.4, 0.5, 0.6], "need at least 5"),
        ([0.3] * 20, "some spread"),
        ([0.3, 0.3001] * 10, "nobody reacts so evenly"),
        ([0.3, 0.4, 0.5, 0.6, 0.0], "> 0 s"),
        ([0.3, 0.4, 0.5, 0.6, float("nan")], "finite"),
        ([[0.3, 0.4]], "one-dimensional"),
    ],
)
def test_a_sample_that_cannot_be_fitted_says_why(observed, message):
    with pytest.raises(FitError, match=message):
        sample(observed)


def test_the_better_family_is_named_in_a_sentence():
    x = 0.2 + stream(10, "exg").normal(0.3, 0.02, 800) + stream(11, "exg").exponential(0.15, 800)
    fits = fit_all(sample(x))
    assert fits[0].family == "ex-Gaussian"
    assert compare(fits, "gamma").startswith("The ex-Gaussian fits clearly better than the gamma")
    assert "best of the 9 families" in compare(fits, "ex-Gaussian")


GROUPS = {"go": real.go_times, "flanker": real.flanker_times}


@pytest.mark.jit
@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("name", ["gamma", "shifted gamma", "log-normal", "Wald", "Weibull"])
def test_every_real_participants_fit_is_the_independent_optimum(group, name):
    people = GROUPS[group]()
    for participant, x in people.items():
        fit = fit_family(FAMILIES[name], sample(x))
        best = naive.best_log_likelihood(name, x)
        assert fit.log_likelihood == pytest.approx(best, abs=1e-3), participant


@pytest.mark.slow
@pytest.mark.parametrize("group", GROUPS)
@pytest.mark.parametrize("name", ["shifted log-normal", "shifted Wald", "shifted Weibull", "ex-Gaussian"])
def test_every_real_participants_other_fits_are_the_independent_optimum(group, name):
    for participant, x in GROUPS[group]().items():
        fit = fit_family(FAMILIES[name], sample(x))
        assert fit.log_likelihood == pytest.approx(naive.best_log_likelihood(name, x), abs=1e-3), participant


@pytest.mark.jit
@pytest.mark.parametrize(
    ("group", "order", "aics"),
    [
        ("go", ["ex-Gaussian", "shifted gamma", "gamma"], [-28_915, -28_707, -27_365]),
        ("flanker", ["shifted gamma", "ex-Gaussian", "gamma"], [-655, None, -536]),
    ],
)
def test_the_published_ranking_of_pooled_real_times_is_reproduced(group, order, aics):
    pooled = sample(np.concatenate(list(GROUPS[group]().values())))
    fits = fit_all(pooled, tuple(FAMILIES[name] for name in order))
    assert [fit.family for fit in fits] == order
    for fit, aic in zip(fits, aics, strict=True):
        assert aic is None or fit.aic == pytest.approx(aic, abs=0.6)


@pytest.mark.jit
@pytest.mark.parametrize("group", GROUPS)
def test_shifted_log_normal_leads_the_pooled_real_times_and_the_papers_gamma_never_does(group):
    fits = fit_all(sample(np.concatenate(list(GROUPS[group]().values()))))
    assert fits[0].family == "shifted log-normal"
    ranks = [fit.family for fit in fits]
    assert ranks.index("gamma") > ranks.index("shifted gamma")
