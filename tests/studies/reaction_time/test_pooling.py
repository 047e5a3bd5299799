import math

import numpy as np
import pytest

from core.numerics.streams import stream
from studies.reaction_time.families import GAMMA, fit_family
from studies.reaction_time.held_out import METHODS, compare_held_out, markdown_table, pinball_loss
from studies.reaction_time.pooling import pool, pooled
from studies.reaction_time.sample import FitError, sample
from tests.studies.reaction_time import real


def people(n_people, n_trials, *, spread_mean=0.2, spread_shape=0.4, n_seed=0):
    """Draw people whose log mean and log shape are normal around log 0.5 and log 10; return samples and
    truths."""
    rng = stream(n_seed, "pooling")
    samples, truths = {}, {}
    for i in range(n_people):
        mean = 0.5 * math.exp(spread_mean * rng.standard_normal())
        shape = 10.0 * math.exp(spread_shape * rng.standard_normal())
        samples[f"p{i}"] = sample(rng.gamma(shape, mean / shape, n_trials))
        truths[f"p{i}"] = (mean, shape)
    return samples, truths


@pytest.mark.statistical
def test_the_group_is_recovered():
    group, _ = pool(people(150, 40)[0])
    # Standard errors with 150 people: 0.2 / sqrt(150) = 0.017 and about 0.5 / sqrt(150) = 0.04; allow 4.
    assert group.mean[0] == pytest.approx(math.log(0.5), abs=0.07)
    assert group.mean[1] == pytest.approx(math.log(10.0), abs=0.17)
    assert math.sqrt(group.covariance[0][0]) == pytest.approx(0.2, abs=0.05)
    assert math.sqrt(group.covariance[1][1]) == pytest.approx(0.4, abs=0.12)


@pytest.mark.statistical
def test_pooling_comes_nearer_to_the_true_shapes_than_fits_alone():
    samples, truths = people(60, 20)
    _, together = pool(samples)
    alone = {name: fit_family(GAMMA, one).parameters["shape"] for name, one in samples.items()}
    error_alone = np.mean([(math.log(alone[name]) - math.log(truths[name][1])) ** 2 for name in samples])
    error_pooled = np.mean(
        [(math.log(together[name].shape) - math.log(truths[name][1])) ** 2 for name in samples]
    )
    assert error_pooled < 0.75 * error_alone


def test_people_who_do_not_differ_are_drawn_together_and_people_with_many_trials_are_left_alone():
    alike, _ = people(12, 20, spread_mean=0.0, spread_shape=0.0)
    _, together = pool(alike)
    alone = [fit_family(GAMMA, one).parameters["shape"] for one in alike.values()]
    assert np.std([one.shape for one in together.values()]) < 0.5 * np.std(alone)
    rich, _ = people(12, 3000, spread_shape=0.8)
    _, together = pool(rich)
    for name, one in rich.items():
        assert together[name].shape == pytest.approx(fit_family(GAMMA, one).parameters["shape"], rel=0.05)
        assert together[name].own_share > 0.99


def test_a_newcomer_is_pooled_with_a_group_it_was_not_part_of():
    samples, _ = people(12, 40)
    group, together = pool(samples)
    newcomer = pooled(samples["p3"], group)
    assert newcomer == together["p3"]
    few = pooled(sample(samples["p3"].observed_s[::6]), group)
    assert few.own_share < newcomer.own_share


def test_pooled_offsets_stay_below_everybodys_fastest_response():
    samples = {name: sample(0.2 + one.observed_s) for name, one in people(8, 30)[0].items()}
    group, together = pool(samples, shifted=True, max_iterations=5)
    assert group.offset_limit_s == min(one.observed_s[0] for one in samples.values())
    assert all(0.0 < one.offset_s < group.offset_limit_s for one in together.values())


def test_time_outs_take_part_in_pooling():
    samples, _ = people(8, 30)
    cut = {
        n: sample(s.observed_s[s.observed_s < 0.6], np.full((s.observed_s >= 0.6).sum(), 0.6))
        for n, s in samples.items()
    }
    dropped = {n: sample(s.observed_s[s.observed_s < 0.6]) for n, s in samples.items()}
    full, with_waits, without = (pool(one)[0].mean[0] for one in (samples, cut, dropped))
    assert abs(with_waits - full) < abs(without - full)


def test_too_few_people_are_not_pooled():
    with pytest.raises(FitError, match="at least 5 participants, got 3"):
        pool(people(3, 20)[0])


def test_pinball_loss_by_hand():
    # A density so narrow that all quantiles are 1 s: loss of 3 s is mean(level) * 2 = 1, of 0 s mean(1 -
    # level) * 1.
    narrow = (1e10, 1e-10, 0.0)
    assert pinball_loss(narrow, np.array([3.0])) == pytest.approx(1.0, rel=1e-4)
    assert pinball_loss(narrow, np.array([0.0])) == pytest.approx(0.5, rel=1e-4)


@pytest.mark.jit
def test_the_held_out_comparison_scores_every_method_on_trials_it_has_not_seen():
    times = {name: one.observed_s for name, one in people(8, 40)[0].items()}
    scores = compare_held_out(times, n_fitted=20, root_seed=1, n_splits=1)
    assert tuple(score.method for score in scores) == METHODS
    assert scores[0].pinball_gain_ms == 0.0
    assert markdown_table(scores).count("\n") == 2 + len(METHODS)
    with pytest.raises(ValueError, match="nobody has 65"):
        compare_held_out(times, n_fitted=60, root_seed=1)


@pytest.mark.jit
@pytest.mark.statistical
def test_with_twenty_trials_each_real_people_are_foretold_better_together_than_alone():
    # The first 60 people and one split (docs/results/reaction_time_pooling.md has all 257 and more).
    times = dict(list(real.go_times().items())[:60])
    from_method = {s.method: s for s in compare_held_out(times, n_fitted=20, root_seed=2, n_splits=1)}
    alone, together = from_method["alone, gamma"], from_method["pooled, gamma"]
    assert together.log_density > alone.log_density
    assert together.pinball_ms < alone.pinball_ms
    assert from_method["everybody alike"].pinball_ms > together.pinball_ms
