"""The human reward model H(s, a) = v . psi(s, a) + intercept, learned from presses."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from core.domain import Features
from core.feedback.samples import FeedbackSample
from core.learners.human_config import FeatureModelConfig, RidgeModel, SgdModel
from core.learners.linear import action_values, add_to_moments, gradient_step, solve_ridge, standardised
from core.numerics.finite import check_learned

__all__ = ["FeatureModelConfig", "HumanRewardModel", "RidgeModel", "SgdModel"]


class HumanRewardModel:
    """Learns from samples one by one. The same samples in the same order give the same bits, however
    batched.
    """

    def __init__(self, config: FeatureModelConfig, n_features: int) -> None:
        if n_features < 1:
            raise ValueError(f"a model needs at least one feature, got {n_features}")
        self.config = config
        self.n_features = n_features
        ridge = isinstance(config, RidgeModel)
        self._centred = not ridge or config.intercept == "free"
        self._constant_input = ridge and config.intercept == "penalised"
        self._export: NDArray[np.float64] | None = None
        self._reset()

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

    def add(self, sample: FeedbackSample) -> None:
        """Learn from one more sample.

        Raises:
            DivergedError: the model's numbers have overflowed.
        """
        if sample.features.shape != (self.n_features,):
            raise ValueError(
                f"step {sample.step}: expected {self.n_features} features, got shape {sample.features.shape}"
            )
        features = np.asarray(sample.features, np.float64)
        label, weight = float(sample.label), float(sample.weight)
        if isinstance(self.config, RidgeModel) or self.config.standardise:
            add_to_moments(
                np.append(features, 1.0) if self._constant_input else features,
                label,
                weight,
                self._centred,
                self._totals,
                self._means,
                self._scatter,
            )
        if isinstance(self.config, SgdModel):
            gradient_step(
                self._seen(features),
                label,
                weight,
                self.config.step_size,
                self.config.intercept,
                self._sgd_weights,
            )
        self._n_samples += 1
        self._export = None
        check_learned(
            # No sum of products overflows before the sums of squares on the diagonal.
            (self._means, np.diagonal(self._scatter), self._sgd_weights),
            f"The human model, with features up to {np.abs(features).max():g} of step {sample.step},",
        )

    def fit(self, samples: Iterable[FeedbackSample]) -> None:
        """Forget everything and learn from `samples` in order."""
        self._reset()
        for sample in samples:
            self.add(sample)

    def predict(self, rows: Features) -> NDArray[np.float64]:
        """Return H of each action, rows (n, G), shape (n,), in units of a press."""
        return action_values(np.ascontiguousarray(rows, dtype=np.float64), self.weights) + self.intercept

    def export(self) -> dict[str, list[float]]:
        """Return the weights by name, for a recording's last line."""
        return {"human": self.weights.tolist()}

    def state_bytes(self) -> bytes:
        """Return all that the model has learned, for fingerprints."""
        parts = (self._totals, self._means, self._scatter, self._sgd_weights)
        return self._n_samples.to_bytes(8, "little") + b"".join(part.tobytes() for part in parts)

    def _reset(self) -> None:
        n_moments = self.n_features + self._constant_input + 1
        self._n_samples = 0
        self._totals = np.zeros(1)
        self._means = np.zeros(n_moments)
        self._scatter = np.zeros((n_moments, n_moments))
        self._sgd_weights = np.zeros(self.n_features + 1)
        self._export = None

    def _seen(self, features: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the inputs of gradient descent."""
        if not self.config.standardise:
            return features
        return standardised(features, self._totals[0], self._means, self._scatter)

    def _exported(self) -> NDArray[np.float64]:
        """Return weights and, last, intercept in the features' own units, computed once per change."""
        if self._export is None:
            if isinstance(self.config, RidgeModel):
                self._export = self._exported_ridge(self.config)
            else:
                self._export = self._exported_sgd(self.config)
        return self._export

    def _exported_ridge(self, config: RidgeModel) -> NDArray[np.float64]:
        export = np.zeros(self.n_features + 1)
        solution = export if self._constant_input else export[:-1]
        solve_ridge(self._totals[0], self._scatter, config.l2, config.standardise, solution)
        return export if self._constant_input else self._with_intercept_moved(export, self._means[-1])

    def _exported_sgd(self, config: SgdModel) -> NDArray[np.float64]:
        export = self._sgd_weights.copy()
        if not config.standardise:
            return export
        variances = np.diag(self._scatter)[:-1]
        varied = variances > 0
        export[:-1][varied] /= np.sqrt(variances[varied] / self._totals[0])
        return self._with_intercept_moved(export, export[-1])

    def _with_intercept_moved(self, export: NDArray[np.float64], at_mean: float) -> NDArray[np.float64]:
        """Set the intercept so that H is `at_mean` at the mean input."""
        export[-1] = at_mean - action_values(self._means[None, :-1], export[:-1])[0]
        return export
