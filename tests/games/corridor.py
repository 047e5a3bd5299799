"""A third game, of tests alone: walk to the end of a slippery corridor. No file of the other two knows of it.

Each step costs 1, so performances are negative; a slip follows from the episode's seed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar

import msgspec
import numpy as np

from core.combination.config import AgentConfig
from core.configuration.fields import number
from core.domain import Choices, Domain, Features, Transition
from core.events import ActionRecord, EpisodeEnded, StepTaken
from core.feedback.keys import KeyConfig
from core.feedback.trainers import TrainerConfig
from core.feedback.viewing import SteadyViewing, Watched
from core.learners.encoding import ActionTiles
from core.learners.human_config import TileModel
from core.learners.sarsa_config import SarsaConfig
from core.numerics.clock import NS_PER_MS
from core.numerics.streams import stream
from core.numerics.tile_coding import Range, tile_coder
from core.plugins import DomainConfig, GamePlugin
from core.registry import Oracle
from core.session.effects import Use
from core.session.protocol import Protocol, SessionConfig
from core.session.sarsa_game import SarsaGame

MOVES = (-1, 1)


class CorridorConfig(msgspec.Struct, DomainConfig, frozen=True, forbid_unknown_fields=True, tag="corridor"):
    """A corridor."""

    cells: Annotated[int, number("cells", ge=2, le=100)] = 6
    """Length."""
    slip: Annotated[float, number(ge=0, lt=1)] = 0.2
    """Chance to stay where one is."""


class Move(ActionRecord, frozen=True):
    """A pace from a cell."""

    cell: int
    move: int


@dataclass(frozen=True, slots=True)
class Place:
    seed: int
    cell: int = 0
    steps: int = 0


class Corridor:
    """A `core.domain.Domain`."""

    name = "corridor"
    reward_is_time = False
    n_actors = 1
    n_actions = 2
    feature_names: tuple[str, ...] = ()
    observation_names = ("cell",)
    feedback_feature_names = ("cell",)

    def __init__(self, config: CorridorConfig) -> None:
        self.config = config
        self.coder = tile_coder((Range(0.0, float(config.cells), 1.0),), n_tilings=2)
        self._encoder = ActionTiles(self.coder, self.n_actions)
        self.feedback_tiles = self._encoder.tiling

    def initial(self, episode_seed: int) -> Place:
        return Place(episode_seed, int(stream(episode_seed, "start").integers(self.config.cells - 1)))

    def terminal(self, state: Place) -> bool:
        return state.cell == self.config.cells - 1

    def choices(self, state: Place) -> Choices:
        if self.terminal(state):
            raise ValueError("a terminal state has no actions")
        seen = np.array([float(state.cell)])
        return Choices(
            np.empty((2, 0)),
            self._encoder.rows(0, seen),
            np.zeros(2, np.bool_),
            time=state.steps,
            observation=seen,
        )

    def transition(self, state: Place, action: int) -> Transition[Place]:
        if action not in (0, 1):
            raise ValueError(f"there is no action {action}: this decision has actions 0..1")
        slips = stream(state.seed, "slip", state.steps).random() < self.config.slip
        cell = state.cell if slips else max(0, state.cell + MOVES[action])
        return Transition(Place(state.seed, cell, state.steps + 1), -1.0, 1)

    def performance(self, state: Place) -> float:
        return -float(state.steps)

    def time(self, state: Place) -> int:
        return state.steps

    def action_record(self, state: Place, action: int) -> Move:
        return Move(state.cell, MOVES[action])

    def recorded_state(self, state: Place) -> list[float] | None:
        return None


class CorridorGame(SarsaGame):
    """A `core.registry.Game`."""

    def domain(self, protocol: Protocol) -> Corridor:
        assert isinstance(protocol.domain, CorridorConfig)
        return Corridor(protocol.domain)

    def oracle(self, protocol: Protocol) -> Oracle:
        return lambda state: np.array([0.0, 1.0])

    def viewing(self, protocol: Protocol) -> SteadyViewing:
        return SteadyViewing(2 * protocol.screen.tick_ms * NS_PER_MS, 0)

    def steps_on_screen(self, protocol: Protocol) -> Sequence[Watched]:
        return [self.viewing(protocol).watched(None, 0, None)] * 100

    def recorded(self, domain: Domain[Any], step: StepTaken) -> tuple[Choices, Features]:
        raise AssertionError("its states are not recorded")

    def time_at_end(self, ended: EpisodeEnded) -> int:
        return ended.steps


class CorridorPlugin(GamePlugin):
    """What the program knows of the game."""

    name = "corridor"
    title = "Corridor"
    config = CorridorConfig
    action = Move
    revision = 7
    learners = (SarsaConfig,)
    human_models = (TileModel,)
    steps = "paces"
    idle: ClassVar[Mapping[str, str]] = {"screen.speed": ""}
    uses: ClassVar[tuple[Use, ...]] = (
        Use(("domain.slip",), "in long corridors only", lambda protocol, mode: protocol.domain.cells > 3),
    )

    @cache  # noqa: B019 - there is one instance
    def default(self) -> Protocol:
        return Protocol(
            domain=CorridorConfig(),
            learner=SarsaConfig(step_size=0.3),
            agent=AgentConfig(human_model=TileModel()),
            keys=KeyConfig(max_presses_per_episode=20),
            trainer=TrainerConfig(press_probability=0.6, max_presses=20),
            session=SessionConfig(episodes=4, unseen_between=2, watched_steps=30, unseen_steps=100),
        )

    def expected_game_s(self, protocol: Protocol) -> float:
        return 12.0

    def load(self) -> CorridorGame:
        return CorridorGame()

    def departures(self, protocol: Protocol) -> list[str]:
        return ["the paper has no corridor"]


PLUGIN = CorridorPlugin()
