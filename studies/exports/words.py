"""Games, pieces and actions in words, as exported tables say them."""

from collections.abc import Mapping

from core.tetris.shapes import ORIENTATION_ROWS, PIECE_NAMES

GAMES = ("tetris", "keepaway")
PIECES = PIECE_NAMES
PERFORMANCE_UNITS = {"tetris": "lines", "keepaway": "s"}


def piece_of(game: str, detail: Mapping[str, int]) -> str | None:
    """Return the letter of the piece that a step places; None outside Tetris."""
    piece = detail.get("piece") if game == "tetris" else None
    return PIECES[piece] if piece is not None and 0 <= piece < len(PIECES) else None


def actor_of(game: str, detail: Mapping[str, int]) -> str | None:
    """Return who acts, such as `keeper 2`, counted from 1; None where there is one actor only."""
    return f"keeper {detail['keeper'] + 1}" if game == "keepaway" and "keeper" in detail else None


def action_of(game: str, detail: Mapping[str, int]) -> str | None:
    """Return a step's action in words; None where the recording does not say it.

    Tetris: `T, orientation 2 of 4, column 5`: the column of the piece's left edge. Keepaway: `hold` or
    `pass to keeper 3`. All are counted from 1.
    """
    if game == "keepaway" and "target" in detail:
        target = detail["target"]
        return "hold" if target < 0 else f"pass to keeper {target + 1}"
    piece = piece_of(game, detail)
    if piece is None or "orientation" not in detail:
        return None
    orientations = len(ORIENTATION_ROWS[detail["piece"]])
    return (
        f"{piece}, orientation {detail['orientation'] + 1} of {orientations}, column {detail['column'] + 1}"
    )
