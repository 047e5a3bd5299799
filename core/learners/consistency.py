"""Whether a participant's presses follow from what they are about: the test that random presses fail.

Each press is predicted from the presses before it, then learned from. If presses were random, however often
each key is pressed, no prediction made beforehand could be right more often than wrong: the sum of prediction
times surprise would be a martingale, and divided by the root of its quadratic variation about standard normal
at any time. (An adversary is as consistent as a good participant: which of the two a participant is, only the
environment can tell.)
"""

import math
import struct


class Consistency:
    """Running score of predictions against presses."""

    def __init__(self) -> None:
        self._weight = 0.0
        self._label_mean = 0.0
        self._prediction_mean = 0.0
        self._prediction_squares = 0.0
        self._drift = 0.0
        self._variation = 0.0

    @property
    def score(self) -> float:
        """Standard errors by which predictions did better than chance; 0 before the first that could be
        wrong.
        """
        return self._drift / math.sqrt(self._variation) if self._variation > 0 else 0.0

    def note(self, prediction: float, label: float, weight: float) -> None:
        """Take in a press.

        Prediction and press count against what was usual so far: a constant says nothing about any single
        press. A prediction counts in its own standard deviations, at most one: early ones are wild.

        Args:
            prediction: what the model expected, made before the press was known; any unit, any constant
                added.
            label: what it said.
            weight: how much it counts, > 0.
        """
        deviation = prediction - self._prediction_mean
        if self._prediction_squares > 0:
            spread = math.sqrt(self._prediction_squares / self._weight)
            gain = weight * min(max(deviation / spread, -1.0), 1.0) * (label - self._label_mean)
            self._drift += gain
            self._variation += gain * gain
        self._weight += weight
        self._prediction_mean += weight / self._weight * deviation
        self._prediction_squares += weight * deviation * (prediction - self._prediction_mean)
        self._label_mean += weight / self._weight * (label - self._label_mean)

    def state_bytes(self) -> bytes:
        """Return all that decides about later scores, for fingerprints."""
        return struct.pack(
            "<dddddd",
            self._weight,
            self._label_mean,
            self._prediction_mean,
            self._prediction_squares,
            self._drift,
            self._variation,
        )
