"""The human reward model over tiles: H(s, o) is the sum of the weights of the active tiles, learned from
presses.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from core.domain import Features
from core.feedback.samples import FeedbackSample
from core.learners.human_config import HumanModelConfig, TileModel
from core.learners.human_reward import HumanRewardModel
from core.numerics.arrays import Floats
from core.numerics.compiled import inner_kernel
from core.numerics.tile_coding import Tiling, add_to_windows, row_values, runs


@inner_kernel
def move_tiles(
    windows: NDArray[np.int64], label: float, weight: float, step_size: float, weights: Floats, n_tilings: int
) -> None:
    """Take `step_size * weight` of the error label - H out of H, spread over the active tiles.

    Args:
        windows: first tile of each window, shape (v,).
        label: what the sample says.
        weight: how much it counts, in (0, 1].
        step_size: in (0, 1].
        weights: one per tile, changed in place.
        n_tilings: length of each window.
    """
    prediction = 0.0
    for v in range(len(windows)):
        for tile in range(windows[v], windows[v] + n_tilings):
            prediction += weights[tile]
    move = step_size / (len(windows) * n_tilings) * weight * (label - prediction)
    add_to_windows(weights, windows, n_tilings, move)


class HumanTileModel:
    """Learns from samples one by one; their features are the first tiles of the active windows."""

    def __init__(self, config: TileModel, tiling: Tiling) -> None:
        self.config = config
        self.tiling = tiling
        self._weights = np.zeros(tiling.n_weights)
        self._readable = self._weights.view()
        self._readable.flags.writeable = False  # as in `weights`: one type of array, so one compiled kernel
        self._n_samples = 0
        self._export: Floats | None = None

    @property
    def knows_something(self) -> bool:
        """Whether there has been a sample: otherwise all options are alike to the model."""
        return self._n_samples > 0

    @property
    def weights(self) -> Floats:
        """The weights of now, shape (n_weights,), read only; later samples do not change this array."""
        if self._export is None:
            self._export = self._weights.copy()
            self._export.flags.writeable = False
        return self._export

    def add(self, sample: FeedbackSample) -> None:
        """Learn from one more sample."""
        windows = sample.features.astype(np.int64)
        last = self.tiling.n_weights - self.tiling.n_tilings
        if windows.ndim != 1 or not (windows.min() >= 0 and windows.max() <= last):
            raise ValueError(
                f"step {sample.step}: the first tile of a window is 0..{last}, got {sample.features}"
            )
        label, weight = float(sample.label), float(sample.weight)
        move_tiles(windows, label, weight, self.config.step_size, self._weights, self.tiling.n_tilings)
        self._n_samples += 1
        self._export = None

    def fit(self, samples: Iterable[FeedbackSample]) -> None:
        """Forget everything and learn from `samples` in order."""
        self._weights[:] = 0.0
        self._n_samples = 0
        self._export = None
        for sample in samples:
            self.add(sample)

    def predict(self, rows: Features) -> Floats:
        """Return H of each row of window starts, (n, v) -> (n,), in units of a press."""
        return row_values(np.ascontiguousarray(rows, np.int64), self._readable, self.tiling.n_tilings)

    def state_bytes(self) -> bytes:
        """Return all that the model has learned, for fingerprints."""
        return self._n_samples.to_bytes(8, "little") + self._weights.tobytes()

    def export(self) -> dict[str, list[float]]:
        """Return the weights as runs of equal numbers (`core.numerics.tile_coding.runs`)."""
        starts, values = runs(self._weights)
        return {"human-starts": starts.tolist(), "human-values": values.tolist()}


def human_model(
    config: HumanModelConfig, n_features: int, tiles: Tiling | None
) -> HumanRewardModel | HumanTileModel:
    """Return a new model.

    Args:
        config: which one.
        n_features: length of psi(s, a).
        tiles: what psi(s, a) indexes where it lists active tiles; None for plain features.
    """
    if isinstance(config, TileModel):
        if tiles is None:
            raise ValueError("a human model of type tiles needs a tile-coded domain, such as Keepaway")
        return HumanTileModel(config, tiles)
    if tiles is not None:
        raise ValueError("the features of this domain are active tiles: its human model is of type tiles")
    return HumanRewardModel(config, n_features)
