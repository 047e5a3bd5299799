"""Cycles per CPU second on one core: `pytest -m benchmark_run tests/benchmarks/test_keepaway_speed.py -s -n
0`."""

import statistics
import time

import pytest

from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa import SarsaConfig, new_sarsa

REPEATS = 5
LEAST = 50_000
"""Below this the simulator is too slow for studies of many simulated hours."""


@pytest.mark.jit
@pytest.mark.benchmark_run
@pytest.mark.parametrize("exact_state", [True, False])
def test_learning_keepers_play_fast_enough(exact_state):
    config = KeepawayConfig(exact_state=exact_state)
    game = Autoplay(config, 1, "speed")
    sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(config), 3, 3)
    game.learn(sarsa, 300)
    speeds = []
    for _ in range(REPEATS):
        start = time.process_time()
        cycles = int(game.learn(sarsa, 200).cycles.sum())
        speeds.append(cycles / (time.process_time() - start))
    print(
        f"exact state {exact_state}: median {statistics.median(speeds):,.0f}, best {max(speeds):,.0f} "
        f"cycles/s"
    )
    assert statistics.median(speeds) > LEAST
