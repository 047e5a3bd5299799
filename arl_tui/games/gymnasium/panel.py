"""A Gymnasium environment in the play screen: its picture in half blocks, or its text, and the figures."""

from collections.abc import Callable, Iterable

from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from rich.text import Text
from textual.strip import Strip
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.app.link import Picture, TakenFor
from arl_tui.games.panel import SMALLEST, Progress
from arl_tui.language import tr
from arl_tui.widgets.coverable import CoverableWidget
from core.interop.gymnasium.picture import NO_ACTION, EnvPicture, smaller

UPPER_HALF = "▀"
LABEL = 9
"""Cells of a label before its figure."""
REMEMBERED = 100
"""Actions of the last steps: a press is about one of them."""


class EnvWidget(CoverableWidget, inherit_bindings=False, can_focus=False):
    """Draws what an environment draws of itself, as large as there is room."""

    DEFAULT_CSS = """
    EnvWidget { width: 44; height: 22; max-height: 100%;
        border: round $foreground 40%; border-title-align: center; border-subtitle-align: center; }
    """

    def __init__(self) -> None:
        super().__init__(id="environment")
        self._picture = EnvPicture()
        self._number = -1
        self._fresh = False
        self._strips: list[Strip] = []
        """The picture as lines, for the size for which it was made."""
        self._made_for: tuple[int, int] | None = None

    def show(self, picture: EnvPicture, number: int) -> None:
        """Draw a picture with the next paint."""
        self._picture, self._number = picture, number
        self._made_for = None
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
        if self._made_for != (width, height):
            self._strips = self._text(width) if self._picture.width == 0 else self._pixels(width, height)
            self._made_for = width, height
        line = y - max(0, (height - len(self._strips)) // 2)
        if not 0 <= line < len(self._strips):
            return Strip.blank(width, self.rich_style)
        return self._strips[line]

    def _text(self, width: int) -> list[Strip]:
        """Return the environment's text as one block in the middle; its colours are kept."""
        lines = [_printable(line) for line in self._picture.text.expandtabs().rstrip().splitlines()]
        left = max(0, (width - max((line.cell_len for line in lines), default=0)) // 2)
        margin = Segment(" " * left, self.rich_style)
        return [
            Strip([margin, *line.render(self.app.console)])
            .adjust_cell_length(width, self.rich_style)
            .apply_style(self.rich_style)
            for line in lines
        ]

    def _pixels(self, width: int, height: int) -> list[Strip]:
        """Return the picture in half blocks, in the middle of a line."""
        import numpy as np  # here, not above: only pictures need it

        given = self._picture
        whole = np.frombuffer(given.pixels, np.uint8).reshape(given.height, given.width, 3)
        small = smaller(whole, max(1, width), max(1, 2 * height)).tolist()
        if len(small) % 2:
            small.append(small[-1])
        left = Segment(" " * max(0, (width - len(small[0])) // 2), self.rich_style)
        return [
            Strip(
                [left, *(_half_block(tuple(a), tuple(b)) for a, b in zip(above, below, strict=True))]
            ).adjust_cell_length(width, self.rich_style)
            for above, below in zip(small[::2], small[1::2], strict=True)
        ]


def _printable(line: str) -> Text:
    """Return a line of foreign text with its colours, and without what moves the cursor."""
    text = Text.from_ansi(line, end="")
    plain = "".join(sign if sign.isprintable() else " " for sign in text.plain)
    return Text(plain, spans=text.spans, end="")


def _half_block(above: tuple[int, int, int], below: tuple[int, int, int]) -> Segment:
    return Segment(UPPER_HALF, Style(color=Color.from_rgb(*above), bgcolor=Color.from_rgb(*below)))


class GymnasiumPanel:
    """The environment's picture, and the figures of the game."""

    needed = SMALLEST
    """Columns and lines without which the game does not fit."""

    def __init__(self, action_name: Callable[[int], str]) -> None:
        """Draw nothing yet.

        Args:
            action_name: of an action by its number, in the language in use.
        """
        self.widget = EnvWidget()
        self._action_name = action_name
        self._actions: dict[int, int] = {}
        """What was done at the last watched steps."""
        self._beside = False
        """Whether the figures stand beside the picture; in the viewer nothing does."""
        self._figures = Static(id="score", markup=False)
        self._figures.border_title = tr("Progress")

    def take_drawn(self) -> bool:
        """Return whether a picture has been drawn since the last call."""
        return self.widget.take_drawn()

    def game_widget(self) -> CoverableWidget:
        """Return the environment's widget."""
        return self.widget

    def figures(self) -> Iterable[Widget]:
        """Return the figures; what they say need not stand below the picture."""
        self._beside = True
        return (self._figures,)

    def show(self, picture: Picture, progress: Progress) -> None:
        """Draw a picture."""
        view = picture.view
        assert isinstance(view, EnvPicture), "a worker that plays Gymnasium sends its pictures"
        self.widget.show(view, picture.number)
        done = "" if view.action == NO_ACTION else self._action_name(view.action)
        if picture.step >= 0 and done:
            self._actions[picture.step] = view.action
            self._actions.pop(picture.step - REMEMBERED, None)
        if not self._beside:
            below = f"step {view.steps}, reward {view.reward:.4g}"
            self.widget.border_subtitle = f"{below}, {done}" if done else below
        figures = (
            (tr("Game"), tr("{done} of {all}", done=progress.episode, all=progress.episodes)),
            (tr("Step"), f"{view.steps}"),
            (tr("Action"), done),
            (tr("Reward"), f"{view.reward:.4g}"),
        )
        self._figures.update("\n".join(f"{label:<{LABEL}}{figure}" for label, figure in figures))

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
        """Say which action the press was taken for."""
        if taken.step < 0:
            return tr("but no step was on screen")
        if taken.step not in self._actions:
            return tr("for the last step")
        return tr("for: {action}", action=self._action_name(self._actions[taken.step]))

    def unmark(self) -> None:
        """Do nothing: nothing is marked."""

    def presses_left(self, presses: int | None) -> None:
        """Say nothing: the feedback bar is near enough."""
