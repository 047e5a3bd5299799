"""What of the play screen belongs to one game: the picture, the figures beside it, and how much room they
take.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol as Interface
from typing import runtime_checkable

from textual.geometry import Size
from textual.widget import Widget

from arl_tui.app.link import Picture, TakenFor
from arl_tui.games.rendering import Place
from arl_tui.widgets.coverable import CoverableWidget

SMALLEST = Size(80, 24)
"""Terminals are at least this large by custom; a board of 20 x 10 fits."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far the session is."""

    episode: int
    """Number of the watched episode, from 1."""
    episodes: int
    """How many there will be."""
    human_weights: tuple[float, ...]
    """Weight of the participant in each game so far, oldest first; () where it is not to be seen."""
    performances: tuple[float, ...] = ()
    """Of the watched episodes so far, in the game's unit, oldest first."""


class Panel(Interface):
    """Draws the pictures of one game."""

    @property
    def needed(self) -> Size:
        """Columns and lines without which the game does not fit."""
        ...

    def take_drawn(self) -> bool:
        """Return whether a picture has been drawn for the first time, or again after `refresh`, since the
        last call.
        """
        ...

    def game_widget(self) -> CoverableWidget:
        """Return the widget of the game itself."""
        ...

    def figures(self) -> Iterable[Widget]:
        """Return what stands beside it."""
        ...

    def show(self, picture: Picture, progress: Progress) -> None:
        """Draw a picture with the next paint, even if it looks like the one before."""
        ...

    def refresh(self) -> None:
        """Draw the present picture once more."""
        ...

    def title(self, text: str) -> None:
        """Write a title to the game."""
        ...

    def mark(self, taken: TakenFor) -> str:
        """Mark for a moment what a press was taken for; return it in words ("for the marked piece")."""
        ...

    def unmark(self) -> None:
        """Take the mark away."""
        ...

    def presses_left(self, presses: int) -> None:
        """Say how many presses still count in this episode, if the game's picture has a place for it."""
        ...


@runtime_checkable
class DrawsOptions(Interface):
    """A panel that draws the options of a question into the game; others leave it to the list beside it."""

    def pose(self, places: Sequence[Place], keys: Sequence[str]) -> None:
        """Draw each option where it is to be seen, by its key, until `unpose`."""
        ...

    def unpose(self) -> None:
        """Take the options away."""
        ...
