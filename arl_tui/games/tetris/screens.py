"""What the app has of Tetris (`arl_tui.games.registry`)."""

from typing import TYPE_CHECKING

import msgspec

from arl_tui.games.registry import GameScreens
from arl_tui.words import Words
from core.feedback.config import TrainerConfig
from core.feedback.keys import NS_PER_MS
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.tetris.config import TetrisConfig

if TYPE_CHECKING:
    from arl_tui.games.tetris.panel import TetrisPanel
    from arl_tui.games.tetris.renderer import TetrisRenderer
    from arl_tui.palette import Palette

WORDS = Words(
    heading="Teach a computer to play Tetris",
    welcome=(
        "You will watch a computer play {games} of Tetris. It does not know yet how to play well. {practises}You can "
        "help it: tell it what you think of where it has just put a piece."
    ),
    rules=(
        "The computer drops one piece after another. Full rows disappear: the more, the better. A game ends "
        "when the pile reaches the top.\n\nTell it what you think of where the last piece came to rest:\n"
    ),
    practises="It practises on its own between games. ",
    performance="Lines cleared",
    units=("line", "lines"),
    steps="pieces",
    step="piece",
)


class TetrisScreens(GameScreens):
    """Board, next piece and score."""

    name = "tetris"
    words = WORDS

    def slower(self, screen: ScreenConfig) -> str:
        """Return the pace and how it is made slower."""
        return f"[screen] tick_ms is {screen.tick_ms}: more is slower"

    def demo(self, trainer: TrainerConfig | None) -> Protocol:
        """Return three short games with much practice between; the participant presses often."""
        return Protocol(
            name="demo",
            session=SessionConfig(episodes=3, unseen_between=500, watched_steps=15),
            screen=ScreenConfig(tick_ms=110, pause_between_episodes_s=2.0, count_down_s=1),
            trainer=msgspec.structs.replace(
                trainer or TrainerConfig(), press_probability=0.35, mean_presses=None
            ),
        )

    def renderer(self, protocol: Protocol) -> "TetrisRenderer":
        """Return what draws pieces as they fall."""
        from arl_tui.games.tetris.renderer import TetrisRenderer

        assert isinstance(protocol.domain, TetrisConfig), "a protocol of Tetris"
        return TetrisRenderer(protocol.domain, protocol.screen.tick_ms * NS_PER_MS)

    def panel(self, protocol: Protocol, palette: "Palette") -> "TetrisPanel":
        """Return the board and what stands beside it."""
        from arl_tui.games.tetris.panel import TetrisPanel

        return TetrisPanel(protocol, palette)


SCREENS = TetrisScreens()
