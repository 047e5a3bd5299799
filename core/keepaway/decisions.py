"""One episode of Keepaway from decision to decision: the match stands still where a keeper has to choose an option."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from core.compiled import kernel
from core.keepaway.game import begin_cycle, finish_cycle
from core.keepaway.match import CYCLE, END, Match, Streams, new_match, open_streams
from core.keepaway.pitch import ONGOING, KeepawayConfig, Rules

NOBODY: Final = -1
CYCLE_LIMIT: Final = 36_000
"""Longest episode in cycles (an hour): a ball that is never lost would never end."""

OnCycle = Callable[[Match], None]
"""Looks at the match at the end of a cycle."""


@kernel
def next_decision(match: Match, rules: Rules, streams: Streams, limit: int, most: int) -> int:
    """Play on until a keeper has to decide; cycles in which nobody does are finished.

    Args:
        match: in place; either at the beginning of a cycle, or `match.deciding` is all False.
        rules: size of the game.
        streams: of the match.
        limit: the episode's longest duration in cycles.
        most: stop after this many cycles, too.

    Returns:
        1 if somebody has to decide, 0 if the episode is over, 2 if `most` cycles have been finished before either.
    """
    for _ in range(most):
        if begin_cycle(match, rules, streams):
            return 1
        if finish_cycle(match, rules, streams) or match.status[CYCLE] >= limit:
            return 0
    return 2


@kernel
def act_and_go_on(match: Match, rules: Rules, streams: Streams, limit: int, most: int) -> int:
    """Finish the cycle in which all deciding keepers have decided, then as `next_decision` (one cycle less)."""
    if finish_cycle(match, rules, streams) or match.status[CYCLE] >= limit:
        return 0
    if most == 1:
        return 2
    return next_decision(match, rules, streams, limit, most - 1)


@dataclass(frozen=True, slots=True, eq=False)
class Saved:
    """A match at a standstill, complete: arrays and random streams."""

    match: Match
    streams: tuple[dict[str, Any], ...]
    keeper: int


class DecisionPlay:
    """An episode that is played in place, one decision after the other.

    Where several keepers have to decide in the same cycle they do so one after the other, in the order of their
    numbers, and all options begin together.
    """

    def __init__(self, config: KeepawayConfig, episode_seed: int) -> None:
        """Set up the match of the episode with this seed (>= 0); `begin` plays it to the first decision."""
        self.rules = config.rules()
        self.streams = open_streams(episode_seed)
        self.match = new_match(config, self.streams)
        self.keeper = NOBODY
        """Who has to decide; NOBODY when the episode is over (and before `begin`)."""

    @property
    def cycle(self) -> int:
        """Cycles since the episode started."""
        return int(self.match.status[CYCLE])

    @property
    def ended(self) -> int:
        """ONGOING, OUT or TAKEN."""
        return int(self.match.status[END])

    @property
    def variables(self) -> NDArray[np.float64]:
        """State variables as the deciding keeper sees them, a copy, shape (v,)."""
        seen: NDArray[np.float64] = self.match.variables[max(self.keeper, 0)].copy()
        return seen

    def begin(self, on_cycle: OnCycle | None = None) -> None:
        """Play to the first decision, or to an end before it."""
        self._go_on(next_decision, on_cycle)

    def decide(self, action: int, on_cycle: OnCycle | None = None) -> None:
        """Let the keeper whose turn it is choose an option; play to the next decision, or to the end.

        Args:
            action: 0 holds, k passes to the k-th nearest keeper.
            on_cycle: called at the end of each cycle that is played, in order.
        """
        if self.keeper == NOBODY:
            raise ValueError("the episode is over: nobody has to decide")
        self.match.actions[self.keeper] = action
        later = np.flatnonzero(self.match.deciding[self.keeper + 1 :])
        if len(later):
            self.keeper += 1 + int(later[0])
        else:
            self._go_on(act_and_go_on, on_cycle)

    def save(self) -> Saved:
        """Return a copy of everything."""
        states = tuple(dict(rng.bit_generator.state) for rng in self.streams)
        return Saved(Match._make(array.copy() for array in self.match), states, self.keeper)

    def restore(self, saved: Saved) -> None:
        """Go back, or ahead, to where a match of the same size stood."""
        for array, before in zip(self.match, saved.match, strict=True):
            array[...] = before
        for rng, state in zip(self.streams, saved.streams, strict=True):
            rng.bit_generator.state = state
        self.keeper = saved.keeper

    def _go_on(
        self, play: Callable[[Match, Rules, Streams, int, int], int], on_cycle: OnCycle | None
    ) -> None:
        most = 1 if on_cycle else CYCLE_LIMIT
        before = self.cycle
        outcome = play(self.match, self.rules, self.streams, CYCLE_LIMIT, most)
        while True:
            if on_cycle and self.cycle > before:
                on_cycle(self.match)
            if outcome != 2:
                break
            before = self.cycle
            outcome = next_decision(self.match, self.rules, self.streams, CYCLE_LIMIT, most)
        self.keeper = int(np.flatnonzero(self.match.deciding)[0]) if outcome == 1 else NOBODY


def is_over(match: Match) -> bool:
    """Return whether the episode has ended or has reached its longest duration."""
    return bool(match.status[END] != ONGOING or match.status[CYCLE] >= CYCLE_LIMIT)
