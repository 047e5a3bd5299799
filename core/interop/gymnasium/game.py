"""A Gymnasium environment as a domain and a game: states are copies of the environment, tiles cover its
observation.
"""

import copy
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from core.domain import Choices, Domain, Features, Transition
from core.events import EpisodeEnded, StepTaken
from core.feedback.keys import NS_PER_MS
from core.feedback.viewing import SteadyViewing, Watched
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.config import GymnasiumConfig, with_encoder
from core.learners.encoding import ActionTiles
from core.learners.sarsa_config import SarsaConfig
from core.numerics.clock import NS_PER_S
from core.numerics.tile_coding import Range, TileCoder, tile_coder
from core.plugins import GameError
from core.registry import Oracle
from core.session.protocol import Protocol
from core.session.sarsa_game import SarsaGame, recorded_observation

try:
    import gymnasium
except ImportError as error:  # the extra is not installed
    raise GameError("Gymnasium is not installed: pip install 'arl-tui[gym]'") from error

MOST_NUMBERS = 64
"""Of an observation: more are an image, and tiles of single pixels say nothing."""
CHECKED_STEPS = 20
"""Steps over which copies and seeds are compared before an environment is taken."""
Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class GymnasiumState:
    """A moment of an episode; two are equal if seed and actions were."""

    seed: int
    steps: int
    key: bytes
    """Digest of the actions so far."""
    env: Any = field(repr=False, compare=False)
    """The environment in this state; only copies of it are stepped."""
    observation: tuple[float, ...]
    total_reward: float
    over: bool


class GymnasiumDomain:
    """A `core.domain.Domain`; the environment's own time limit is left out, the session has one."""

    name = "gymnasium"
    reward_is_time = False
    n_actors = 1
    feature_names: tuple[str, ...] = ()

    def __init__(self, config: GymnasiumConfig) -> None:
        """Make the environment and look at what it is.

        Raises:
            GameError: it cannot be made, seeded or copied, or its spaces are none that can be learned.
        """
        self.config = config
        self._env = make_env(config.env)
        self._first_action, self.n_actions = _actions(self._env, config.env)
        self._ranges = _ranges(self._env, config)
        discrete = isinstance(self._env.observation_space, gymnasium.spaces.Discrete)
        self.coder: TileCoder = tile_coder(self._ranges, 1 if discrete else config.tilings)
        self._encoder = ActionTiles(self.coder, self.n_actions)
        self.feedback_tiles = self._encoder.tiling
        self.observation_names = tuple(f"observation {i}" for i in range(len(self._ranges)))
        self.feedback_feature_names = self.observation_names
        self._check()

    def initial(self, episode_seed: int) -> GymnasiumState:
        """Return the first state of the episode with this seed (>= 0)."""
        env = copy.deepcopy(self._env)
        observation, _ = env.reset(seed=episode_seed % 2**31)
        return GymnasiumState(episode_seed, 0, b"", env, _numbers(observation), 0.0, False)

    def terminal(self, state: GymnasiumState) -> bool:
        """Return whether the environment has said that the episode is over."""
        return state.over

    def choices(self, state: GymnasiumState) -> Choices:
        """Return what is seen, and the tiles of each action for the human model."""
        if state.over:
            raise ValueError("the episode is over: a terminal state has no actions")
        return self.choices_of(np.array(state.observation), state.steps)

    def choices_of(self, observation: Floats, time: int) -> Choices:
        """Return the choices on an observation, shape (v,), after so many steps."""
        return Choices(
            features=np.empty((self.n_actions, 0)),
            feedback_features=self._encoder.rows(0, observation),
            ruled_out=np.zeros(self.n_actions, np.bool_),
            time=time,
            observation=observation,
        )

    def transition(self, state: GymnasiumState, action: int) -> Transition[GymnasiumState]:
        """Return where an action leads, in a copy of the environment; the reward is the environment's."""
        if not 0 <= action < self.n_actions:
            raise ValueError(
                f"there is no action {action}: this decision has actions 0..{self.n_actions - 1}"
            )
        env = copy.deepcopy(state.env)
        observation, reward, terminated, truncated, _ = env.step(self._first_action + action)
        following = GymnasiumState(
            seed=state.seed,
            steps=state.steps + 1,
            key=hashlib.blake2b(state.key + action.to_bytes(4, "little"), digest_size=16).digest(),
            env=env,
            observation=_numbers(observation),
            total_reward=state.total_reward + float(reward),
            over=bool(terminated or truncated),
        )
        return Transition(following, float(reward), 1)

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

    def _check(self) -> None:
        """Refuse an environment whose seeds or copies do not play the same again."""
        name = self.config.env
        rng = np.random.Generator(np.random.PCG64DXSM(0))
        actions = [int(action) for action in rng.integers(self.n_actions, size=CHECKED_STEPS)]
        try:
            once, again = (self._played(actions) for _ in range(2))
        except Exception as error:
            raise GameError(
                f"{name} cannot be copied, and every state of a session is a copy: {type(error).__name__}: "
                f"{error}. "
                "Keep handles (windows, files, sockets, threads) out of the environment, or give it "
                "__deepcopy__"
            ) from error
        if once != again:
            raise GameError(
                f"{name} cannot be seeded: the same seed and actions gave other observations or rewards. "
                "Draw all that is random from `self.np_random`, and keep all state in the environment"
            )

    def _played(self, actions: Sequence[int]) -> list[tuple[tuple[float, ...], float, bool]]:
        state = self.initial(0)
        found = [(state.observation, 0.0, state.over)]
        for action in actions:
            if state.over:
                break
            self.transition(state, (action + 1) % self.n_actions)  # must leave `state` as it was
            state = self.transition(state, action).next_state
            found.append((state.observation, state.total_reward, state.over))
        return found


class GymnasiumGame(SarsaGame):
    """The game whose rules come from another package."""

    def domain(self, protocol: Protocol) -> GymnasiumDomain:
        """Return the environment that the protocol names."""
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        assert isinstance(protocol.learner, SarsaConfig), "a protocol checks that its learner suits its game"
        return GymnasiumDomain(with_encoder(protocol.domain, protocol.learner.encoder))

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return whoever judges by the reward of the step."""
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


def make_env(name: str, **settings: Any) -> Any:
    """Return an environment by its id, or by `module:function`, without a time limit of its own.

    Raises:
        GameError: there is none, or it cannot be made.
    """
    try:
        if ":" in name and not name.rpartition("-v")[2].isdigit():
            module, _, function = name.partition(":")
            return getattr(import_module(module), function)(**settings)
        return gymnasium.make(name, max_episode_steps=-1, disable_env_checker=True, **settings)
    except Exception as error:
        raise GameError(
            f"the environment {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error


def _actions(env: Any, name: str) -> tuple[int, int]:
    """Return the first action's number and how many there are."""
    space = env.action_space
    if not isinstance(space, gymnasium.spaces.Discrete):
        raise GameError(
            f"{name} has the actions {space}: only discrete ones can be learned here. Wrap it so that it "
            f"offers some of them"
        )
    return int(space.start), int(space.n)


def _ranges(env: Any, config: GymnasiumConfig) -> tuple[Range, ...]:
    """Return the range of each number of an observation, and how wide its tiles are."""
    space = env.observation_space
    if isinstance(space, gymnasium.spaces.Discrete):
        return (Range(float(space.start), float(space.start + space.n), 1.0),)
    if not isinstance(space, gymnasium.spaces.Box) or int(np.prod(space.shape)) > MOST_NUMBERS:
        raise GameError(
            f"{config.env} has the observations {space}: a box of at most {MOST_NUMBERS} numbers or a "
            "discrete one can be tiled. Wrap it so that it gives features"
        )
    most = config.largest
    low = np.where(np.abs(space.low) > 1e6, -most, space.low).astype(float).ravel()
    high = np.where(np.abs(space.high) > 1e6, most, space.high).astype(float).ravel()
    return tuple(
        Range(below, above, (above - below) / config.tiles)
        if above > below
        else Range(below, below + 1.0, 1.0)
        for below, above in zip(low.tolist(), high.tolist(), strict=True)
    )


def _numbers(observation: Any) -> tuple[float, ...]:
    return tuple(float(number) for number in np.ravel(observation))
