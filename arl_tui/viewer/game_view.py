"""The game on the viewer's screen: a board, a pitch, or the panel of a game that came as a plug-in."""

from arl_tui.app.link import Picture
from arl_tui.games.panel import Panel, Progress
from arl_tui.games.registry import screens_of
from arl_tui.palette import Palette
from arl_tui.viewer.boards import MarkedBoard, MarkedPitch
from arl_tui.viewer.drawing import board_marks, pitch_marks
from arl_tui.viewer.looks import Look
from arl_tui.viewer.reading import Viewing
from arl_tui.widgets.coverable import CoverableWidget
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import KeepawayConfig
from core.tetris.config import TetrisConfig
from core.tetris.picture import Snapshot
from studies.session_view.session import Moment

PIECES = "IOTZSJL"
"""Letters of the pieces by id."""


class GameView:
    """Draws the pictures of one recording, and marks on them where the game has marks."""

    def __init__(self, viewing: Viewing, palette: Palette) -> None:
        """Make the widget of the recording's game."""
        self._viewing = viewing
        self.board: MarkedBoard | None = None
        self.pitch: MarkedPitch | None = None
        self._panel: Panel | None = None
        protocol = viewing.session.protocol
        domain = None if protocol is None else protocol.domain
        if protocol is None or isinstance(domain, TetrisConfig):
            size = (domain.rows, domain.columns) if isinstance(domain, TetrisConfig) else (20, 10)
            self.board = MarkedBoard(*size, palette=palette, id="game")
        elif isinstance(domain, KeepawayConfig):
            self.pitch = MarkedPitch(domain.length_m, domain.width_m, beside=40, palette=palette, id="game")
        else:
            self._panel = screens_of(protocol).panel(protocol, palette)

    @property
    def widget(self) -> CoverableWidget:
        """The widget of the game."""
        if self._panel is not None:
            return self._panel.game_widget()
        widget = self.board or self.pitch
        assert widget is not None, "there is a widget for every game"
        return widget

    def draw(self, moment: Moment, look: Look, *, marks: bool) -> None:
        """Draw what was on screen at a moment.

        Args:
            moment: which.
            look: the picture of it.
            marks: whether credit and candidates are drawn on the game.
        """
        game = self.widget
        cover = f"Covered: {moment.covered}" if moment.covered else look.words if look.view is None else ""
        if cover:
            game.cover(cover)
        elif game.covered:
            game.uncover()
        games = self._viewing.session.games
        number = int(games["number"][moment.game]) if moment.game >= 0 else -1
        title = f"Game {moment.game + 1}" if number >= 0 else ""
        if self.board is not None:
            self.board.border_title = title
            if isinstance(look.view, Snapshot):
                self._draw_board(self.board, moment, look, look.view, marks=marks)
        elif self.pitch is not None:
            if isinstance(look.view, PitchFrame):
                self.pitch.title = title
                self.pitch.show(look.view)
                self.pitch.overlay(pitch_marks(self._viewing, moment, look.view) if marks else {})
        elif self._panel is not None and look.view is not None:
            self._panel.title(title)
            picture = Picture(number=max(moment.frame, 0), step=moment.step, view=look.view)
            self._panel.show(picture, Progress(moment.game + 1, len(games), ()))

    def _draw_board(
        self, board: MarkedBoard, moment: Moment, look: Look, view: Snapshot, *, marks: bool
    ) -> None:
        counts = view.counts
        following = f", next {PIECES[counts.next_piece]}" if counts.next_piece >= 0 else ""
        lines = "1 line" if counts.lines == 1 else f"{counts.lines} lines"
        board.border_subtitle = f"{lines}{following}"
        board.show(view)
        board.overlay(board_marks(self._viewing, moment, look, view) if marks else {})
