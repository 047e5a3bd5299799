"""The contract between a domain and everything that learns in it.

A domain is a pure description: it holds no state, draws no hidden randomness and reads no clock. States are
immutable; every random outcome of an episode follows from the episode's seed. It describes a decision by a
row of features per action (Tetris: what each placement leaves behind) or by one observation of the state
(Keepaway).
"""

from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from core.events import ActionRecord

State = TypeVar("State")
Features = NDArray[np.float64] | NDArray[np.int64]
"""Rows of features psi(s, a): numbers, or first active tiles (`core.learners.encoding`)."""


@dataclass(frozen=True, slots=True)
class Transition(Generic[State]):
    """What one action led to."""

    next_state: State
    reward: float
    """Environmental reward of the step, of either sign (Tetris: lines cleared; Keepaway: seconds of
    possession)."""
    duration: int
    """How much of the domain's own time passed, >= 0 (Tetris: 1 piece; Keepaway: cycles, 0 where another
    keeper decides in the same cycle)."""


@dataclass(frozen=True, slots=True, eq=False)
class Choices:
    """What an agent sees when it has to choose among n actions (n >= 1)."""

    features: NDArray[np.float64]
    """phi(s, a) of a learner that compares rows, shape (n, n_features); (n, 0) where the domain describes the
    state alone (`observation`)."""
    feedback_features: Features
    """psi(s, a) of the human reward model, shape (n, n_feedback_features)."""
    ruled_out: NDArray[np.bool_]
    """Actions whose value is -inf whatever the weights (a placement that ends the game), shape (n,)."""
    actor: int = 0
    """Who decides, where several learn side by side (Keepaway: the keeper), >= 0."""
    time: int = 0
    """When, in the domain's own time since the episode began (`Domain.time`), >= 0."""
    observation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    """What the one who decides sees of the state, shape (v,); (0,) where the domain describes each action by
    a row. A learner encodes it itself (`core.learners.encoding`)."""

    def __post_init__(self) -> None:
        n_actions = len(self.features)
        if n_actions == 0:
            raise ValueError("a decision needs at least one action; a state without actions is terminal")
        if len(self.feedback_features) != n_actions or self.ruled_out.shape != (n_actions,):
            raise ValueError(
                f"need one row per action: {n_actions} rows of features, "
                f"{len(self.feedback_features)} of feedback features, ruled_out of shape "
                f"{self.ruled_out.shape}"
            )


class Domain(Protocol[State]):
    """A task with episodes: the one interface that rollouts, replays and contract tests know."""

    name: str

    @property
    def feature_names(self) -> tuple[str, ...]:
        """Names of the columns of `Choices.features`; none where it describes the state alone."""
        ...

    @property
    def observation_names(self) -> tuple[str, ...]:
        """Names of the numbers in `Choices.observation`; none where it describes each action by a row."""
        ...

    @property
    def feedback_feature_names(self) -> tuple[str, ...]:
        """Names of the columns of `Choices.feedback_features`."""
        ...

    def initial(self, episode_seed: int) -> State:
        """Return the first state of the episode with this seed (>= 0)."""
        ...

    def terminal(self, state: State) -> bool:
        """Return whether the episode has ended in `state`."""
        ...

    def choices(self, state: State) -> Choices:
        """Describe the actions of a state that is not terminal."""
        ...

    def transition(self, state: State, action: int) -> Transition[State]:
        """Return where `action`, an index into the rows of `choices(state)`, leads. `state` stays as it
        was.
        """
        ...

    def performance(self, state: State) -> float:
        """Return the performance measure pm of the episode up to `state`, finite; the more, the better.

        Tetris: lines cleared. Keepaway: seconds since the kick-off. A sum of rewards may be negative
        (`core.combination.trust.measures.as_weights` says what weighs by it then).
        """
        ...

    def time(self, state: State) -> int:
        """Return the domain's own time since the episode began (Tetris: pieces; Keepaway: cycles of 100
        ms).
        """
        ...

    def action_record(self, state: State, action: int) -> ActionRecord:
        """Return `action` in the game's words (Tetris: piece, orientation, column), for recordings."""
        ...

    def recorded_state(self, state: State) -> list[float] | None:
        """Return what recordings keep of `state`, so that `Game.recorded` can make its choices from it.

        None where the rules and the episode's seed are enough.
        """
        ...
