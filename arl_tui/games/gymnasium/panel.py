"""A Gymnasium environment in the play screen: its picture in half blocks, or its text, and the figures."""

from collections.abc import Iterable

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.link import Picture, TakenFor
from arl_tui.games.panel import SMALLEST, Progress
from arl_tui.language import tr
from arl_tui.widgets.coverable import CoverableWidget
from core.interop.gymnasium.picture import EnvPicture

UPPER_HALF = "▀"
BESIDE = 30
"""Columns of the figures."""


class EnvWidget(CoverableWidget, inherit_bindings=False, can_focus=False):
    """Draws what an environment draws of itself."""

    DEFAULT_CSS = """
    EnvWidget { width: 44; height: 22; max-height: 100%;
        border: round $foreground 40%; border-title-align: center; border-subtitle-align: center; }
    """

    def __init__(self) -> None:
        super().__init__(id="environment")
        self._picture = EnvPicture()
        self._number = -1
        self._fresh = False

    def show(self, picture: EnvPicture, number: int) -> None:
        """Draw a picture with the next paint."""
        self._picture, self._number = picture, number
        self.refresh()

    def take_drawn(self) -> bool:
        """Return whether a picture has been drawn since the last call."""
        fresh, self._fresh = self._fresh, False
        return fresh

    def render_line(self, y: int) -> Strip:
        """Return one line: two rows of pixels, or a line of text."""
        width, height = self.size
        covering = self.covering(y, height)
        if covering is not None:
            return Strip([Segment(covering.center(width)[:width], self.rich_style)])
        self._fresh = self._number >= 0
        if self._picture.width == 0:
            lines = self._picture.text.splitlines()
            return Strip(
                [Segment((lines[y] if y < len(lines) else "").ljust(width)[:width], self.rich_style)]
            )
        return self._pixels(2 * (y - (height - self._picture.height // 2) // 2), width)

    def _pixels(self, row: int, width: int) -> Strip:
        picture = self._picture
        if not 0 <= row < picture.height:
            return Strip.blank(width, self.rich_style)
        left = max(0, (width - picture.width) // 2)
        segments = [Segment(" " * left, self.rich_style)]
        for column in range(min(picture.width, width)):
            above, below = _colour(picture, row, column), _colour(picture, row + 1, column)
            segments.append(Segment(UPPER_HALF, Style(color=above, bgcolor=below)))
        return Strip(segments).adjust_cell_length(width, self.rich_style)


def _colour(picture: EnvPicture, row: int, column: int) -> Color:
    start = 3 * (min(row, picture.height - 1) * picture.width + column)
    red, green, blue = picture.pixels[start : start + 3]
    return Color.from_rgb(red, green, blue)


class GymnasiumPanel:
    """The environment's picture, and the figures of the game."""

    needed = SMALLEST
    """Columns and lines without which the game does not fit."""

    def __init__(self) -> None:
        self.widget = EnvWidget()
        self._figures = Static(id="figures")
        self._figures.styles.width = BESIDE
        self._figures.border_title = tr("Progress")

    def take_drawn(self) -> bool:
        """Return whether a picture has been drawn since the last call."""
        return self.widget.take_drawn()

    def game_widget(self) -> CoverableWidget:
        """Return the environment's widget."""
        return self.widget

    def figures(self) -> Iterable[Widget]:
        """Return the figures."""
        return (self._figures,)

    def show(self, picture: Picture, progress: Progress) -> None:
        """Draw a picture."""
        view = picture.view
        assert isinstance(view, EnvPicture), "a worker that plays Gymnasium sends its pictures"
        self.widget.show(view, picture.number)
        if not self._figures.is_attached:
            # Nothing stands beside it, as in the viewer: the border says it.
            self.widget.border_subtitle = f"step {view.steps}, reward {view.reward:.4g}"
        self._figures.update(
            f"{tr('Game'):<11}{tr('{done} of {all}', done=progress.episode, all=progress.episodes)}\n"
            f"{tr('Step'):<11}{view.steps}\n{tr('Reward'):<11}{view.reward:.4g}"
        )

    def refresh(self) -> None:
        """Draw the picture once more."""
        self.widget.refresh()

    def title(self, text: str) -> None:
        """Write into the border."""
        self.widget.border_title = text

    def part(self, text: str) -> None:
        """Write into the border of the figures."""
        self._figures.border_title = text

    def mark(self, taken: TakenFor) -> str:
        """Say that the press counted; where the action is to be seen nobody knows."""
        return tr("but no step was on screen") if taken.step < 0 else tr("for the last step")

    def unmark(self) -> None:
        """Do nothing: nothing is marked."""

    def presses_left(self, presses: int | None) -> None:
        """Say nothing: the feedback bar is near enough."""
