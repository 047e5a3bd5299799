"""Credit by a density of your own: here a log-normal one, as reaction times often are.

    python examples/own_credit.py

The program records a session, and lets an agent learn again from its presses, once under the paper's gamma density and
once under ours.
"""  # noqa: E501

import tempfile
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import lognorm

from core import CreditConfig, Protocol, SessionConfig, read_recording, relearn, watched_steps
from core.feedback.credit import HORIZON_MASS, DelayDensity, GammaDelay, credit
from studies.demo import simulate_session


class LogNormalDelay:
    """Log-normal density of the delay. `cdf` and `horizon_s` are all that credit asks for."""

    def __init__(self, median_s: float, sigma: float) -> None:
        self._law = lognorm(sigma, scale=median_s)

    @property
    def horizon_s(self) -> float:
        """Delay in seconds beyond which less than `HORIZON_MASS` is left."""
        return float(self._law.isf(HORIZON_MASS))

    def cdf(self, delay_s: ArrayLike) -> NDArray[np.float64]:
        """Return the probability of a delay of at most `delay_s` seconds."""
        return np.asarray(self._law.cdf(delay_s), dtype=np.float64)


def one_press(density: DelayDensity) -> NDArray[np.float64]:
    """Return how a press at 3 s is shared out among three steps of one second each."""
    starts_ns = np.array([0, 1, 2]) * 1_000_000_000
    return credit(3_000_000_000, starts_ns, starts_ns + 1_000_000_000, density).shares


def main() -> None:
    """Compare both densities."""
    densities = {"gamma(2.5, 0.3)": GammaDelay(), "log-normal": LogNormalDelay(median_s=1.0, sigma=0.5)}
    for name, density in densities.items():
        print(f"{name}: a press at 3 s gives three steps {np.round(one_press(density), 3)}")
    path = Path(tempfile.mkdtemp()) / "session.jsonl"
    protocol = Protocol(
        session=SessionConfig(episodes=3, unseen_between=20, watched_steps=20, unseen_steps=100)
    )
    simulate_session(protocol, root_seed=1, target=path, software={})
    recording = read_recording(path)
    for name, density in densities.items():
        changed = msgspec.structs.replace(protocol.agent, credit=CreditConfig(delay=density))
        other = msgspec.structs.replace(protocol, agent=changed)
        learned = relearn(recording, other, watched_steps(recording, other), root_seed=1)
        given = sum(sum(event.shares) for event in learned.credits)
        trust = ", ".join(f"{value:.2f}" for value in learned.trust)
        print(f"{name}: {len(learned.credits)} presses, {given:.2f} of them reach steps; trust {trust}")


if __name__ == "__main__":
    main()
