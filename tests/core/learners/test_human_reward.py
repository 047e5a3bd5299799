"""The human reward model: by hand, against slow twins, and what must always hold."""

import math
from typing import Literal

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from core.feedback.samples import FeedbackSample
from core.learners.human_config import HumanModelConfig, RidgeModel, SgdModel
from core.learners.human_reward import HumanRewardModel
from core.numerics.streams import stream
from tests.naive import feedback as naive

CONFIGS: list[HumanModelConfig] = [
    RidgeModel(),
    RidgeModel(l2=0.1, intercept="none"),
    RidgeModel(intercept="free"),
    RidgeModel(standardise=False),
    SgdModel(step_size=0.01),
    SgdModel(step_size=0.1, standardise=True),
    SgdModel(step_size=0.01, intercept=False),
]


def sample(features: list[float], label: float, weight: float = 1.0) -> FeedbackSample:
    return FeedbackSample(np.array(features, dtype=np.float64), label, weight, 0, (0,))


def random_samples(n: int, n_features: int, seed: int = 0) -> list[FeedbackSample]:
    rng = stream(seed, "samples")
    rows = rng.integers(-5, 6, size=(n, n_features)).astype(np.float64)
    labels = np.sign(rows @ rng.normal(size=n_features) + rng.normal(size=n))
    weights = rng.uniform(0.1, 1, size=n)
    return [
        FeedbackSample(row, float(label), float(weight), step, (step,))
        for step, (row, label, weight) in enumerate(zip(rows, labels, weights, strict=True))
    ]


def columns(
    samples: list[FeedbackSample],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    return (
        np.array([one.features for one in samples]),
        np.array([one.label for one in samples]),
        np.array([one.weight for one in samples]),
    )


def fitted(config: HumanModelConfig, samples: list[FeedbackSample]) -> HumanRewardModel:
    model = HumanRewardModel(config, len(samples[0].features))
    model.fit(samples)
    return model


def test_gradient_descent_by_hand() -> None:
    model = HumanRewardModel(SgdModel(step_size=0.5), 2)
    # H = 0, error 1, move 0.5: v = 0.5 (1, 2) = (0.5, 1), bias 0.5
    model.add(sample([1, 2], 1.0))
    assert (model.weights.tolist(), model.intercept) == ([0.5, 1.0], 0.5)
    # H = 0.5 * 2 + 1 * 0 + 0.5 = 1.5, error -2.5, weight 0.2, move 0.5 * 0.2 * -2.5 = -0.25:
    # v = (0.5 - 0.5, 1), bias 0.25
    model.add(sample([2, 0], -1.0, 0.2))
    assert (model.weights.tolist(), model.intercept) == ([0.0, 1.0], 0.25)
    # 0 * 3 + 1 * 4 + 0.25
    assert model.predict(np.array([[3.0, 4.0]])).tolist() == [4.25]


def test_tamers_step_size_is_the_default() -> None:
    model = HumanRewardModel(SgdModel(), 46)
    model.add(sample([1.0] * 46, 1.0))
    assert model.weights[0] == pytest.approx(1.0638e-7, rel=1e-4)


def test_ridge_by_hand() -> None:
    # x = -1, 3 (mean 1, sd 2), y = -1, 1 (mean 0): z = -1, 1. Normal equation: (2 + l2) v_z = 2.
    # l2 = 2: v_z = 0.5, v = 0.5 / 2 = 0.25, intercept = 0 - 0.25 * 1.
    model = fitted(RidgeModel(l2=2.0, intercept="free"), [sample([-1], -1), sample([3], 1)])
    assert model.weights == pytest.approx([0.25])
    assert model.intercept == pytest.approx(-0.25)


def test_ridge_without_intercept_by_hand() -> None:
    # Sum of squares 1 + 9 = 10, root mean square sqrt 5; sum x y = 1 + 3 = 4.
    # (10/5 + l2) v_z = 4 / sqrt 5, l2 = 2: v_z = 1/sqrt 5, v = 1/5.
    model = fitted(RidgeModel(l2=2.0, intercept="none"), [sample([-1], -1), sample([3], 1)])
    assert model.weights == pytest.approx([0.2])
    assert model.intercept == 0.0


def test_ridge_with_penalised_intercept_by_hand() -> None:
    # Inputs (x, 1) with x = -1, 3: root mean squares sqrt 5 and 1. z = (-1, sqrt 5)/sqrt 5 and (3, sqrt
    # 5)/sqrt 5. Normal equations, l2 = 2: [[2 + 2, 2/sqrt 5], [2/sqrt 5, 2 + 2]] (v_z, b) = (4/sqrt 5, 0).
    # b = -v_z / (2 sqrt 5); v_z (4 - 1/5) = 4/sqrt 5: v_z = 20 / (19 sqrt 5); v = v_z / sqrt 5 = 4/19.
    # b = -20 / (19 * 2 * 5) = -2/19.
    model = fitted(RidgeModel(l2=2.0, intercept="penalised"), [sample([-1], -1), sample([3], 1)])
    assert model.weights == pytest.approx([4 / 19])
    assert model.intercept == pytest.approx(-2 / 19)


def test_blame_alone_turns_the_penalised_model_away_from_what_was_done() -> None:
    model = fitted(RidgeModel(), [sample([3, -1], -1), sample([5, -2], -1)])
    assert model.weights[0] < 0 < model.weights[1]
    assert model.predict(np.array([[3.0, -1.0]]))[0] < 0


def test_ridge_on_inputs_as_they_come_by_hand() -> None:
    # Centred x = -2, 2, y = -1, 1: (8 + l2) v = 4, l2 = 2: v = 0.4; intercept 0 - 0.4 * 1.
    model = fitted(
        RidgeModel(l2=2.0, intercept="free", standardise=False), [sample([-1], -1), sample([3], 1)]
    )
    assert model.weights == pytest.approx([0.4])
    assert model.intercept == pytest.approx(-0.4)


@pytest.mark.parametrize("n", [2, 5, 30, 200])
@pytest.mark.parametrize("l2", [0.01, 1.0, 50.0])
@pytest.mark.parametrize("kind", ["free", "penalised", "none"])
def test_ridge_agrees_with_least_squares_on_scaled_inputs(
    n: int, l2: float, kind: Literal["free", "penalised", "none"]
) -> None:
    samples = random_samples(n, 6, seed=n)
    model = fitted(RidgeModel(l2=l2, intercept=kind), samples)
    weights, intercept = naive.ridge(*columns(samples), l2, kind)
    assert model.weights == pytest.approx(weights, abs=1e-10)
    assert model.intercept == pytest.approx(intercept, abs=1e-10)


def test_gradient_descent_agrees_with_its_naive_twin() -> None:
    samples = random_samples(100, 5)
    model = fitted(SgdModel(step_size=0.003), samples)
    rows, labels, weights = columns(samples)
    expected, bias = naive.sgd(rows.tolist(), labels.tolist(), weights.tolist(), 0.003)
    assert model.weights == pytest.approx(expected, rel=1e-12)
    assert model.intercept == pytest.approx(bias, rel=1e-12)


def test_praise_alone_teaches_no_preference_where_the_intercept_is_free() -> None:
    model = fitted(RidgeModel(intercept="free"), [sample([3, 1], 1), sample([5, 2], 1), sample([4, 7], 1)])
    assert not model.knows_something
    assert model.intercept == 1.0


def test_a_model_without_samples_knows_nothing() -> None:
    for config in CONFIGS:
        model = HumanRewardModel(config, 3)
        assert not model.knows_something
        assert model.predict(np.ones((2, 3))).tolist() == [0.0, 0.0]


def test_an_input_that_never_varied_gets_no_weight() -> None:
    # 0.1 summed and divided is not 0.1 again; its variance must be exactly 0 all the same.
    samples = [sample([0.1, float(i % 3)], (-1.0) ** i, 0.3) for i in range(7)]
    assert fitted(RidgeModel(intercept="free"), samples).weights[0] == 0.0
    assert fitted(SgdModel(0.1, standardise=True), samples).weights[0] == 0.0


@pytest.mark.parametrize("config", CONFIGS)
def test_weights_do_not_depend_on_how_samples_are_batched(config: HumanModelConfig) -> None:
    samples = random_samples(40, 5)
    at_once = fitted(config, samples)
    one_by_one = HumanRewardModel(config, 5)
    for number, one in enumerate(samples):
        one_by_one.add(one)
        if number % 7 == 0:
            one_by_one.predict(one.features[None, :])  # looking at it changes nothing
    assert one_by_one.weights.tobytes() == at_once.weights.tobytes()
    assert one_by_one.state_bytes() == at_once.state_bytes()


@pytest.mark.parametrize("config", CONFIGS)
def test_a_model_without_one_press_equals_one_that_never_saw_it(config: HumanModelConfig) -> None:
    samples = random_samples(20, 4)
    model = fitted(config, samples)
    model.fit([one for one in samples if one.presses != (7,)])
    never = fitted(config, [*samples[:7], *samples[8:]])
    assert model.state_bytes() == never.state_bytes()
    assert model.state_bytes() != fitted(config, samples).state_bytes()


@given(
    st.lists(st.integers(1, 64), min_size=3, max_size=3), st.lists(st.integers(-9, 9), min_size=3, max_size=3)
)
def test_units_of_the_features_do_not_change_a_standardised_model(
    factors: list[int], shifts: list[int]
) -> None:
    """Predictions stay when every feature is measured in other units and from another zero."""
    samples = random_samples(25, 3)
    moved = [
        FeedbackSample(one.features * factors + shifts, one.label, one.weight, one.step, one.presses)
        for one in samples
    ]
    rows = np.array([one.features for one in samples])
    for config in (RidgeModel(l2=0.5, intercept="free"), SgdModel(0.05, standardise=True)):
        here = fitted(config, samples).predict(rows)
        there = fitted(config, moved).predict(rows * factors + shifts)
        assert there == pytest.approx(here, abs=1e-9)


@given(st.permutations(range(12)))
def test_ridge_does_not_depend_on_the_order_of_samples(order: list[int]) -> None:
    samples = random_samples(12, 3)
    here, there = fitted(RidgeModel(), samples), fitted(RidgeModel(), [samples[i] for i in order])
    assert there.weights == pytest.approx(here.weights, abs=1e-12)


def test_a_sample_of_weight_two_counts_as_two_samples() -> None:
    samples = random_samples(10, 3)
    twice = [*samples, samples[4]]
    heavy = list(samples)
    heavy[4] = FeedbackSample(samples[4].features, samples[4].label, 2 * samples[4].weight, 4, (4,))
    assert fitted(RidgeModel(), twice).weights == pytest.approx(
        fitted(RidgeModel(), heavy).weights, abs=1e-12
    )


def test_a_nearly_singular_fit_stays_finite() -> None:
    samples = [sample([1e6 + i, 1e6 + i, -i], (-1.0) ** i) for i in range(6)]
    model = fitted(RidgeModel(l2=1e-12), samples)
    assert np.isfinite(model.weights).all()


@pytest.mark.statistical
def test_ridge_finds_the_weights_behind_noisy_presses() -> None:
    rng = stream(3, "noisy")
    truth = np.array([1.0, -2.0, 0.0, 0.5])
    rows = rng.normal(size=(2000, 4))
    labels = rows @ truth + rng.normal(size=2000)
    samples = [FeedbackSample(row, float(label), 1.0, 0, ()) for row, label in zip(rows, labels, strict=True)]
    # Standard error of each weight is about 1/sqrt(2000) = 0.022; the penalty adds at most 2/2000.
    assert fitted(RidgeModel(), samples).weights == pytest.approx(truth, abs=4 / math.sqrt(2000) + 0.001)


@pytest.mark.parametrize("config", CONFIGS)
def test_the_configuration_survives_a_recordings_header(config: HumanModelConfig) -> None:
    assert msgspec.json.decode(msgspec.json.encode(config), type=HumanModelConfig) == config


def test_what_cannot_be_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="l2 is > 0"):
        RidgeModel(l2=0)
    with pytest.raises(ValueError, match="step_size is > 0"):
        SgdModel(step_size=-1)
    with pytest.raises(ValueError, match="at least one feature"):
        HumanRewardModel(RidgeModel(), 0)
    with pytest.raises(ValueError, match="expected 3 features"):
        HumanRewardModel(RidgeModel(), 3).add(sample([1, 2], 1))
