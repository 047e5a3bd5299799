"""Whole episodes in compiled code: benchmark policies, and keepers that learn or act by Sarsa.

The cycles are those of `core.keepaway.simulator.game`: for the same seeds a live loop plays the same
episodes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.keepaway.pitch import AUTOPLAY_CYCLE_LIMIT, CYCLES_PER_S, OUT, KeepawayConfig, Rules
from core.keepaway.simulator.game import begin_cycle, finish_cycle, step_cycle
from core.keepaway.simulator.match import (
    CYCLE,
    END,
    Match,
    Streams,
    new_match,
    open_streams,
    start_episode,
)
from core.keepaway.simulator.policies import POLICIES
from core.keepaway.simulator.variables import state_variables
from core.learners.sarsa import Sarsa, decide, end_episode
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import inner_kernel, kernel
from core.numerics.tile_coding import Range, TileCoder, find_windows, tile_coder


@dataclass(frozen=True, slots=True, eq=False)
class Episodes:
    """Outcome of n episodes."""

    cycles: Ints
    """Duration of each episode in cycles, shape (n,)."""
    out: NDArray[np.bool_]
    """Whether the ball left the region (else a taker took it), shape (n,)."""

    def __post_init__(self) -> None:
        if self.cycles.shape != self.out.shape:
            raise ValueError(f"need one end per episode: {self.cycles.shape} cycles, {self.out.shape} ends")

    @property
    def duration_s(self) -> Floats:
        """Durations in seconds, shape (n,): the float nearest to each decimal, as read from a table."""
        return np.asarray(self.cycles / CYCLES_PER_S, np.float64)


def keepaway_tiles(config: KeepawayConfig, n_tilings: int = 32) -> TileCoder:
    """Return the published tile coding of a task's state variables."""
    variables = state_variables(config)
    return tile_coder(tuple(Range(v.low, v.high, v.tile_width) for v in variables), n_tilings)


@inner_kernel
def decide_all(match: Match, sarsa: Sarsa, windows: Ints, rng: np.random.Generator) -> None:
    """Let every deciding keeper choose by its learner; `windows` is scratch of shape (v,)."""
    for i in range(len(match.deciding)):
        if match.deciding[i]:
            find_windows(sarsa.coder, match.variables[i], windows)
            match.actions[i] = decide(sarsa, i, windows, match.status[CYCLE], rng)


@inner_kernel
def learn_cycle(match: Match, rules: Rules, sarsa: Sarsa, windows: Ints, streams: Streams) -> bool:
    """Play one cycle with keepers that learn; return whether the episode has ended."""
    if begin_cycle(match, rules, streams):
        decide_all(match, sarsa, windows, streams.policy)
    if finish_cycle(match, rules, streams):
        end_episode(sarsa, match.status[CYCLE])
        return True
    return False


@kernel
def _learn_episodes(
    match: Match, rules: Rules, sarsa: Sarsa, windows: Ints, streams: Streams, cycles: Ints, ends: Ints
) -> None:
    for e in range(len(cycles)):
        if match.status[CYCLE] > 0:
            start_episode(match, rules, streams.placement)
        while not learn_cycle(match, rules, sarsa, windows, streams):
            if match.status[CYCLE] >= AUTOPLAY_CYCLE_LIMIT:
                end_episode(sarsa, match.status[CYCLE])
                break
        cycles[e] = match.status[CYCLE]
        ends[e] = match.status[END]


@kernel
def _play_episodes(
    match: Match, rules: Rules, policy: int, streams: Streams, cycles: Ints, ends: Ints
) -> None:
    for e in range(len(cycles)):
        if match.status[CYCLE] > 0:
            start_episode(match, rules, streams.placement)
        while not step_cycle(match, rules, policy, streams) and match.status[CYCLE] < AUTOPLAY_CYCLE_LIMIT:
            pass
        cycles[e] = match.status[CYCLE]
        ends[e] = match.status[END]


class Autoplay:
    """A match that is played in whole episodes."""

    def __init__(self, config: KeepawayConfig, root_seed: int, *path: str | int) -> None:
        """Set up the match whose streams are named by `path`."""
        self.config = config
        self.rules = config.rules()
        self.streams = open_streams(root_seed, *path)
        self.match = new_match(config, self.streams)
        self._windows = np.zeros(self.match.variables.shape[1], np.int64)

    def play(self, policy: str, n_episodes: int) -> Episodes:
        """Play episodes with one of the benchmark policies ("random", "hold", "hand")."""
        if policy not in POLICIES:
            raise ValueError(f"no policy {policy!r}; there are {', '.join(POLICIES)}")
        cycles, ends = np.zeros(n_episodes, np.int64), np.zeros(n_episodes, np.int64)
        _play_episodes(self.match, self.rules, POLICIES[policy], self.streams, cycles, ends)
        return Episodes(cycles, ends == OUT)

    def learn(self, sarsa: Sarsa, n_episodes: int) -> Episodes:
        """Play episodes with keepers that act by `sarsa` and improve it (see
        `core.learners.sarsa.frozen`).
        """
        if sarsa.values.shape != (self.config.n_keepers, self.config.n_actions):
            raise ValueError(
                f"need {self.config.n_keepers} learners of {self.config.n_actions} actions, "
                f"got values of shape {sarsa.values.shape}"
            )
        cycles, ends = np.zeros(n_episodes, np.int64), np.zeros(n_episodes, np.int64)
        _learn_episodes(self.match, self.rules, sarsa, self._windows, self.streams, cycles, ends)
        return Episodes(cycles, ends == OUT)
