"""The human model over tiles: the dense model's bits, from the active tiles alone."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.feedback.samples import FeedbackSample
from core.learners.human_config import SgdModel, TileModel
from core.learners.human_reward import HumanRewardModel
from core.learners.human_sets import human_values, learn_sample, new_human_set
from core.numerics.tile_coding import Range, find_windows, tile_coder

CODER = tile_coder((Range(0.0, 4.0, 1.0), Range(0.0, 90.0, 30.0)), n_tilings=4)
N_LEARNERS, N_OPTIONS = 2, 3
SAMPLES = st.lists(
    st.tuples(
        st.integers(0, N_LEARNERS - 1),
        st.integers(0, N_OPTIONS - 1),
        st.floats(0.0, 4.0),
        st.floats(0.0, 90.0),
        st.sampled_from([-1.0, 1.0]),
        st.floats(1e-6, 1.0),
    ),
    min_size=1,
    max_size=20,
)


def windows_of(*values):
    windows = np.zeros(len(values), np.int64)
    find_windows(CODER, np.array(values), windows)
    return windows


def heard(model, k, windows):
    out = np.zeros(N_OPTIONS)
    human_values(model, k, windows, out)
    return out


@given(SAMPLES, st.booleans())
@settings(max_examples=60)
def test_it_is_the_dense_model_on_binary_features(samples, shared):
    tiled = new_human_set(TileModel(step_size=0.3, shared=shared), CODER, N_LEARNERS, N_OPTIONS)
    dense = HumanRewardModel(SgdModel(step_size=0.3 / 8, intercept=False), tiled.weights.size)
    for k, option, x, angle, label, weight in samples:
        windows = windows_of(x, angle)
        psi = np.zeros_like(tiled.weights)
        for first in windows:
            psi[0 if shared else k, option, first : first + 4] = 1.0
        dense.add(FeedbackSample(psi.ravel(), label, weight, 0, (0,)))
        learn_sample(tiled, k, windows, option, label, weight)
    np.testing.assert_allclose(tiled.weights.ravel(), dense.weights, rtol=1e-12, atol=1e-15)
    rows = np.zeros((N_OPTIONS, *tiled.weights.shape))
    for o in range(N_OPTIONS):
        for first in windows:
            rows[o, 0 if shared else k, o, first : first + 4] = 1.0
    np.testing.assert_allclose(
        heard(tiled, k, windows), dense.predict(rows.reshape(N_OPTIONS, -1)), atol=1e-12
    )


def test_a_press_moves_one_option_by_the_step_size_of_the_error():
    model = new_human_set(TileModel(step_size=0.25), CODER, 1, N_OPTIONS)
    windows = windows_of(1.0, 45.0)
    learn_sample(model, 0, windows, 1, 1.0, 1.0)  # 0 + 0.25 * (1 - 0)
    assert heard(model, 0, windows).tolist() == [0.0, 0.25, 0.0]
    learn_sample(model, 0, windows, 1, -1.0, 0.5)  # 0.25 + 0.25 * 0.5 * (-1 - 0.25)
    assert heard(model, 0, windows) == pytest.approx([0.0, 0.09375, 0.0])


def test_keepers_learn_each_for_themselves_unless_they_share_a_model():
    windows = windows_of(1.0, 45.0)
    for shared in (False, True):
        model = new_human_set(TileModel(shared=shared), CODER, 2, N_OPTIONS)
        learn_sample(model, 0, windows, 2, 1.0, 1.0)
        assert heard(model, 1, windows).any() == shared
        assert model.samples[0] == 1


def test_a_state_half_as_alike_is_moved_half_as_much():
    model = new_human_set(TileModel(step_size=1.0), CODER, 1, N_OPTIONS)
    learn_sample(model, 0, windows_of(1.0, 45.0), 0, 1.0, 1.0)
    # The second variable is farther away than a tile: only the tiles of the first are shared.
    assert heard(model, 0, windows_of(1.0, 89.0))[0] == pytest.approx(0.5)
