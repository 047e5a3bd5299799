"""What the viewer's pictures have in common, whichever game they are of."""

from dataclasses import dataclass, field

from core.plugins import View
from core.tetris.game import Board as BitBoard
from core.tetris.picture import Wall
from studies.session_view.session import Moment, SessionView

Ids = tuple[tuple[int, ...], ...]
"""Rows from the bottom; for each cell the number of the step that placed it, -1 where nobody knows."""


@dataclass(frozen=True, slots=True)
class Look:
    """A picture, and what the marks on it need."""

    view: View | None
    """None where nothing was on screen."""
    words: str = ""
    """Why there is no picture, or what is unusual about it."""
    before: "Board | None" = None
    """Tetris: the board on which the step on screen was decided."""
    ids: Ids = field(default=())
    """Tetris: which step placed which settled cell of the picture."""


@dataclass(frozen=True, slots=True)
class Board:
    """A board of Tetris at rest."""

    wall: Wall
    ids: Ids
    lines: int
    pieces: int
    columns: BitBoard
    """The wall as the learner sees it."""


def board_of(wall: Wall, lines: int, pieces: int) -> Board:
    """Return a board of which nobody knows which step placed what."""
    return Board(wall, (), lines, pieces, wall.board)


def tick_number(session: SessionView, moment: Moment, n_ticks: int, tick_ns: int) -> int:
    """Return which of a step's pictures was on screen.

    A live session records every picture as a frame: where all of them reached the terminal, they are counted.
    Where some did not, or where only the first is recorded (simulated and imported sessions), time on screen
    tells.
    """
    frame, frames = moment.frame, session.frames
    n_frames = session.frames_of(moment.step) if moment.step >= 0 else 0
    if n_frames == n_ticks:
        while frame > 0 and frames["nth"][frame] < 0:
            frame -= 1
        return int(frames["nth"][frame])
    visible_ns = moment.visible_ns
    if n_frames > 1:
        visible_ns = session.at(int(frames["time"][moment.frame])).visible_ns + tick_ns // 2
    return min(max(visible_ns // tick_ns, 0), n_ticks - 1)
