"""Tetris as protocols know it (`core.plugins`). No compiled code is imported."""

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, ClassVar

from core.learners.cross_entropy_config import CrossEntropyConfig
from core.learners.human_config import RidgeModel, SgdModel
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.plugins import GamePlugin
from core.session.effects import Mode, Use, learner_counts
from core.session.protocol import Protocol
from core.tetris import REVISION
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig

if TYPE_CHECKING:
    from core.registry import Game
    from core.tetris.picture import Snapshot

TICKS_PER_PIECE = 8
"""Pictures (ticks) of a piece on average on the default board (`core.tetris.pace`)."""


def _overflows(protocol: Protocol, mode: Mode) -> bool:
    return isinstance(protocol.domain, TetrisConfig) and protocol.domain.game_over == "overflow"


class TetrisPlugin(GamePlugin):
    """The paper's first domain (section 4)."""

    name = "tetris"
    title = "Tetris"
    config = TetrisConfig
    action = PlacedPiece
    revision = REVISION
    learners = (CrossEntropyConfig, PolicyGradientConfig)
    human_models = (SgdModel, RidgeModel)
    steps = "pieces"
    kernels = 53
    idle: ClassVar[Mapping[str, str]] = {"screen.speed": ""}
    uses = (
        Use(
            ("domain.clear_on_overflow", "domain.terminal_value"),
            'with game_over = "overflow" only',
            _overflows,
        ),
        Use(
            ("domain.features",),
            "on what is done with every scheme but human-only, where the environment has no say",
            lambda protocol, mode: learner_counts(protocol),
            refused=False,
        ),
    )

    @cache  # noqa: B019 - there is one instance
    def default(self) -> Protocol:
        """Return the paper's board; what is shown must be what the paper's four actions can do."""
        return Protocol(domain=TetrisConfig(placements="reachable"))

    def expected_game_s(self, protocol: Protocol) -> float:
        """Return the time that all pieces of a watched game take: most games have all of them."""
        return protocol.session.watched_steps * TICKS_PER_PIECE * protocol.screen.tick_ms / 1000

    def view(self) -> "type[Snapshot]":
        """Return the pictures."""
        from core.tetris.picture import Snapshot

        return Snapshot

    def load(self) -> "Game":
        """Return the game; boards, features and whole games in compiled code."""
        from core.tetris.sessions import TetrisGame

        return TetrisGame()

    def check(self, protocol: Protocol) -> None:
        """Refuse values that no learner of features could follow."""
        if isinstance(protocol.domain, TetrisConfig) and protocol.domain.lines_in_value:
            raise ValueError(
                "lines_in_value is for given policies in compiled play only: a session's learner sees "
                "features alone. Set [domain] lines_in_value = false"
            )

    def departures(self, protocol: Protocol) -> list[str]:
        """Return what is particular to Tetris."""
        assert isinstance(protocol.domain, TetrisConfig), "a protocol of Tetris"
        found = ["the symmetric update is made explicit: top policies are drawn by performance and match"]
        if protocol.domain.features != "bertsekas-21":
            found.append(f"the environment's learner sees the features {protocol.domain.features}")
        return found


PLUGIN = TetrisPlugin()
TETRIS = PLUGIN.default()
"""The default protocol of Tetris."""
