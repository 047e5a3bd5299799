"""One trial in Tetris: a simulated participant watches every episode of a learner, and what came of it,
episode by episode.
"""

import numpy as np
from numpy.typing import NDArray

from core.feedback.trainers import SimulatedTrainer
from core.numerics.clock import NS_PER_MS
from core.session.protocol import Protocol
from core.session.session import build_agent
from core.tetris.oracle import TetrisOracle
from core.tetris.sessions import TICKS_PER_STEP, tetris_rules
from core.tetris.watched import WatchedTetris


def step_ns(protocol: Protocol) -> int:
    """Return how long a simulated step is on screen."""
    return TICKS_PER_STEP * protocol.screen.tick_ms * NS_PER_MS


def new_trial(protocol: Protocol, root_seed: int) -> WatchedTetris:
    """Return a trial that has not begun: everything in it follows from these two arguments."""
    return WatchedTetris(
        protocol,
        build_agent(protocol, root_seed),
        SimulatedTrainer(protocol.trainer, root_seed=root_seed),
        TetrisOracle(tetris_rules(protocol), protocol.trainer.knowledge),
        root_seed=root_seed,
        step_ns=step_ns(protocol),
    )


def run_trial(protocol: Protocol, root_seed: int) -> dict[str, NDArray[np.float64]]:
    """Play a trial of `protocol.session.episodes` episodes.

    Returns:
        Columns with one number per episode: lines, pieces, presses, w_h (the weight in use).
    """
    trial = new_trial(protocol, root_seed)
    episodes = [trial.play() for _ in range(protocol.session.episodes)]
    return {
        "lines": np.array([episode.performance for episode in episodes]),
        "pieces": np.array([float(episode.steps) for episode in episodes]),
        "presses": np.array([float(episode.presses) for episode in episodes]),
        "w_h": np.array([episode.weight for episode in episodes]),
    }
