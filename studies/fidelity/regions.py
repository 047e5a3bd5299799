"""The table of other regions and numbers of Keepaway's page, and the speed of the simulator."""

import statistics
import time

import numpy as np

from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa import new_sarsa
from core.learners.sarsa_config import SarsaConfig
from studies.fidelity.keepaway_fidelity import Setting, play_durations

N_EPISODES = 300
ROOT_SEED = 11
POLICIES = ("random", "hold", "hand")
HEAD = ("task", *POLICIES)
TASKS = {
    "90": KeepawayConfig(view_angle_deg=90.0),
    "15m": KeepawayConfig(length_m=15.0, width_m=15.0),
    "25m": KeepawayConfig(length_m=25.0, width_m=25.0),
    "30m": KeepawayConfig(length_m=30.0, width_m=30.0),
    "90 25m": KeepawayConfig(length_m=25.0, width_m=25.0, view_angle_deg=90.0),
    "4v3 20": KeepawayConfig(4, 3),
    "4v3 30": KeepawayConfig(4, 3, 30.0, 30.0),
    "5v4 35": KeepawayConfig(5, 4, 35.0, 35.0),
    "exact 30m": KeepawayConfig(length_m=30.0, width_m=30.0, exact_state=True),
    "noquant": KeepawayConfig(quantise=False),
}
"""As the page calls them: view angle in degrees, side of the region in metres, keepers and takers, exact
state, numbers that are not rounded."""
SPEED_HEAD = ("play", "median (best) cycles per CPU second")
SPEED_EPISODES, SPEED_REPEATS, WARM_UP_EPISODES = 200, 5, 300
PLAYS = {
    "exact state": KeepawayConfig(exact_state=True),
    "beliefs, 360 degrees": KeepawayConfig(),
    "beliefs, 90 degrees": KeepawayConfig(view_angle_deg=90.0),
}


def region_row(task: str) -> tuple[str, ...]:
    """Return a task's row under HEAD: mean s +- its standard error, longest, fraction that ends outside."""
    cells = []
    for policy in POLICIES:
        played = play_durations(Setting(task, policy, TASKS[task], policy), N_EPISODES, ROOT_SEED)
        error = played.seconds.std(ddof=1) / np.sqrt(len(played.seconds))
        cells.append(
            f"{played.seconds.mean():.2f} +- {error:.2f}, longest {played.seconds.max():.0f}, "
            f"out {played.out.mean():.2f}"
        )
    return (task, *cells)


def speed_row(play: str) -> tuple[str, str]:
    """Return a row under SPEED_HEAD, measured now on this machine; learners included, 3v2, one core."""
    config = PLAYS[play]
    game = Autoplay(config, 1, "speed")
    sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(config), config.n_keepers, config.n_actions)
    game.learn(sarsa, WARM_UP_EPISODES)
    speeds = []
    for _ in range(SPEED_REPEATS):
        start = time.process_time()
        cycles = int(game.learn(sarsa, SPEED_EPISODES).cycles.sum())
        speeds.append(cycles / (time.process_time() - start))
    return play, f"{statistics.median(speeds):,.0f} ({max(speeds):,.0f})"
