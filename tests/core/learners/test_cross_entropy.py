"""The noisy cross-entropy method, without a game."""

import math

import numpy as np
import pytest

from core.learners.cross_entropy import (
    ConstantNoise,
    CrossEntropy,
    CrossEntropyConfig,
    CrossEntropyLearner,
    DecreasingNoise,
    Noise,
    NoNoise,
)


def small(noise: Noise | None = None, population: int = 4, elite_fraction: float = 0.5) -> CrossEntropyConfig:
    return CrossEntropyConfig(
        population=population, elite_fraction=elite_fraction, noise=noise if noise is not None else NoNoise()
    )


def test_the_update_by_hand():
    search = CrossEntropy(small(ConstantNoise(4.0)), n_weights=2, root_seed=1)
    samples = search.population()
    search.update([1.0, 9.0, 3.0, 2.0])  # elite: samples 1 and 2
    first, second = samples[1], samples[2]
    np.testing.assert_array_equal(search.mean, (first + second) / 2)
    # population variance of two numbers: (a - b)^2 / 4; noise is added to the variance
    np.testing.assert_allclose(search.variance, (first - second) ** 2 / 4 + 4.0, rtol=1e-12)
    assert search.iteration == 1


def test_the_noise_schedules_by_hand():
    assert [NoNoise().variance(t) for t in (0, 7)] == [0.0, 0.0]
    assert [ConstantNoise().variance(t) for t in (0, 7)] == [4.0, 4.0]
    # 5 - 10 / 10 = 4; never below 0
    assert [DecreasingNoise().variance(t) for t in (0, 10, 50, 80)] == [5.0, 4.0, 0.0, 0.0]


def test_of_equal_performances_the_first_drawn_are_elite():
    search = CrossEntropy(small(), n_weights=1, root_seed=1)
    assert search.elite([5.0, 7.0, 5.0, 5.0]).tolist() == [0, 1]


def test_the_order_within_the_elite_does_not_matter():
    one, other = (CrossEntropy(small(population=10), n_weights=3, root_seed=2) for _ in range(2))
    one.update([9, 8, 7, 6, 5, 0, 0, 0, 0, 0])
    other.update([5, 6, 7, 8, 9, 4, 4, 4, 4, 4])
    np.testing.assert_array_equal(one.mean, other.mean)
    np.testing.assert_array_equal(one.variance, other.variance)


@pytest.mark.statistical
def test_the_first_population_is_normal_with_the_initial_variance():
    samples = (
        CrossEntropy(CrossEntropyConfig(population=2_000), n_weights=20, root_seed=3).population().ravel()
    )
    # n = 40 000: se of the mean 10/200 = 0.05; of the variance 100 sqrt(2/n) = 0.71
    assert abs(samples.mean()) < 4 * 0.05
    assert abs(samples.var() - 100.0) < 4 * 0.71


def test_it_finds_the_top_of_a_quadratic_and_keeps_the_noise_it_is_given():
    target = np.array([3.0, -7.0, 0.5])
    search = CrossEntropy(CrossEntropyConfig(noise=ConstantNoise(0.01)), n_weights=3, root_seed=4)
    for _ in range(40):
        search.update(-((search.population() - target) ** 2).sum(axis=1))
        assert (search.variance >= 0.01).all()
    # The mean of 10 elite samples of sd about 0.1: allow 4 * 0.1.
    np.testing.assert_allclose(search.mean, target, atol=0.4)


def test_without_noise_the_variance_dies_out():
    search = CrossEntropy(CrossEntropyConfig(noise=NoNoise()), n_weights=3, root_seed=4)
    for _ in range(60):
        search.update(-(search.population() ** 2).sum(axis=1))
    assert (search.variance < 1e-6).all()


def performance_of(weights: np.ndarray) -> float:
    return float(100.0 / (1.0 + ((weights - 2.0) ** 2).sum()))


def test_one_candidate_at_a_time_is_the_same_search():
    config = CrossEntropyConfig(population=10)
    whole = CrossEntropy(config, n_weights=3, root_seed=5)
    stepped = CrossEntropyLearner(config, n_weights=3, root_seed=5)
    for _ in range(4):
        whole.update([performance_of(sample) for sample in whole.population()])
    for number in range(40):
        candidate = stepped.propose()
        assert candidate.policy_id == number
        stepped.report(candidate.policy_id, performance_of(candidate.weights))
    np.testing.assert_array_equal(stepped.search.mean, whole.mean)
    np.testing.assert_array_equal(stepped.search.variance, whole.variance)


def test_another_seed_is_another_search():
    one, other = (CrossEntropy(small(), n_weights=2, root_seed=seed).population() for seed in (1, 2))
    assert not np.array_equal(one, other)


def test_a_candidate_is_proposed_again_until_it_has_been_played():
    learner = CrossEntropyLearner(small(), n_weights=2, root_seed=1)
    np.testing.assert_array_equal(learner.propose().weights, learner.propose().weights)
    before = learner.state_digest()
    learner.report(0, 1.0)
    assert learner.propose().policy_id == 1
    assert learner.state_digest() != before


def test_a_report_for_another_candidate_is_refused():
    learner = CrossEntropyLearner(small(), n_weights=2, root_seed=1)
    with pytest.raises(ValueError, match="policy 0 waits"):
        learner.report(3, 1.0)
    with pytest.raises(ValueError, match="performance is finite"):
        learner.report(0, math.nan)


def test_performances_must_be_one_per_sample():
    with pytest.raises(ValueError, match="need 4 performances"):
        CrossEntropy(small(), n_weights=2, root_seed=1).update([1.0, 2.0])


@pytest.mark.parametrize("wrong", [{"population": 0}, {"elite_fraction": 0.0}, {"initial_variance": 0.0}])
def test_senseless_settings_are_refused(wrong):
    with pytest.raises(ValueError):
        CrossEntropyConfig(**wrong)


def test_the_defaults_are_those_of_the_literature():
    config = CrossEntropyConfig()
    assert (config.population, config.elite_size, config.initial_variance) == (100, 10, 100.0)
    assert config.noise == DecreasingNoise(5.0, 10.0)
