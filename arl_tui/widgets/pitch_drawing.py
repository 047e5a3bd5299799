"""A picture of the pitch as lines of characters: pure functions, no screen.

Three renderings share everything but the fineness of their dots: plain ASCII has one dot per character,
half-blocks two, braille eight. Players are their names (K1, T2) on two characters, which are always to be
read: names move aside for each other, and the ball for names. A character is taken to be twice as high as
wide.
"""

import math

from arl_tui.language import tr
from arl_tui.widgets.pitch_ink import ASPECT, LEAST_LINES, MARKS, Detail, Mark, Row, Shape
from arl_tui.widgets.pitch_sheet import Sheet
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import NO_PLAYER, ONGOING, OUT

LEAST_LETTERS = 4
"""Words in the boundary are not shortened to fewer letters: "K1 p..." says something, "K..." does not."""


def fit(length_m: float, width_m: float, columns: int, lines: int) -> Shape | None:
    """Return the largest drawing of a region at its true proportions; None where it could not be read.

    Args:
        length_m: extent along x, drawn from left to right.
        width_m: extent along y, drawn downwards.
        columns: there is room for so many characters,
        lines: and so many lines.
    """
    scale = min((lines - 2) / width_m, (columns - 2) / (ASPECT * length_m))
    shape = Shape(int(ASPECT * length_m * scale + 1e-9) + 2, int(width_m * scale + 1e-9) + 2)
    return shape if min(shape.lines - 2, (shape.columns - 2) / ASPECT) >= LEAST_LINES else None


def smallest(length_m: float, width_m: float) -> Shape:
    """Return the smallest drawing of a region that can be read."""
    scale = LEAST_LINES / min(length_m, width_m)
    return Shape(math.ceil(ASPECT * length_m * scale - 1e-9) + 2, math.ceil(width_m * scale - 1e-9) + 2)


def draw(
    frame: PitchFrame,
    shape: Shape,
    detail: Detail,
    note: str = "",
    title: str | None = None,
    *,
    caption: bool = True,
    mark: Mark | None = None,
    options: tuple[tuple[int, str], ...] = (),
) -> tuple[Row, ...]:
    """Return the rows of a picture.

    Args:
        frame: what is to be seen.
        shape: of the drawing (`fit`).
        detail: how fine.
        note: written into the boundary at the bottom right, such as the presses left.
        title: written into it at the top left; the number of the episode by default.
        caption: whether what is going on stands in it at the bottom left, lit up where it is an end.
        mark: players to be marked.
        options: players, and the keys of a question's options that are written beside them.
    """
    sheet = Sheet(frame, shape, detail, mark)
    sheet.write_names()
    sheet.write_keys(options)
    sheet.dot_centre()
    sheet.dot_pass()
    sheet.dot_trail()
    sheet.dot_players()
    sheet.place_ball()
    title = tr("Episode {number}", number=frame.episode) if title is None else title
    sheet.news = caption
    edges = _edges(
        shape, detail, (title, f"{frame.time_s:.1f} s"), (caption_of(frame) if caption else "", note)
    )
    return tuple(sheet.row(line, edges.get(line)) for line in range(shape.lines))


def caption_of(frame: PitchFrame) -> str:
    """Say in a few words what is going on, as `PitchFrame.caption` does, in the language in use."""
    if frame.ended != ONGOING:
        if frame.ended == OUT:
            return tr("Ball out after {seconds:.1f} s", seconds=frame.time_s)
        return tr("Ball taken after {seconds:.1f} s", seconds=frame.time_s)
    if frame.passing:
        decider, target = frame.name(frame.decider), frame.name(frame.target)
        return tr("{keeper} passes to {target}", keeper=decider, target=target)
    if frame.holder == NO_PLAYER:
        return tr("Ball is free")
    return tr("{player} has the ball", player=frame.name(frame.holder))


def plain(rows: tuple[Row, ...]) -> list[str]:
    """Return the characters of a drawing alone, line by line."""
    return ["".join(text for text, _, _ in row) for row in rows]


def _edges(shape: Shape, detail: Detail, first: tuple[str, str], last: tuple[str, str]) -> dict[int, str]:
    """Return the boundary's first and last line with the words at their left and right ends in them."""
    corners, level = MARKS[detail].boundary[:4], MARKS[detail].boundary[4]
    dots = "…" if detail == "braille" else "..."
    width = shape.columns - 2
    top = _between_ends(*first, width, level, dots)
    bottom = _between_ends(*last, width, level, dots)
    return {0: corners[0] + top + corners[1], shape.lines - 1: corners[2] + bottom + corners[3]}


def _between_ends(left: str, right: str, width: int, level: str, dots: str) -> str:
    """Return a line with words at both ends; where there is no room for both, those on the left are
    shortened.

    What stands on the right is a figure (time, presses left): nobody else shows it, and half of it would be
    wrong.
    """
    right = f" {_shortened(right, width - 4, dots)} " if right else ""
    room = width - len(right) - 4
    left = f" {short} " if (short := _shortened(left, room, dots)) else ""
    return level + left + level * (width - 2 - len(left) - len(right)) + right + level


def _shortened(text: str, room: int, dots: str) -> str:
    """Return the text, as much of it as there is room for, or nothing where that would be less than a
    word.
    """
    if len(text) <= room:
        return text
    kept = text[: max(0, room - len(dots))].rstrip()
    return kept + dots if len(kept) >= LEAST_LETTERS else ""
