"""Mountain Car as Gymnasium's `MountainCar-v0` has it, number for number, without its overhead; and a teacher
who knows a good policy.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from core.domain import Choices, Domain, Features, Transition
from core.events import EpisodeEnded, StepTaken
from core.feedback.viewing import SteadyViewing, Watched
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.config import GymnasiumConfig
from core.interop.gymnasium.tiles import JointTiles
from core.learners.encoding import ActionTiles
from core.numerics.arrays import Floats
from core.numerics.clock import NS_PER_MS, NS_PER_S
from core.numerics.tile_coding import Range
from core.registry import Oracle
from core.session.protocol import Protocol
from core.session.sarsa_game import ObservedDomain, SarsaGame, Tiled

LEFT, NONE, RIGHT = range(3)
FORCE, GRAVITY = 0.001, 0.0025
LOWEST, HIGHEST, GOAL, FASTEST = -1.2, 0.6, 0.5, 0.07
LARGEST_SEED = 2**31


@dataclass(frozen=True, slots=True)
class CarState:
    """Where the car is, how fast, and for how long it has driven."""

    position: float
    velocity: float
    steps: int = 0

    @property
    def observation(self) -> Floats:
        """Position and velocity as Gymnasium rounds them: to 32 bits, shape (2,)."""
        return np.array([self.position, self.velocity], np.float32).astype(np.float64)


class MountainCar:
    """A `core.domain.Domain`: the reward is -1 a step until the car is at the flag."""

    name = "mountain-car"
    reward_is_time = False
    n_actors = 1
    n_actions = 3
    feature_names: tuple[str, ...] = ()
    observation_names = ("position", "velocity")

    def __init__(self, config: GymnasiumConfig) -> None:
        """Lay joint tiles over position and velocity.

        Raises:
            ValueError: the configuration is of something else.
        """
        if config.env != "MountainCar-v0" or not config.joint or config.phi or config.psi:
            raise ValueError(f"this is MountainCar-v0 with joint tiles, not {config}")
        ends = np.array([[LOWEST, HIGHEST], [-FASTEST, FASTEST]], np.float32).astype(float).tolist()
        ranges = tuple(Range(low, high, (high - low) / config.tiles) for low, high in ends)
        tiles = JointTiles(ranges, config.tilings)
        self.coder, self.tiled = tiles.coder, tiles.tiled
        self._encoder = ActionTiles(self.coder, self.n_actions)
        self.feedback_tiles = self._encoder.tiling
        self.feedback_feature_names = tuple(f"tile {i}" for i in range(config.tilings))

    def initial(self, episode_seed: int) -> CarState:
        """Return the start that Gymnasium draws with this seed: at rest, -0.6 <= position < -0.4."""
        seed = np.random.SeedSequence(episode_seed % LARGEST_SEED)
        return CarState(np.random.Generator(np.random.PCG64(seed)).uniform(low=-0.6, high=-0.4), 0.0)

    def terminal(self, state: CarState) -> bool:
        """Return whether the car is at the flag."""
        return state.position >= GOAL and state.velocity >= 0.0

    def choices(self, state: CarState) -> Choices:
        """Return what is seen, and the tiles of each action for the human model."""
        if self.terminal(state):
            raise ValueError("the car is at the flag: a terminal state has no actions")
        observation = state.observation
        return Choices(
            features=np.empty((self.n_actions, 0)),
            feedback_features=self._encoder.rows(0, self.tiled(observation)),
            ruled_out=np.zeros(self.n_actions, np.bool_),
            time=state.steps,
            observation=observation,
        )

    def transition(self, state: CarState, action: int) -> Transition[CarState]:
        """Return where the car is after a step (Moore 1990; Sutton & Barto 2018, example 10.1)."""
        if not 0 <= action < self.n_actions:
            raise ValueError(
                f"there is no action {action}: this decision has actions 0..{self.n_actions - 1}"
            )
        velocity = state.velocity + ((action - 1) * FORCE + math.cos(3 * state.position) * -GRAVITY)
        velocity = min(max(velocity, -FASTEST), FASTEST)
        position = min(max(state.position + velocity, LOWEST), HIGHEST)
        if position == LOWEST and velocity < 0:
            velocity = 0.0
        return Transition(CarState(position, velocity, state.steps + 1), -1.0, 1)

    def performance(self, state: CarState) -> float:
        """Return the sum of rewards: minus the number of steps."""
        return -float(state.steps)

    def time(self, state: CarState) -> int:
        """Return the number of steps."""
        return state.steps

    def action_record(self, state: CarState, action: int) -> EnvAction:
        """Return the action's number, and that of the step."""
        return EnvAction(action, state.steps)

    def recorded_state(self, state: CarState) -> list[float] | None:
        """Return position and velocity."""
        return [float(value) for value in state.observation]


def teacher(state: CarState) -> Floats:
    """Return values of left, none, right by a teacher who knows that pushing along with the motion leads up.

    At rest, right. This policy needs 124 steps on average; the best there is, about 104.
    """
    towards = 1.0 if state.velocity >= 0 else -1.0
    return np.array([-towards, 0.0, towards])


class MountainCarGame(SarsaGame):
    """The game for sessions in which the teacher watches."""

    def domain(self, protocol: Protocol) -> MountainCar:
        """Return the task."""
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        return MountainCar(protocol.domain)

    def tiled(self, domain: ObservedDomain) -> Tiled | None:
        """Return what lays tiles over position and velocity together."""
        assert isinstance(domain, MountainCar), "the domain of this game"
        return domain.tiled

    def oracle(self, protocol: Protocol) -> Oracle:
        """Return the teacher."""
        return teacher

    def viewing(self, protocol: Protocol) -> SteadyViewing:
        """Return one tick for each step, judged from its beginning, as sessions of Gymnasium have it."""
        pause_ns = round(protocol.screen.pause_between_episodes_s * NS_PER_S)
        return SteadyViewing(protocol.screen.tick_ms * NS_PER_MS, pause_ns, judged_after_ns=0)

    def steps_on_screen(self, protocol: Protocol) -> Sequence[Watched]:
        """Return a hundred steps of one tick each."""
        return [Watched(protocol.screen.tick_ms * NS_PER_MS, judged_after_ns=0)] * 100

    def recorded(self, domain: Domain[Any], step: StepTaken) -> tuple[Choices, Features]:
        """Refuse: trials are not recorded."""
        raise NotImplementedError("trials of Mountain Car are not recorded")

    def time_at_end(self, ended: EpisodeEnded) -> int:
        """Return steps."""
        return ended.steps
