"""Gymnasium environments as protocols know them (`core.plugins`). Neither Gymnasium nor compiled code is
imported.
"""

import re
from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar

import msgspec

from core.combination.config import AgentConfig
from core.configuration.messages import Path
from core.configuration.reading import Problem
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import CurrentStep
from core.interop.gymnasium import REVISION
from core.interop.gymnasium.action import EnvAction
from core.interop.gymnasium.config import GymnasiumConfig, with_encoder
from core.learners.encoder_config import TileEncoder
from core.learners.human_config import RidgeModel, SgdModel, TileModel
from core.learners.sarsa_config import SarsaConfig
from core.plugins import GameError, GamePlugin
from core.session.protocol import Protocol, ScreenConfig, SessionConfig

if TYPE_CHECKING:
    from core.interop.gymnasium.picture import EnvPicture
    from core.registry import Game


LONGEST_TASK = 60
"""Characters: the first page of a session has room for so many in the smallest window."""
LONGEST_ACTION = 18
"""Characters that have room beside the picture in the smallest window."""


class GymnasiumPlugin(GamePlugin):
    """Whatever `gymnasium.make` gives."""

    name = "gymnasium"
    title = "Gymnasium"
    config = GymnasiumConfig
    action = EnvAction
    revision = REVISION
    learners = (SarsaConfig,)
    human_models = (TileModel, RidgeModel, SgdModel)
    steps = "steps"
    foreign = True
    idle: ClassVar[Mapping[str, str]] = {
        "screen.speed": "",
        "session.watched": "Sarsa changes at every step, and no policy of it comes back",
    }

    @cache  # noqa: B019 - there is one instance
    def default(self) -> Protocol:
        """Return Sarsa on the pole, slow enough to judge: a press goes to the step on screen, whose picture
        shows at once what it led to (docs/decisions/pace-of-a-session.md).
        """
        return Protocol(
            domain=GymnasiumConfig(),
            learner=SarsaConfig(step_size=0.5, exploration=0.02, encoder=TileEncoder()),
            agent=AgentConfig(credit=CreditConfig(delay=CurrentStep()), human_model=TileModel()),
            trainer=TrainerConfig(knowledge="myopic"),
            session=SessionConfig(episodes=10, unseen_between=10, watched_steps=200, unseen_steps=500),
            screen=ScreenConfig(tick_ms=1000),
        )

    def default_of(self, variant: str) -> Protocol:
        """Return the default protocol with another environment: "gymnasium:MountainCar-v0", or
        "gymnasium:module:function".

        Raises:
            GameError: the name has no version.
        """
        domain = GymnasiumConfig(variant)
        for problem in _unclear(domain):
            raise GameError(f"{problem.reason}, got {variant!r}")
        return msgspec.structs.replace(self.default(), domain=domain)

    def view(self) -> "type[EnvPicture]":
        """Return the pictures."""
        from core.interop.gymnasium.picture import EnvPicture

        return EnvPicture

    def expected_game_s(self, protocol: Protocol) -> float:
        """Return the time of a game of all its steps: how long one lasts only the environment knows."""
        return protocol.session.watched_steps * protocol.screen.tick_ms / 1000

    def load(self) -> "Game":
        """Return the game.

        Raises:
            GameError: Gymnasium is not installed.
        """
        from core.interop.gymnasium.game import GymnasiumGame

        return GymnasiumGame()

    def check(self, protocol: Protocol) -> None:
        """Refuse different encodings in two places, and a human model that cannot learn from what it sees.

        Raises:
            ValueError: the places differ, or the model is of another type than features or tiles need.
        """
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        if isinstance(protocol.learner, SarsaConfig):
            with_encoder(protocol.domain, protocol.learner.encoder)
        tiles = isinstance(protocol.agent.human_model, TileModel)
        if protocol.domain.psi and tiles:
            raise ValueError(
                "psi gives features, and a human model of type tiles sees tiles: set [agent.human_model] "
                'type = "ridge"'
            )
        if not protocol.domain.psi and not tiles:
            raise ValueError(
                "without features the human model sees the learner's tiles: set [agent.human_model] type = "
                '"tiles", or name features ([domain] psi)'
            )

    def contradictions(self, protocol: Protocol) -> Iterator[Problem]:
        """Yield the simulated participants who would have to know the environment."""
        for number_of, trainer in enumerate((protocol.trainer, *protocol.others)):
            if trainer.knowledge != "myopic":
                where: Path = ("others", number_of - 1) if number_of else ("trainer",)
                yield Problem(
                    (*where, "knowledge"),
                    "nobody is an expert of an environment that the program does not know; "
                    '"myopic" judges by the reward of the step',
                    trainer.knowledge,
                )
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        yield from _unclear(protocol.domain)

    def departures(self, protocol: Protocol) -> list[str]:
        """Return what is particular to it."""
        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        encoder = protocol.learner.encoder if isinstance(protocol.learner, SarsaConfig) else None
        tick_ms = protocol.screen.tick_ms
        return [
            f"the domain is the Gymnasium environment {protocol.domain.env}, without its own time limit",
            f"a step on screen is one step of the environment: what it led to, shown for {tick_ms} ms",
            "every episode counts as one policy, because the learner changes all the time",
            _seen(with_encoder(protocol.domain, encoder)),
        ]


def _unclear(config: GymnasiumConfig) -> Iterator[Problem]:
    """Yield what is unclear in names and words, though it may be played: for sessions that are about to be
    run.
    """
    versioned = re.fullmatch(r".+-v\d+", config.env)
    if versioned is None and not re.fullmatch(r"[^:]+:[^:]+", config.env):
        yield Problem(
            ("domain", "env"),
            'name an environment of Gymnasium with its version ("CartPole-v1"), so that the recording says '
            'what was played, or a function of your own ("module:function")',
            config.env,
        )
    lines: list[tuple[Path, str, int]] = [(("domain", "task"), config.task, LONGEST_TASK)]
    lines += [
        (("domain", "actions", number), name, LONGEST_ACTION) for number, name in enumerate(config.actions)
    ]
    for path, words, longest in lines:
        if len(words) > longest or not words.isprintable():
            yield Problem(path, f"expected at most {longest} printable characters", words)


def _seen(config: GymnasiumConfig) -> str:
    """Return what learner and human model see, in a sentence."""
    numbers = f"each number of {config.phi}" if config.phi else "each number of the observation"
    if config.joint:
        numbers = f"all numbers of {config.phi}" if config.phi else "all numbers of the observation"
    tiled = f"{numbers} {'are tiled together' if config.joint else 'is tiled alone'}"
    human = f"the features {config.psi}" if config.psi else "the learner's tiles"
    return f"{tiled}; the human model sees {human}"


PLUGIN = GymnasiumPlugin()
