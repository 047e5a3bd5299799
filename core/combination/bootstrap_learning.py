"""Bootstrap learning: the top policies, their match to one participant's model, and how far it is trusted.

Section 3.1 of the paper; every decision it leaves open has a page in `docs/decisions`.
"""

import numpy as np
from numpy.typing import NDArray

from core.combination.config import BootstrapConfig
from core.combination.ranking import EpisodeReport, RankedPolicy, Ranking
from core.combination.trust.contract import Evidence, Window
from core.combination.trust.measures import pulls

__all__ = ["BootstrapLearning", "EpisodeReport", "RankedPolicy"]


class BootstrapLearning:
    """Keeps the top N policies and w_h, the weight of one participant."""

    def __init__(self, config: BootstrapConfig, window: Window | None, *, root_seed: int) -> None:
        """Begin without policies and without trust.

        Args:
            config: settings.
            window: recent decisions, as the caller fills it. None: none are kept.
            root_seed: of the session; the rule's random choices follow from it.

        Raises:
            ValueError: the rule of trust needs a window, and there is none.
        """
        if config.trust.needs.window and window is None:
            raise ValueError(
                f"no window of decisions is kept here: measure as played and give chance, got {config.trust}"
            )
        self.config = config
        self._window = window
        self._ranking = Ranking(config.top_policies)
        self._trust = config.trust.begin(root_seed=root_seed)

    @property
    def w_h(self) -> float:
        """Weight of the participant: 0 (if not fixed) until the human policy has been compared with some
        policy.
        """
        return self._trust.w_h

    @property
    def ranked(self) -> list[RankedPolicy]:
        """The top policies, best first; of equal ones the older first."""
        return list(self._ranking.policies)

    def record(self, report: EpisodeReport, human_weights: NDArray[np.float64] | None) -> None:
        """Take in an episode: ranks its policy and revises w_h.

        Args:
            report: the episode.
            human_weights: the human policy of now, shape (G,), or None while there is none.
        """
        self._ranking.add(report)
        self._trust.revise(report, self._evidence(human_weights))

    def matches(self, human_weights: NDArray[np.float64] | None) -> list[float | None]:
        """Return m_i of the ranked policies by the trust rule's own measure; None for one never compared."""
        return self._trust.matches(self._evidence(human_weights))

    def pulls(self, human_weights: NDArray[np.float64] | None) -> list[float]:
        """Return w_h m_i of each ranked policy; 0 where the symmetric update is off or the participant is not
        trusted.
        """
        if not self.config.symmetric or not self.w_h:
            return [0.0] * len(self._ranking.policies)
        return pulls(self.matches(human_weights), self.w_h)

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        return self._trust.state_bytes() + self._ranking.state_bytes()

    def _evidence(self, human_weights: NDArray[np.float64] | None) -> Evidence:
        return Evidence(self._ranking.policies, human_weights, self._window)
