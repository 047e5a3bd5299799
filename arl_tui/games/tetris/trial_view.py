"""Tetris in the feedback-lag task: the real board."""

from collections.abc import Sequence

from textual.geometry import Size
from textual.widget import Widget

from arl_tui.games.tetris.judging import TrialPosition
from arl_tui.palette import Palette
from arl_tui.widgets.board import TetrisBoard
from core.numerics.clock import NS_PER_MS
from studies.reaction_time.protocol import TrialPlan

AROUND = Size(58, 3)
"""Columns and lines beside and below the board's blocks: as in a session, so that blocks look the same."""


class BoardTrialView:
    """The real board: a piece enters, is moved and drops, picture by picture as in a session."""

    def __init__(
        self, positions: Sequence[TrialPosition], palette: Palette, tick_ms: int, time_out_s: float
    ) -> None:
        """Show the first trial's board.

        Args:
            positions: of all trials.
            palette: colours.
            tick_ms: how long a picture is shown.
            time_out_s: of the task: in a catch trial no piece drops before it.
        """
        first = positions[0].waiting
        self.board = TetrisBoard(first.rows, first.columns, palette=palette, around=AROUND)
        self.tick_ns: int | None = tick_ms * NS_PER_MS
        self._given = (positions, palette, tick_ms, time_out_s)
        self._positions = positions
        self._tick_ms = tick_ms
        self._time_out_s = time_out_s
        self._dropped = -1
        """The trial whose piece is falling; -1 where none is."""

    @property
    def widget(self) -> Widget:
        """The board."""
        return self.board

    def renewed(self) -> "BoardTrialView":
        """Return the same game on a new board."""
        return BoardTrialView(*self._given)

    def early_ns(self, plan: TrialPlan) -> int:
        """Return what is left of the foreperiod beside whole ticks: every move is shown for a whole one."""
        return round(plan.foreperiod_s * 1000 * NS_PER_MS) % (self._tick_ms * NS_PER_MS)

    def study(self, item: str) -> None:
        """Do nothing: there is nothing to remember in a game."""

    def wait(self, plan: TrialPlan, tick: int) -> None:
        """Show the board, then the piece that enters and is moved until the foreperiod is over."""
        self._dropped = -1
        waited_s = plan.foreperiod_s + (self._time_out_s if plan.catch else 0.0)
        ticks = int(1000 * waited_s / self._tick_ms + 1e-9) + (1 if plan.catch else 0)
        self.board.show(self._positions[plan.index].at(max(1, ticks - tick)))

    def present(self, plan: TrialPlan) -> None:
        """Begin the drop."""
        self._dropped = plan.index
        self.board.show(self._positions[plan.index].event[0], plan.index)

    def follow(self, plan: TrialPlan, tick: int) -> None:
        """Let the piece fall and settle."""
        event = self._positions[plan.index].event
        if tick > 0:
            self.board.show(event[min(tick, len(event) - 1)])

    def rest(self) -> None:
        """Show the settled board where a piece has dropped."""
        if self._dropped >= 0:
            self.board.show(self._positions[self._dropped].event[-1])
            self._dropped = -1

    def take_drawn(self) -> int:
        """Return what the board has drawn."""
        return self.board.take_drawn()

    def note(self, plan: TrialPlan) -> str:
        """Return where the piece went."""
        return self._positions[plan.index].note
