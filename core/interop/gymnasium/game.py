"""A Gymnasium environment as a domain and a game: its states, its observation as numbers, tiles over them."""

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from core.domain import Choices, Domain, Features, Transition
from core.events import EpisodeEnded, StepTaken
from core.feedback.viewing import SteadyViewing, Watched
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.config import GymnasiumConfig, with_encoder
from core.interop.gymnasium.environments import (
    Numbers,
    Seen,
    check_size,
    discrete_actions,
    make_env,
    named_function,
)
from core.interop.gymnasium.states import Node, States
from core.interop.gymnasium.tiles import JointTiles
from core.learners.encoding import ActionTiles
from core.learners.sarsa_config import SarsaConfig
from core.numerics.arrays import Floats
from core.numerics.clock import NS_PER_MS, NS_PER_S
from core.numerics.tile_coding import Tiling, tile_coder
from core.plugins import GameError
from core.registry import Oracle
from core.session.protocol import Protocol
from core.session.sarsa_game import ObservedDomain, SarsaGame, Tiled, recorded_observation

CHECKED_STEPS = 20
"""Steps over which copies and seeds are compared before an environment is taken."""


@dataclass(frozen=True, slots=True)
class GymnasiumState:
    """A moment of an episode; two are equal if seed and actions were."""

    seed: int
    steps: int
    key: bytes
    """Digest of the actions so far."""
    node: Node = field(repr=False, compare=False)
    """The way to it, by which the environment finds it again."""
    observation: Numbers
    """As it is learned from and recorded: the observation's numbers, or those of phi."""
    given: Any = field(repr=False, compare=False)
    """The observation as the environment gave it."""
    total_reward: float
    over: bool


class GymnasiumDomain:
    """A `core.domain.Domain`; Gymnasium's own time limit is left out, the session has one."""

    name = "gymnasium"
    reward_is_time = False
    n_actors = 1
    feature_names: tuple[str, ...] = ()

    def __init__(self, config: GymnasiumConfig) -> None:
        """Make the environment and look at what it is.

        Raises:
            GameError: it cannot be made or seeded, or its spaces are none that can be learned.
        """
        self.config = config
        self.env = make_env(config.env)
        """The environment itself, for its spaces; it is not to be stepped."""
        self._first_action, self.n_actions = discrete_actions(self.env, config.env)
        self._check_names()
        self._seen = Seen(self.env, config)
        joint = JointTiles(self._seen.ranges, config.tilings) if self._is_joint(config) else None
        self.tiled = None if joint is None else joint.tiled
        n_tilings = 1 if self._seen.whole else config.tilings
        self.coder = tile_coder(self._seen.ranges, n_tilings) if joint is None else joint.coder
        check_size(self.coder.n_tiles, self.n_actions, config.env)
        self.observation_names = self._seen.names
        self._states = States(self.env, config.env)
        self._check()
        self._psi = named_function(config.psi) if config.psi else None
        self._encoder = ActionTiles(self.coder, self.n_actions)
        self.feedback_tiles: Tiling | None = None if self._psi else self._encoder.tiling
        self.feedback_feature_names = self._feedback_names()

    def _check_names(self) -> None:
        names = self.config.actions
        if names and (len(names), 0) != (self.n_actions, self._first_action):
            raise GameError(
                f"[domain] actions has {len(names)} names, for the actions from 0 on, and those of "
                f"{self.config.env} are {self._first_action} to {self._first_action + self.n_actions - 1}: "
                "name each of them, or none"
            )

    def _is_joint(self, config: GymnasiumConfig) -> bool:
        return config.joint and not self._seen.whole

    def initial(self, episode_seed: int) -> GymnasiumState:
        """Return the first state of the episode with this seed (>= 0)."""
        node, given = self._states.begin(episode_seed)
        return GymnasiumState(episode_seed, 0, b"", node, self._seen.numbers(given), given, 0.0, False)

    def terminal(self, state: GymnasiumState) -> bool:
        """Return whether the environment has said that the episode is over."""
        return state.over

    def choices(self, state: GymnasiumState) -> Choices:
        """Return what is seen, and what the human model sees of each action."""
        if state.over:
            raise ValueError("the episode is over: a terminal state has no actions")
        return self.choices_of(np.array(state.observation), state.steps)

    def choices_of(self, observation: Floats, time: int) -> Choices:
        """Return the choices on an observation as recorded, shape (v,), after so many steps."""
        numbers = observation if self.tiled is None else self.tiled(observation)
        return Choices(
            features=np.empty((self.n_actions, 0)),
            feedback_features=self._encoder.rows(0, numbers)
            if self._psi is None
            else self._psi_rows(observation),
            ruled_out=np.zeros(self.n_actions, np.bool_),
            time=time,
            observation=observation,
        )

    def transition(self, state: GymnasiumState, action: int) -> Transition[GymnasiumState]:
        """Return where an action leads; the reward is the environment's."""
        if not 0 <= action < self.n_actions:
            raise ValueError(
                f"there is no action {action}: this decision has actions 0..{self.n_actions - 1}"
            )
        given, reward, over = self._states.step(state.node, self._first_action + action)
        following = GymnasiumState(
            seed=state.seed,
            steps=state.steps + 1,
            key=hashlib.blake2b(state.key + action.to_bytes(4, "little"), digest_size=16).digest(),
            node=self._states.after(state.node, self._first_action + action),
            observation=self._seen.numbers(given),
            given=given,
            total_reward=self._total(state.total_reward, reward),
            over=over,
        )
        return Transition(following, reward, 1)

    def _total(self, before: float, reward: float) -> float:
        """Return the sum of rewards with one more.

        Raises:
            GameError: it is infinite, or no number.
        """
        total = before + reward
        if not math.isfinite(total):
            raise GameError(
                f"{self.config.env} gave the reward {reward} after rewards of {before} in all: their sum "
                "must be a finite number"
            )
        return total

    def performance(self, state: GymnasiumState) -> float:
        """Return the sum of rewards so far."""
        return state.total_reward

    def time(self, state: GymnasiumState) -> int:
        """Return the number of steps so far."""
        return state.steps

    def action_record(self, state: GymnasiumState, action: int) -> EnvAction:
        """Return the environment's own number of the action, and of the step in its episode."""
        return EnvAction(self._first_action + action, state.steps)

    def recorded_state(self, state: GymnasiumState) -> list[float] | None:
        """Return the observation: a recording can be learned from without the environment's version of
        then.
        """
        return list(state.observation)

    def _feedback_names(self) -> tuple[str, ...]:
        if self._psi is None:
            # The human model sees the first tile of each window: one for each number, or for each tiling.
            n = len(self.coder.low)
            return self.observation_names if n == len(self.observation_names) else _numbered("tile", n)
        n = self._psi_rows(np.array(self.initial(0).observation)).shape[1]
        return _numbered("psi", n)

    def _psi_rows(self, observation: Floats) -> Floats:
        """Return the user's features of each action, shape (n_actions, g)."""
        psi: Callable[..., Any] | None = self._psi
        assert psi is not None, "asked for where there is one"
        numbers = tuple(observation.tolist())
        try:
            rows = np.array([np.ravel(psi(numbers, action)) for action in range(self.n_actions)], np.float64)
        except Exception as error:
            raise GameError(f"psi failed: {type(error).__name__}: {error}, given {numbers}") from error
        if rows.shape[1] == 0 or not np.isfinite(rows).all():
            raise GameError(f"psi gave {rows.tolist()}: at least one number is expected, and finite ones")
        return rows

    def _check(self) -> None:
        """Refuse an environment that does not play the same again from the same seed and actions."""
        name = self.config.env
        rng = np.random.Generator(np.random.PCG64DXSM(0))
        actions = [int(action) for action in rng.integers(self.n_actions, size=CHECKED_STEPS)]
        once, again = (self._played(actions) for _ in range(2))
        if once != again:
            raise GameError(
                f"{name} cannot be seeded: the same seed and actions gave other observations or rewards. "
                "Draw all that is random from `self.np_random`, and keep all state in the environment"
            )

    def _played(self, actions: Sequence[int]) -> list[tuple[Numbers, float, bool]]:
        state = self.initial(0)
        found = [(state.observation, 0.0, state.over)]
        for action in actions:
            if state.over:
                break
            following = self.transition(state, action).next_state
            # The way back is checked as well: what another action would have led to.
            self.transition(state, (action + 1) % self.n_actions)
            state = following
            found.append((state.observation, state.total_reward, state.over))
        return found


def _numbered(word: str, n: int) -> tuple[str, ...]:
    return tuple(f"{word} {i}" for i in range(n))


class GymnasiumGame(SarsaGame):
    """The game whose rules come from another package."""

    def domain(self, protocol: Protocol) -> GymnasiumDomain:
        """Return the environment that the protocol names."""
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        assert isinstance(protocol.learner, SarsaConfig), "a protocol checks that its learner suits its game"
        return GymnasiumDomain(with_encoder(protocol.domain, protocol.learner.encoder))

    def tiled(self, domain: ObservedDomain) -> Tiled | None:
        """Return what lays tiles over several numbers, where the protocol asks for it."""
        assert isinstance(domain, GymnasiumDomain), "the domain of this game"
        return domain.tiled

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return an oracle that values each action by the reward of its step."""
        domain = self.domain(protocol)

        def rewards(state: GymnasiumState) -> Floats:
            return np.array([domain.transition(state, action).reward for action in range(domain.n_actions)])

        return rewards

    def viewing(self, protocol: Protocol) -> SteadyViewing:
        """Return one tick for each step, judged from its beginning: its picture shows what it led to."""
        screen = protocol.screen
        pause_ns = round(screen.pause_between_episodes_s * NS_PER_S)
        return SteadyViewing(screen.tick_ms * NS_PER_MS, pause_ns, judged_after_ns=0)

    def steps_on_screen(self, protocol: Protocol) -> Sequence[Watched]:
        """Return a hundred steps of one tick each, as `viewing` has them."""
        return [Watched(protocol.screen.tick_ms * NS_PER_MS, judged_after_ns=0)] * 100

    def recorded(self, domain: Domain[GymnasiumState], step: StepTaken) -> tuple[Choices, Features]:
        """Return a step as it was seen."""
        assert isinstance(domain, GymnasiumDomain), "the domain of this game"
        choices = domain.choices_of(recorded_observation(domain, step), EnvAction.of(step).time)
        return choices, choices.feedback_features[step.action]

    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return steps."""
        return ended.steps
