"""A match played cycle by cycle, one frame after each cycle.

The cycles, streams and choices are those of `core.keepaway.autoplay`: for the same seeds it plays the same
episodes.
"""

import numpy as np

from core.keepaway.autoplay import decide_all, keepaway_tiles
from core.keepaway.frame_maker import FrameMaker
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import NO_PLAYER, ONGOING, KeepawayConfig, Rules
from core.keepaway.simulator.game import begin_cycle, choose_all, finish_cycle, next_episode
from core.keepaway.simulator.match import CYCLE, Match, Streams, n_variables, new_match, open_streams
from core.keepaway.simulator.policies import POLICIES
from core.learners.sarsa import Sarsa, end_episode, frozen, new_sarsa
from core.learners.sarsa_config import SarsaConfig
from core.numerics.arrays import Ints
from core.numerics.compiled import kernel

Policy = str | Sarsa
"""Name of a benchmark policy ("random", "hold", "hand"), or learners that act and no longer learn."""


@kernel
def _play_cycle(
    match: Match, rules: Rules, policy: int, sarsa: Sarsa, windows: Ints, streams: Streams
) -> None:
    """Play one cycle with a benchmark policy, or with learners where `policy` is NO_PLAYER."""
    if begin_cycle(match, rules, streams):
        if policy == NO_PLAYER:
            decide_all(match, sarsa, windows, streams.policy)
        else:
            choose_all(match, rules, policy, streams.policy)
    if finish_cycle(match, rules, streams):
        end_episode(sarsa, match.status[CYCLE])


class ViewedMatch:
    """One policy plays, a cycle at a time."""

    def __init__(self, config: KeepawayConfig, policy: Policy, root_seed: int, *path: str | int) -> None:
        """Set up the first episode of the match whose streams are named by `path`.

        Raises:
            ValueError: there is no such policy, or the learners are those of another task.
        """
        if isinstance(policy, str) and policy not in POLICIES:
            raise ValueError(f"no policy {policy!r}; there are {', '.join(POLICIES)}")
        if not isinstance(policy, str):
            wanted = (config.n_keepers, n_variables(config.n_keepers, config.n_takers))
            if policy.windows.shape != wanted:
                raise ValueError(
                    f"{config.n_keepers} keepers against {config.n_takers} takers need {wanted[0]} learners "
                    f"of {wanted[1]} variables, got {policy.windows.shape[0]} of {policy.windows.shape[1]}"
                )
        self.config = config
        self._rules = config.rules()
        self._streams = open_streams(root_seed, *path)
        self._match = new_match(config, self._streams)
        self._benchmark = POLICIES[policy] if isinstance(policy, str) else NO_PLAYER
        # Learners that never decide keep the code in one piece.
        blank = new_sarsa(SarsaConfig(), keepaway_tiles(config), config.n_keepers, config.n_actions)
        self._sarsa = blank if isinstance(policy, str) else frozen(policy)
        self._windows = np.zeros(self._match.variables.shape[1], np.int64)
        self._frame_maker = FrameMaker(config)
        self.frame: PitchFrame = self._frame_maker.look(self._match)
        """The newest picture."""

    def step(self) -> PitchFrame:
        """Play one cycle, or set up the next episode where this one has ended; return the picture."""
        if self.frame.ended != ONGOING:
            return self.next_episode()
        _play_cycle(self._match, self._rules, self._benchmark, self._sarsa, self._windows, self._streams)
        self.frame = self._frame_maker.look(self._match)
        return self.frame

    def next_episode(self) -> PitchFrame:
        """Set up the next episode, whether or not this one has ended."""
        next_episode(self._match, self._rules, self._streams)
        end_episode(self._sarsa, 0)
        self.frame = self._frame_maker.look(self._match)
        return self.frame

    def values(self) -> tuple[tuple[str, float], ...]:
        """Return what the learner on screen thinks of each option: name and cycles still to come.

        Empty for benchmark policies and before the first decision.
        """
        keeper = self.frame.decider
        if self._benchmark != NO_PLAYER or keeper == NO_PLAYER:
            return ()
        order = self._match.order[keeper]
        names = ["Hold", *(self.frame.name(int(order[k])) for k in range(1, self.config.n_actions))]
        return tuple(zip(names, map(float, self._sarsa.values[keeper]), strict=True))
