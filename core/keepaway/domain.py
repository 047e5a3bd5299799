"""Keepaway as sessions see it: a step is a decision of the keeper with the ball, and states are immutable.

An action is an option of the keeper whose turn it is: 0 holds the ball (for one cycle), k passes to the k-th
nearest keeper. What an agent sees are the keeper's state variables.
"""

import hashlib
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from core.domain import Choices, Transition
from core.keepaway.action import ChosenOption
from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.decisions import DecisionPlay, Saved
from core.keepaway.pitch import CYCLE_S, NO_PLAYER, KeepawayConfig
from core.keepaway.simulator.match import CYCLE, END, Match
from core.keepaway.simulator.variables import state_variables
from core.learners.encoding import ActionTiles

HOLD = 0
"""The action that holds the ball."""


@dataclass(frozen=True, slots=True, eq=False)
class KeepawayState:
    """A match that stands still: a keeper has to decide, or the episode is over. Two are equal if all of it
    is.
    """

    saved: Saved = field(repr=False)

    @property
    def cycle(self) -> int:
        """Cycles since the episode started."""
        return int(self.saved.match.status[CYCLE])

    @property
    def keeper(self) -> int:
        """Who has to decide; -1 when the episode is over."""
        return self.saved.keeper

    @property
    def ended(self) -> int:
        """ONGOING, OUT or TAKEN (`core.keepaway.pitch`)."""
        return int(self.saved.match.status[END])

    @property
    def match(self) -> Match:
        """The match; not to be written to."""
        return self.saved.match

    @property
    def variables(self) -> NDArray[np.float64]:
        """State variables as the deciding keeper sees them, shape (v,)."""
        seen: NDArray[np.float64] = self.saved.match.variables[self.keeper]
        return seen

    def fingerprint(self) -> str:
        """Return a digest of everything that decides about what follows, hex."""
        digest = hashlib.sha256()
        for array in self.saved.match:
            digest.update(array.tobytes())
        digest.update(repr((self.saved.streams, self.saved.keeper)).encode())
        return digest.hexdigest()[:16]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, KeepawayState) and self.fingerprint() == other.fingerprint()

    def __hash__(self) -> int:
        return hash(self.fingerprint())

    def __repr__(self) -> str:
        return (
            f"KeepawayState(cycle={self.cycle}, keeper={self.keeper}, ended={self.ended}, "
            f"{self.fingerprint()})"
        )


class Keepaway:
    """A `core.domain.Domain`. Each episode is a match of its own: everything random follows from its seed."""

    name = "keepaway"
    reward_is_time = True
    """Seconds of possession are the reward (section 3.3): Sarsa counts them in cycles."""

    def __init__(
        self, config: KeepawayConfig | None = None, *, n_tilings: int = 32, shared_feedback: bool = False
    ) -> None:
        """Take the rules; the paper's where `config` is None.

        Args:
            config: size of the game, and what players see.
            n_tilings: tilings per state variable.
            shared_feedback: one human reward model for all keepers, instead of one for each.
        """
        self.config = config if config is not None else KeepawayConfig()
        self.coder = keepaway_tiles(self.config, n_tilings)
        self._encoder = ActionTiles(
            self.coder, self.config.n_actions, 1 if shared_feedback else self.config.n_keepers
        )
        self.feedback_tiles = self._encoder.tiling
        """What the rows of `Choices.feedback_features` index: tiles by model, option and state variable."""
        self._names = tuple(variable.name for variable in state_variables(self.config))

    @property
    def n_actors(self) -> int:
        """Keepers: each learns for itself."""
        return self.config.n_keepers

    @property
    def n_actions(self) -> int:
        """Options of a keeper: hold, or pass to one of the others."""
        return self.config.n_actions

    @property
    def feature_names(self) -> tuple[str, ...]:
        """Return nothing: a learner sees the state variables."""
        return ()

    @property
    def observation_names(self) -> tuple[str, ...]:
        """Names of the state variables as the deciding keeper sees them."""
        return self._names

    @property
    def feedback_feature_names(self) -> tuple[str, ...]:
        """Names of the state variables, whose first active tiles the human reward model sees."""
        return self._names

    def initial(self, episode_seed: int) -> KeepawayState:
        """Return the first decision of an episode, or its end if there is none; `episode_seed` >= 0."""
        play = DecisionPlay(self.config, episode_seed)
        play.begin()
        return KeepawayState(play.save())

    def terminal(self, state: KeepawayState) -> bool:
        """Return whether the ball is out or taken (or kept for an hour)."""
        return state.keeper == NO_PLAYER

    def choices(self, state: KeepawayState) -> Choices:
        """Return what the deciding keeper sees, and the tiles of each option for the human model."""
        if state.keeper == NO_PLAYER:
            raise ValueError("the episode is over: a terminal state has no actions")
        return self.choices_of(state.keeper, state.variables, state.cycle)

    def choices_of(self, keeper: int, variables: NDArray[np.float64], cycle: int) -> Choices:
        """Return the choices of a keeper who sees these state variables, shape (v,), so many cycles after the
        kick-off.
        """
        n_options = self.config.n_actions
        return Choices(
            features=np.empty((n_options, 0)),
            feedback_features=self._encoder.rows(keeper, variables),
            ruled_out=np.zeros(n_options, np.bool_),
            actor=keeper,
            time=cycle,
            observation=variables,
        )

    def transition(self, state: KeepawayState, action: int) -> Transition[KeepawayState]:
        """Return the next decision, of whichever keeper, or the end; the reward is the seconds until then."""
        if not 0 <= action < self.config.n_actions:
            raise ValueError(
                f"there is no action {action}: this decision has actions 0..{self.config.n_actions - 1}"
            )
        play = DecisionPlay.resumed(self.config, state.saved)
        play.decide(action)
        following = KeepawayState(play.save())
        cycles = following.cycle - state.cycle
        return Transition(following, cycles * CYCLE_S, cycles)

    def performance(self, state: KeepawayState) -> float:
        """Return the seconds since the kick-off."""
        return state.cycle * CYCLE_S

    def time(self, state: KeepawayState) -> int:
        """Return the cycles since the kick-off."""
        return state.cycle

    def action_record(self, state: KeepawayState, action: int) -> ChosenOption:
        """Return who decides, when, and the keeper the ball is passed to (-1: it is held)."""
        target = int(state.match.order[state.keeper, action]) if action != HOLD else NO_PLAYER
        return ChosenOption(state.keeper, state.cycle, target)

    def recorded_state(self, state: KeepawayState) -> list[float] | None:
        """Return the state variables as the deciding keeper sees them."""
        return [float(value) for value in state.variables]
