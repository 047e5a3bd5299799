"""The human reward model over tiles."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.feedback.samples import FeedbackSample
from core.learners.human_config import RidgeModel, SgdModel, TileModel
from core.learners.human_reward import HumanRewardModel
from core.learners.human_tiles import HumanTileModel, human_model
from core.numerics.streams import stream
from core.numerics.tile_coding import Tiling, from_runs, row_values, runs

TILING = Tiling(n_weights=60, n_tilings=4)


def sample(windows, label: float, weight: float = 1.0) -> FeedbackSample:
    return FeedbackSample(np.array(windows, np.float64), label, weight, 0, (0,))


def test_a_sample_takes_out_a_share_of_its_error():
    model = HumanTileModel(TileModel(step_size=0.5), TILING)
    row = np.array([[0.0, 20.0, 56.0]])
    model.add(sample([0, 20, 56], 1.0))
    # The error is 1; half of it is spread over 12 active tiles.
    assert model.predict(row)[0] == pytest.approx(0.5)
    assert model.weights[[0, 3, 20, 59]] == pytest.approx(0.5 / 12)
    assert not model.weights[[4, 19, 24, 55]].any()
    model.add(sample([0, 20, 56], -1.0, weight=0.5))
    # The error is -1.5, a sample of half weight takes out a quarter: 0.5 - 0.375.
    assert model.predict(row)[0] == pytest.approx(0.125)


def test_states_that_share_tiles_share_what_was_said():
    model = HumanTileModel(TileModel(step_size=1.0), TILING)
    model.add(sample([10], 1.0))
    values = model.predict(np.array([[10.0], [11.0], [12.0], [14.0]]))
    assert values == pytest.approx([1.0, 0.75, 0.5, 0.0])


@pytest.mark.parametrize("seed", range(5))
def test_it_is_gradient_descent_on_the_binary_features(seed):
    rng = stream(seed, "tiles")
    tiles = HumanTileModel(TileModel(step_size=0.3), TILING)
    dense = HumanRewardModel(SgdModel(step_size=0.3 / 8, intercept=False), TILING.n_weights)
    for _ in range(50):
        windows = rng.integers(0, 57, size=2)
        features = np.zeros(TILING.n_weights)
        for first in windows:
            features[first : first + 4] += 1.0
        if features.max() > 1:  # tiles of different variables never coincide
            continue
        label, weight = float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.1, 1.0))
        tiles.add(sample(windows, label, weight))
        dense.add(FeedbackSample(features, label, weight, 0, (0,)))
    np.testing.assert_allclose(tiles.weights, dense.weights, atol=1e-14)
    assert tiles.weights.any()


def test_the_weights_given_out_stay_as_they_were():
    model = HumanTileModel(TileModel(), TILING)
    before = model.weights
    model.add(sample([1], 1.0))
    assert not before.any()
    assert model.weights.any()
    with pytest.raises(ValueError, match="read-only"):
        model.weights[0] = 1.0


def test_a_model_fits_its_domain():
    assert isinstance(human_model(TileModel(), 2, TILING), HumanTileModel)
    assert isinstance(human_model(RidgeModel(), 2, None), HumanRewardModel)
    with pytest.raises(ValueError, match="tile-coded domain"):
        human_model(TileModel(), 2, None)
    with pytest.raises(ValueError, match="of type tiles"):
        human_model(RidgeModel(), 2, TILING)
    with pytest.raises(ValueError, match=r"window is 0\.\.56"):
        HumanTileModel(TileModel(), TILING).add(sample([57], 1.0))
    with pytest.raises(ValueError, match="step_size is a fraction"):
        TileModel(step_size=0.0)


@given(st.lists(st.sampled_from([0.0, 0.0, 1.5, -2.0, 1e-300]), min_size=1, max_size=40))
def test_runs_say_the_same_in_fewer_numbers(numbers):
    weights = np.array(numbers)
    starts, values = runs(weights)
    np.testing.assert_array_equal(from_runs(starts, values, len(weights)), weights)
    assert len(starts) == 1 + sum(a != b for a, b in itertools.pairwise(numbers))


def test_rows_of_windows_have_the_values_of_their_tiles():
    weights = np.arange(60.0)
    assert row_values(np.array([[0, 10], [56, 1]]), weights, 4).tolist() == [
        0 + 1 + 2 + 3 + 10 + 11 + 12 + 13,
        56 + 57 + 58 + 59 + 1 + 2 + 3 + 4,
    ]
