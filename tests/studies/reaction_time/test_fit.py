import math

import msgspec
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy import stats

from core.feedback.credit import GammaDelay
from core.numerics.streams import stream
from studies.reaction_time import fit
from studies.reaction_time.families import FAMILIES, GAMMA, SHIFTED_GAMMA, fit_family
from studies.reaction_time.fit import (
    FitSettings,
    ParticipantFit,
    fit_group,
    fit_participant,
    shape_identified,
)
from studies.reaction_time.goodness import goodness_of_fit, q_q
from studies.reaction_time.intervals import Interval
from studies.reaction_time.sample import LEAST_SPREAD, FitError, sample

pytestmark = pytest.mark.jit  # bootstraps: minutes in plain Python
QUICK = FitSettings(families=("gamma", "ex-Gaussian"), n_resamples=10)
FAST = FitSettings(n_resamples=0)


def draw(n, *seed, shape=4.8, scale=0.065, offset=0.2):
    return sample(offset + stream(2, "fit", *seed).gamma(shape, scale, n))


def test_a_participants_fit_says_what_credit_assignment_needs():
    found = fit_participant("P01", draw(100, "P01"), QUICK)
    delay = found.shifted_gamma.gamma_delay()
    assert delay == GammaDelay(
        shape=found.shifted_gamma.shape,
        scale_s=found.shifted_gamma.scale_s,
        offset_s=found.shifted_gamma.offset_s,
    )
    assert delay.offset_s > 0.0
    assert found.gamma.gamma_delay().offset_s == 0.0
    assert float(delay.cdf(found.shifted_gamma.estimates["q50_s"])) == pytest.approx(0.5)
    assert set(found.gamma.profile) <= set(found.gamma.estimates)
    assert found.gamma.shape_identified
    assert "fits" in found.verdict or "best" in found.verdict


def test_a_result_survives_json():
    found = fit_participant("P01", draw(60, "json"), QUICK)
    assert msgspec.json.decode(msgspec.json.encode(found), type=ParticipantFit) == found


def test_the_same_person_has_the_same_intervals_in_any_company_and_on_any_number_of_workers():
    people = {"a": draw(40, "a"), "b": draw(50, "b")}
    seen: list[tuple[int, int, str]] = []
    alone = fit_group({"b": people["b"]}, QUICK)
    here = fit_group(people, QUICK, progress=lambda done, total, who: seen.append((done, total, who)))
    elsewhere = fit_group(people, QUICK, n_workers=2)
    assert alone.participants["b"] == here.participants["b"]
    assert here == elsewhere
    assert list(here.participants) == ["a", "b"]
    assert seen == [(1, 2, "a"), (2, 2, "b")]


def test_another_seed_gives_other_bootstrap_intervals_and_the_same_fits():
    data = draw(40, "seed")
    one = fit_participant("a", data, QUICK)
    other = fit_participant("a", data, msgspec.structs.replace(QUICK, root_seed=1))
    assert one.fits == other.fits
    assert one.gamma.bootstrap != other.gamma.bootstrap


def test_one_participant_who_cannot_be_fitted_does_not_stop_the_group():
    # Slower than the time-out they are said to have had: no simulated trial has a response.
    hopeless = sample([2.0, 2.1, 2.2, 2.3, 2.4], np.full(40, 0.5))
    group = fit_group({"slow": hopeless, "b": draw(40, "b")}, QUICK)
    assert list(group.participants) == ["b"]
    assert "cannot be simulated" in group.failures["slow"]


def test_numerical_trouble_with_one_participant_does_not_stop_the_group(monkeypatch):
    bad = draw(30, "bad")
    honest = fit.fit_participant

    def troubled(participant, data, settings):
        return 1 / 0 if data is bad else honest(participant, data, settings)

    monkeypatch.setattr(fit, "fit_participant", troubled)
    people = {name: draw(30, name) for name in "abcde"}
    group = fit_group({"bad": bad, **people}, FAST)
    assert list(group.participants) == list("abcde")
    assert "ZeroDivisionError" in group.failures["bad"]
    assert set(group.pooled) == set("abcde")
    monkeypatch.setattr(fit, "pool", lambda samples: np.linalg.inv(np.zeros((2, 2))))
    alone = fit_group(people, FAST)
    assert list(alone.participants) == list("abcde")
    assert "Singular" in alone.failures["(pooled)"]
    assert (alone.spread, alone.pooled) == (None, {})


SEVEN_FAST = [0.12243097, 0.12259747, 0.12686252, 0.12704244, 0.12849888, 0.14990335, 0.15919143]


@pytest.mark.jit
@pytest.mark.parametrize("root_seed", range(5))
def test_seven_fast_responses_are_fitted_with_all_intervals(root_seed):
    found = fit_participant("P", sample(SEVEN_FAST), FitSettings(pooled=False, root_seed=root_seed))
    for delay in (found.gamma, found.shifted_gamma):
        assert not delay.shape_identified
        for name, interval in delay.profile.items():
            assert interval.low <= delay.estimates[name] * (1 + 1e-9) <= interval.high * (1 + 1e-6)


_rounded = st.sampled_from([1e-6, 1e-3, 1 / 60, 0.1])
_small = st.tuples(st.lists(st.floats(0.1, 3.0), min_size=5, max_size=12), _rounded)


@pytest.mark.jit
@settings(max_examples=12)
@given(_small, st.integers(0, 6), st.sampled_from([0, 10]))
def test_any_small_sample_with_some_spread_is_fitted(times, n_late, n_resamples):
    values = np.maximum(np.round(np.array(times[0]) / times[1]) * times[1], times[1])
    assume(values.std() >= LEAST_SPREAD * values.mean())
    data = sample(values, np.full(n_late, values.max() + 0.1))
    found = fit_participant("P", data, msgspec.structs.replace(FAST, n_resamples=n_resamples))
    assert all(math.isfinite(one.aic) for one in found.fits)
    for delay in (found.gamma, found.shifted_gamma):
        assert delay.gamma_delay().shape == delay.shape
        for name, interval in delay.profile.items():
            estimate = delay.estimates[name]
            assert interval.low <= estimate + 1e-6 * abs(estimate), name
            assert interval.high >= estimate - 1e-6 * abs(estimate), name


def test_an_unknown_family_is_named():
    with pytest.raises(ValueError, match="unknown families \\['Gumbel'\\]"):
        fit_participant("a", draw(40, "a"), FitSettings(families=("Gumbel",)))


@pytest.mark.parametrize(
    ("n", "interval", "expected"),
    [
        (100, (4.0, 8.0, False), (True, "Shape identified")),
        (100, (2.0, 20.0, False), (False, "a factor of 10")),
        (12, (4.0, 8.0, False), (False, "fewer than 20")),
        (100, (9.0, 1e5, True), (False, "any shape above 9")),
    ],
)
def test_a_shape_is_identified_only_by_enough_trials_and_a_short_interval(n, interval, expected):
    low, high, is_bound = interval
    fit = fit_family(GAMMA, draw(n, "identified"))
    identified, reason = shape_identified(
        fit, Interval(low=low, high=high, level=0.95, high_is_bound=is_bound)
    )
    assert (identified, expected[1] in reason) == (expected[0], True)


def test_twenty_trials_do_not_identify_the_shape_of_a_shifted_gamma():
    found = fit_participant("a", draw(20, "twenty"), QUICK)
    assert not found.shifted_gamma.shape_identified
    assert "Trust mean and quantiles" in found.shifted_gamma.reason


def test_a_right_family_is_accepted_and_a_wrong_one_rejected():
    data = draw(300, "goodness")
    right = goodness_of_fit(data, fit_family(SHIFTED_GAMMA, data), rng=stream(1, "g"), n_resamples=99)
    wrong_data = sample(np.concatenate([draw(150, "left").observed_s, 2.0 + draw(150, "right").observed_s]))
    wrong = goodness_of_fit(wrong_data, fit_family(GAMMA, wrong_data), rng=stream(1, "g"), n_resamples=99)
    assert right.p_value > 0.05
    assert wrong.p_value == 0.01


@pytest.mark.parametrize("name", FAMILIES)
def test_goodness_of_fit_refits_every_family_with_our_own_fit(name):
    data = draw(40, "every")
    fit = fit_family(FAMILIES[name], data)
    found = goodness_of_fit(data, fit, rng=stream(1, "g"), n_resamples=9, statistic="ks")
    # The statistic of the data themselves is that of our fit.
    expected = stats.kstest(data.observed_s, FAMILIES[name].freeze(FAMILIES[name].values(fit.parameters)).cdf)
    assert found.statistic == pytest.approx(expected.statistic, abs=1e-9)


@pytest.mark.slow
@pytest.mark.statistical
def test_p_values_of_true_families_are_uniform():
    p_values = []
    for person in range(150):
        data = draw(50, "uniform", person)
        fit = fit_family(SHIFTED_GAMMA, data)
        p_values.append(goodness_of_fit(data, fit, rng=stream(3, "u", person), n_resamples=99).p_value)
    assert stats.kstest(p_values, "uniform").pvalue > 0.001


def test_goodness_of_fit_is_refused_with_time_outs():
    data = sample(draw(40, "t").observed_s, [0.9])
    with pytest.raises(FitError, match="1 timed-out"):
        goodness_of_fit(data, fit_family(GAMMA, data), rng=stream(1, "g"))


def test_quantiles_of_a_perfect_fit_lie_on_the_diagonal():
    data = draw(4000, "qq")
    fitted, seen = q_q(data, fit_family(SHIFTED_GAMMA, data))
    assert np.abs(fitted - seen)[100:-100].max() < 0.02


def test_time_outs_have_no_point_but_keep_their_place_above_the_others():
    data = sample(np.linspace(0.3, 0.6, 50), np.full(50, 0.6))
    fit = fit_family(GAMMA, data)
    fitted, seen = q_q(data, fit)
    assert fitted.size == seen.size == 50
    assert fitted[-1] < FAMILIES["gamma"].freeze(FAMILIES["gamma"].values(fit.parameters)).ppf(0.5)
