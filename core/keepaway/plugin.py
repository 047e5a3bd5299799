"""Keepaway as protocols know it (`core.plugins`). No compiled code is imported."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from core.combination.config import AgentConfig
from core.configuration.messages import Path
from core.configuration.reading import Problem
from core.feedback.config import CreditConfig
from core.feedback.delays import GammaDelay
from core.feedback.keys import KeyConfig
from core.keepaway import REVISION
from core.keepaway.action import ChosenOption
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_S, KeepawayConfig
from core.learners.human_config import TileModel
from core.learners.sarsa_config import SarsaConfig
from core.plugins import GamePlugin
from core.session.effects import Mode, Use
from core.session.protocol import Protocol, ScreenConfig, SessionConfig

if TYPE_CHECKING:
    from core.keepaway.picture import PitchFrame
    from core.registry import Game

SECONDS_PER_MATCH = 10.0
"""An untrained team keeps the ball for about 7 s, a trained one for 12 s (default size)."""


def _noisy_sight(protocol: Protocol, mode: Mode) -> bool:
    return isinstance(protocol.domain, KeepawayConfig) and not protocol.domain.exact_state


class KeepawayPlugin(GamePlugin):
    """The paper's second domain (section 3.3)."""

    name = "keepaway"
    title = "Keepaway"
    config = KeepawayConfig
    action = ChosenOption
    revision = REVISION
    learners = (SarsaConfig,)
    human_models = (TileModel,)
    steps = "decisions"
    kernels = 122
    idle: ClassVar[Mapping[str, str]] = {
        "screen.tick_ms": "",
        "session.watched": ("the learner of Keepaway changes at every step, and no policy of it comes back"),
    }
    uses = (
        Use(
            ("domain.view_angle_deg", "domain.quantise", "domain.see_phases"),
            "with exact_state = false only",
            _noisy_sight,
        ),
    )

    @cache  # noqa: B019 - there is one instance
    def default(self) -> Protocol:
        """Return 3v2 on 20 m x 20 m with noisy sight, shown at a fifth of its speed."""
        return Protocol(
            domain=KeepawayConfig(),
            learner=SarsaConfig(),
            agent=AgentConfig(credit=CreditConfig(delay=GammaDelay()), human_model=TileModel()),
            # Section 4: at most two presses per episode, about 1 in 10 of them wrong.
            keys=KeyConfig(max_presses_per_episode=2),
            trainer=KeepawayPersonConfig().trainer,
            # An untrained team keeps the ball for about 7 s, a trained one for 12 s; a step takes 0.1 s or a
            # pass.
            session=SessionConfig(episodes=20, unseen_between=0, watched_steps=1200, unseen_steps=12000),
            # A pass then takes 3.2 s, in which it can be judged (docs/decisions/pace-of-a-session.md).
            screen=ScreenConfig(speed=0.2),
        )

    def expected_game_s(self, protocol: Protocol) -> float:
        """Return the time that a match of the default's mean length takes."""
        match_s = min(SECONDS_PER_MATCH, protocol.session.watched_steps * CYCLE_S)
        return match_s / protocol.screen.speed

    def view(self) -> "type[PitchFrame]":
        """Return the pictures."""
        from core.keepaway.picture import PitchFrame

        return PitchFrame

    def load(self) -> "Game":
        """Return the game; the simulator in compiled code."""
        from core.keepaway.sessions import KeepawayGame

        return KeepawayGame()

    def contradictions(self, protocol: Protocol) -> Iterator[Problem]:
        """Yield the simulated participants who would judge by what an option does at once."""
        for number, trainer in enumerate((protocol.trainer, *protocol.others)):
            if trainer.knowledge == "myopic":
                where: Path = ("others", number - 1) if number else ("trainer",)
                yield Problem(
                    (*where, "knowledge"),
                    "no participant of Keepaway is myopic (an option has no immediate effect): expert or lay",
                    "myopic",
                )

    def departures(self, protocol: Protocol) -> list[str]:
        """Return what is particular to Keepaway."""
        assert isinstance(protocol.domain, KeepawayConfig), "a protocol of Keepaway"
        model = protocol.agent.human_model
        shared = isinstance(model, TileModel) and model.shared
        found = [
            "the simulator is our own, not the RoboCup soccer server (docs/results/keepaway_fidelity.md)",
            "each episode begins a new match: body directions are drawn anew",
            "every episode counts as one policy, because the learner changes all the time",
            "the human model sees the learner's tiles, "
            + ("one model for all keepers" if shared else "one model per keeper"),
        ]
        if protocol.screen.speed != 1.0:
            found.append(f"the game is shown at {protocol.screen.speed:g} times its own speed")
        if protocol.domain.exact_state:
            found.append("players know the exact state instead of noisy perceptions")
        elif protocol.domain.see_phases is None:
            found.append(
                "which two of three cycles each player sees in is drawn anew in every episode (the "
                "reference: once per match)"
            )
        return found


PLUGIN = KeepawayPlugin()
KEEPAWAY = PLUGIN.default()
"""The default protocol of Keepaway."""
