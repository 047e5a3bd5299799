"""Random presses cannot be foreseen, however many there are; presses with a reason can."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.feedback.samples import FeedbackSample
from core.learners.consistency import Consistency
from core.learners.human_reward import HumanRewardModel, RidgeModel
from core.numerics.streams import stream


def score(presses: list[tuple[float, float, float]]) -> float:
    consistency = Consistency()
    for prediction, label, weight in presses:
        consistency.note(prediction, label, weight)
    return consistency.score


def foreseen(labels: np.ndarray, features: np.ndarray) -> Consistency:
    """Let a model foresee each press, then learn from it."""
    model = HumanRewardModel(RidgeModel(), features.shape[1])
    consistency = Consistency()
    for step, (x, label) in enumerate(zip(features, labels, strict=True)):
        consistency.note(float(model.weights @ x), float(label), 1.0)
        model.add(FeedbackSample(x, float(label), 1.0, step, (step,)))
    return consistency


def test_three_presses_by_hand():
    # 1: nothing usual yet. 2: 3 - 1 = 2, but no spread yet. 3: usual 2 (sd 1) and 0: (2.5 - 2) / 1 * (1 - 0).
    # 4: predictions 1, 3, 2.5: mean 13/6, squared deviations 13/6; usual label 1/3; told far above, so 1.
    third = 0.5 * 1.0
    fourth = 1.0 * (-1.0 - 1.0 / 3.0)
    found = score([(1.0, 1.0, 1.0), (3.0, -1.0, 1.0), (2.5, 1.0, 1.0), (9.0, -1.0, 1.0)])
    assert found == pytest.approx((third + fourth) / math.hypot(third, fourth))


def test_nothing_is_known_before_a_prediction_could_be_wrong():
    assert Consistency().score == 0.0
    assert score([(1.0, 1.0, 1.0)]) == 0.0
    assert score([(0.0, 1.0, 1.0), (0.0, -1.0, 1.0), (0.0, 1.0, 1.0)]) == 0.0


@given(
    st.lists(
        st.tuples(st.integers(-8, 8), st.sampled_from([-1.0, 1.0]), st.sampled_from([0.5, 1.0])),
        min_size=3,
        max_size=20,
    ),
    st.sampled_from([0.25, 2.0, 64.0]),
    st.integers(-16, 16),
)
def test_neither_unit_nor_zero_of_predictions_matters(presses, unit, zero):
    moved = [(unit * p + zero, label, weight) for p, label, weight in presses]
    assert score(moved) == pytest.approx(score([(float(p), *rest) for p, *rest in presses]), abs=1e-9)


@pytest.mark.statistical
@pytest.mark.jit
def test_random_presses_score_as_a_standard_normal_number_whatever_is_pressed_more():
    scores = []
    for k in range(150):
        rng = stream(11, "random presses", k)
        features = rng.normal(size=(120, 4)) + 3.0
        labels = np.where(rng.random(120) < 0.25, 1.0, -1.0)
        scores.append(foreseen(labels, features).score)
    # standard errors: 1 / sqrt(150) = 0.082 of the mean, sqrt(2 / 150) = 0.115 of the variance; allow 4 of
    # them
    assert np.mean(scores) == pytest.approx(0.0, abs=0.33)
    assert np.var(scores) == pytest.approx(1.0, abs=0.46)


@pytest.mark.jit
def test_a_participant_and_their_adversary_are_equally_consistent():
    rng = stream(12, "presses")
    features = rng.normal(size=(200, 4))
    labels = np.sign(features @ np.array([1.0, -1.0, 0.5, 0.0]) + rng.normal(size=200))
    assert foreseen(labels, features).score > 5
    assert foreseen(-labels, features).score == pytest.approx(foreseen(labels, features).score)


def test_what_decides_about_later_scores_is_in_the_fingerprint():
    one, other = Consistency(), Consistency()
    for consistency in (one, other):
        consistency.note(1.0, 1.0, 1.0)
    assert one.state_bytes() == other.state_bytes()
    other.note(2.0, 1.0, 1.0)
    assert one.state_bytes() != other.state_bytes()
