"""What the app has of Tetris (`arl_tui.games.registry`)."""

from typing import TYPE_CHECKING

import msgspec

from arl_tui.games.registry import GameScreens
from arl_tui.language import later, later_n, tr
from arl_tui.words import JudgingWords, Words
from core.feedback.config import TrainerConfig
from core.numerics.clock import NS_PER_MS
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.tetris.config import TetrisConfig
from core.tetris.shapes import ORIENTATION_ROWS
from studies.reaction_time.protocol import Schedule

if TYPE_CHECKING:
    from arl_tui.games.tetris.panel import TetrisPanel
    from arl_tui.games.tetris.renderer import TetrisRenderer
    from arl_tui.games.tetris.trial_view import BoardTrialView
    from arl_tui.palette import Palette

WORDS = Words(
    heading=later("Teach a computer to play Tetris"),
    welcome=later(
        "You will watch a computer play {games} of Tetris. It does not know yet how to play well. "
        "{practises}You can help it: tell it what you think of where it has just put a piece."
    ),
    rules=later(
        "The computer drops one piece after another. Full rows disappear: the more, the better. A game ends "
        "when the pile reaches the top.\n\nTell it what you think of where the last piece came to rest:\n"
    ),
    practises=later("It practises on its own between games. "),
    performance=later("Lines cleared"),
    units=later_n("line", "lines"),
    steps=later("pieces"),
    step=later("piece"),
    question=later("Where should the next piece go?"),
)
JUDGING = JudgingWords(
    instruction=later(
        "You watch a computer play Tetris. A piece enters and is moved, then it [b]drops[/]; its shadow "
        "shows where. Full rows disappear, so a piece should leave no holes and not stand out.\n\n"
        "It goes to a good place: press {yes}\nIt goes to a bad place:  press {no}\n\n"
        "Press as soon as you have made up your mind. The computer's mistakes are put right before the next "
        "piece."
    ),
    reminder=later("{no} bad place\n{yes} good place"),
)


class TetrisScreens(GameScreens):
    """Board, next piece and score."""

    name = "tetris"
    words = WORDS
    judging_module = "arl_tui.games.tetris.judging"
    judging = JUDGING

    def trial_view(self, prepared: bytes, schedule: Schedule, palette: "Palette") -> "BoardTrialView":
        """Return the board on which a piece drops in each trial."""
        from arl_tui.games.tetris.judging import TrialPosition, tick_ms
        from arl_tui.games.tetris.trial_view import BoardTrialView

        positions = msgspec.json.decode(prepared, type=list[TrialPosition])
        return BoardTrialView(positions, palette, tick_ms(schedule), schedule.config.time_out_s)

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

    def option(self, detail: dict[str, int], protocol: Protocol) -> str:
        """Return which columns the piece would take."""
        rows = ORIENTATION_ROWS[detail["piece"]][detail["orientation"]]
        first = detail["column"] + 1
        last = detail["column"] + max(row.bit_length() for row in rows)
        if first == last:
            return tr("column {column}", column=first)
        return tr("columns {first} to {last}", first=first, last=last)

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
