"""The human reward model H(s, a) = v . psi(s, a) + intercept, learned from presses."""

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.feedback.samples import Sample
from core.learners.human_config import HumanModelConfig, RidgeModel, SgdModel
from core.learners.linear import action_values, add_to_moments, gradient_step, solve_ridge, standardised

__all__ = ["HumanModelConfig", "HumanRewardModel", "RidgeModel", "SgdModel"]


class HumanRewardModel:
    """Learns from samples one by one. The same samples in the same order give the same bits, however batched."""

    def __init__(self, config: HumanModelConfig, n_features: int) -> None:
        if n_features < 1:
            raise ValueError(f"a model needs at least one feature, got {n_features}")
        self.config = config
        self.n_features = n_features
        self._centred = config.intercept if isinstance(config, RidgeModel) else True
        self._export: NDArray[np.float64] | None = None
        self._reset()

    @property
    def n_samples(self) -> int:
        """How many samples the model has seen."""
        return self._n_samples

    @property
    def knows_something(self) -> bool:
        """Whether any weight differs from 0: otherwise all actions are alike to the model."""
        return bool(self._exported()[:-1].any())

    @property
    def weights(self) -> NDArray[np.float64]:
        """A copy of v, in the features' own units, shape (G,)."""
        return self._exported()[:-1].copy()

    @property
    def intercept(self) -> float:
        """The constant part of H; it is the same for all actions."""
        return float(self._exported()[-1])

    def add(self, sample: Sample) -> None:
        """Learn from one more sample."""
        if sample.features.shape != (self.n_features,):
            raise ValueError(
                f"step {sample.step}: expected {self.n_features} features, got shape {sample.features.shape}"
            )
        if isinstance(self.config, RidgeModel) or self.config.standardise:
            add_to_moments(
                sample.features,
                sample.label,
                sample.weight,
                self._centred,
                self._totals,
                self._means,
                self._scatter,
            )
        if isinstance(self.config, SgdModel):
            gradient_step(
                self._seen(sample.features),
                sample.label,
                sample.weight,
                self.config.step_size,
                self.config.intercept,
                self._sgd_weights,
            )
        self._n_samples += 1
        self._export = None

    def fit(self, samples: Iterable[Sample]) -> None:
        """Forget everything and learn from `samples` in order."""
        self._reset()
        for sample in samples:
            self.add(sample)

    def predict(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return H of each action, rows (n, G), shape (n,), in units of a press."""
        return action_values(np.ascontiguousarray(rows, dtype=np.float64), self.weights) + self.intercept

    def state_bytes(self) -> bytes:
        """Return all that the model has learned, for fingerprints."""
        parts = (self._totals, self._means, self._scatter, self._sgd_weights)
        return self._n_samples.to_bytes(8, "little") + b"".join(part.tobytes() for part in parts)

    def to_dict(self) -> dict[str, Any]:
        """Return the model as plain JSON types: weights for others, state to go on from."""
        return {
            "config": msgspec.to_builtins(self.config),
            "weights": self.weights.tolist(),
            "intercept": self.intercept,
            "n_samples": self._n_samples,
            "total_weight": float(self._totals[0]),
            "means": self._means.tolist(),
            "scatter": self._scatter.tolist(),
            "sgd_weights": self._sgd_weights.tolist(),
        }

    @classmethod
    def from_dict(cls, plain: Mapping[str, Any]) -> "HumanRewardModel":
        """Return the model that `to_dict` described; it goes on with the same bits."""
        try:
            model = cls(msgspec.convert(plain["config"], HumanModelConfig), len(plain["weights"]))
            model._n_samples = int(plain["n_samples"])
            model._totals[0] = plain["total_weight"]
            for name, array in (
                ("means", model._means),
                ("scatter", model._scatter),
                ("sgd_weights", model._sgd_weights),
            ):
                array[...] = np.array(plain[name], dtype=np.float64).reshape(array.shape)
        except KeyError as error:
            raise ValueError(f"a human reward model without the field {error}") from error
        return model

    def _reset(self) -> None:
        n = self.n_features
        self._n_samples = 0
        self._totals = np.zeros(1)
        self._means = np.zeros(n + 1)
        self._scatter = np.zeros((n + 1, n + 1))
        self._sgd_weights = np.zeros(n + 1)
        self._export = None

    def _seen(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the inputs of gradient descent."""
        if not self.config.standardise:
            return features
        return standardised(features, self._totals[0], self._means, self._scatter)

    def _exported(self) -> NDArray[np.float64]:
        """Return weights and, last, intercept in the features' own units, computed once per change."""
        if self._export is None:
            export = np.zeros(self.n_features + 1)
            weights = export[:-1]
            if isinstance(self.config, RidgeModel):
                solve_ridge(self._totals[0], self._scatter, self.config.l2, self.config.standardise, weights)
                export[-1] = self._means[-1]
            else:
                export[:] = self._sgd_weights
                if self.config.standardise:
                    variances = np.diag(self._scatter)[:-1]
                    varied = variances > 0
                    weights[~varied] = 0.0
                    weights[varied] /= np.sqrt(variances[varied] / self._totals[0])
            if isinstance(self.config, RidgeModel) or self.config.standardise:
                # H(mean) is the mean label: move the intercept from the mean input to 0.
                export[-1] -= action_values(self._means[None, :-1], weights)[0]
            self._export = export
        return self._export
