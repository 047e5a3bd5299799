"""A match of Keepaway in which a participant decides for whichever keeper has the ball, by the agent's
options.
"""

from collections import deque

import msgspec
import numpy as np

from core.keepaway.decisions import DecisionPlay
from core.keepaway.frame_maker import FrameMaker
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import NO_PLAYER, ONGOING, KeepawayConfig
from core.keepaway.simulator.match import HOLD_BALL, Match
from core.numerics.streams import stream_seed


class KeeperPractice:
    """Plays cycle by cycle; a keeper holds the ball until a pass is wished for.

    Each game is an episode as in a session. A wish is kept until the next decision, and used up by it: so it
    may be made while the ball is on its way.
    """

    def __init__(self, config: KeepawayConfig, root_seed: int) -> None:
        """Set up the first game.

        Args:
            config: size of the game, and what players see.
            root_seed: of all games, >= 0.
        """
        self.config = config
        self._root_seed = root_seed
        self._games = 0
        self._wish = NO_PLAYER
        self.frame: PitchFrame = self.next_episode()
        """The newest picture."""

    def next_episode(self) -> PitchFrame:
        """Set up the next game; return its first picture."""
        self._games += 1
        self._wish = NO_PLAYER
        self._play = DecisionPlay(self.config, stream_seed(self._root_seed, "practice", self._games))
        self._maker = FrameMaker(self.config)
        self._coming: deque[PitchFrame] = deque()
        self.frame = self._look(self._play.match)
        self._play.begin(self._note)
        return self.frame

    def pass_to(self, keeper: int) -> None:
        """Wish for a pass to this keeper, from 0; to the one who has the ball, that it holds it.

        Raises:
            ValueError: there is no such keeper.
        """
        if not 0 <= keeper < self.config.n_keepers:
            raise ValueError(f"keepers are 0 to {self.config.n_keepers - 1}, got {keeper}")
        self._wish = keeper

    def step(self) -> PitchFrame:
        """Play one cycle, or set up the next game where this one has ended; return the picture."""
        if self.frame.ended != ONGOING:
            return self.next_episode()
        while not self._coming and self._play.keeper != NO_PLAYER:
            self._play.decide(self._action(), self._note)
        if self._coming:
            self.frame = self._coming.popleft()
        return self.frame

    def values(self) -> tuple[tuple[str, float], ...]:
        """Return nothing: no policy plays."""
        return ()

    def _action(self) -> int:
        """Return the option that is wished for, in the numbers of the keeper who decides."""
        wish, self._wish = self._wish, NO_PLAYER
        if wish in (NO_PLAYER, self._play.keeper):
            return HOLD_BALL
        order = self._play.match.order[self._play.keeper]
        return int(np.flatnonzero(order == wish)[0])

    def _note(self, match: Match) -> None:
        self._coming.append(self._look(match))

    def _look(self, match: Match) -> PitchFrame:
        return msgspec.structs.replace(self._maker.look(match), episode=self._games)
