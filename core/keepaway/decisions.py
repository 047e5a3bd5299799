"""One episode of Keepaway from decision to decision: the match stands still where a keeper has to choose an
option.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from core.keepaway.pitch import NO_PLAYER, SESSION_CYCLE_LIMIT, KeepawayConfig, Rules
from core.keepaway.simulator.game import begin_cycle, finish_cycle
from core.keepaway.simulator.match import CYCLE, END, Match, Streams, new_match, open_streams
from core.numerics.compiled import kernel
from core.numerics.streams import resumed

# What `play_to_decision` comes back with.
DECIDING: Final = 0
OVER: Final = 1
FINISHED: Final = 2

OnCycle = Callable[[Match], None]
"""Looks at the match at the end of a cycle."""


@kernel
def play_to_decision(match: Match, rules: Rules, streams: Streams, most: int, decided: bool) -> int:
    """Finish cycles until a keeper has to decide.

    Args:
        match: in place.
        rules: size of the game.
        streams: of the match.
        most: finish at most this many cycles, >= 1.
        decided: the present cycle has begun and all deciding keepers have decided; False: it has yet to
            begin.

    Returns:
        DECIDING, OVER, or FINISHED after `most` cycles without either.
    """
    for _ in range(most):
        if not decided and begin_cycle(match, rules, streams):
            return DECIDING
        decided = False
        if finish_cycle(match, rules, streams) or match.status[CYCLE] >= SESSION_CYCLE_LIMIT:
            return OVER
    return FINISHED


@dataclass(frozen=True, slots=True, eq=False)
class Saved:
    """A match at a standstill, complete: arrays and random streams."""

    match: Match
    streams: tuple[dict[str, Any], ...]
    keeper: int


class DecisionPlay:
    """An episode that is played in place, one decision after the other.

    Where several keepers have to decide in the same cycle they do so one after the other, in the order of
    their numbers, and all options begin together.
    """

    def __init__(self, config: KeepawayConfig, episode_seed: int) -> None:
        """Set up the match of the episode with this seed (>= 0); `begin` plays it to the first decision."""
        self.rules = config.rules()
        self.streams = open_streams(episode_seed)
        self.match = new_match(config, self.streams)
        self.keeper = NO_PLAYER
        """Who has to decide; NO_PLAYER when the episode is over (and before `begin`)."""

    @classmethod
    def resumed(cls, config: KeepawayConfig, saved: Saved) -> "DecisionPlay":
        """Return an episode that goes on where `saved` stood, with arrays and streams of its own."""
        play = cls.__new__(cls)
        play.rules = config.rules()
        play.streams = Streams(*map(resumed, saved.streams))
        play.match = Match._make(array.copy() for array in saved.match)
        play.keeper = saved.keeper
        return play

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
        self._go_on(False, on_cycle)

    def decide(self, action: int, on_cycle: OnCycle | None = None) -> None:
        """Let the keeper whose turn it is choose an option; play to the next decision, or to the end.

        Args:
            action: 0 holds, k passes to the k-th nearest keeper.
            on_cycle: called at the end of each cycle that is played, in order.
        """
        if self.keeper == NO_PLAYER:
            raise ValueError("the episode is over: nobody has to decide")
        self.match.actions[self.keeper] = action
        later = np.flatnonzero(self.match.deciding[self.keeper + 1 :])
        if len(later):
            self.keeper += 1 + int(later[0])
        else:
            self._go_on(True, on_cycle)

    def save(self) -> Saved:
        """Return a copy of everything."""
        states = tuple(dict(rng.bit_generator.state) for rng in self.streams)
        return Saved(Match._make(array.copy() for array in self.match), states, self.keeper)

    def _go_on(self, decided: bool, on_cycle: OnCycle | None) -> None:
        most = 1 if on_cycle else SESSION_CYCLE_LIMIT
        outcome = FINISHED
        while outcome == FINISHED:
            before = self.cycle
            outcome = play_to_decision(self.match, self.rules, self.streams, most, decided)
            decided = False
            if on_cycle and self.cycle > before:
                on_cycle(self.match)
        self.keeper = int(np.flatnonzero(self.match.deciding)[0]) if outcome == DECIDING else NO_PLAYER
