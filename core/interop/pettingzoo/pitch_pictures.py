"""Pictures of Keepaway for programs without this program's screens: text, and pixels."""

import numpy as np
from numpy.typing import NDArray

from core.keepaway.pitch import KeepawayConfig, X, Y
from core.keepaway.simulator.match import Match

CELLS_PER_M = 2
"""Columns of text in a metre; a line is two columns high."""
PIXELS_PER_M = 12
BORDER_M = 1.0
"""Drawn around the region."""
GRASS, LINE = (32, 96, 48), (220, 220, 220)
KEEPER, TAKER, BALL = (86, 180, 233), (213, 94, 0), (255, 255, 255)


def pitch_text(match: Match, config: KeepawayConfig) -> str:
    """Return a picture as text: keepers are digits, takers letters, the ball is `o`."""
    wide = round(config.length_m * CELLS_PER_M) + 1
    high = round(config.width_m * CELLS_PER_M / 2) + 1
    cells = np.full((high, wide), ".")

    def put(x: float, y: float, letter: str) -> None:
        column = round((x + config.length_m / 2) * CELLS_PER_M)
        line = round((y + config.width_m / 2) * CELLS_PER_M / 2)
        cells[min(max(line, 0), high - 1), min(max(column, 0), wide - 1)] = letter

    for number, player in enumerate(match.players):
        taker = number - config.n_keepers
        put(player[X], player[Y], chr(ord("A") + taker) if taker >= 0 else str(number + 1))
    put(match.ball[X], match.ball[Y], "o")
    return "\n".join("".join(line) for line in cells.tolist()) + "\n"


def pitch_pixels(match: Match, config: KeepawayConfig) -> NDArray[np.uint8]:
    """Return a picture as pixels, shape (height, width, 3)."""
    high = round((config.width_m + 2 * BORDER_M) * PIXELS_PER_M)
    wide = round((config.length_m + 2 * BORDER_M) * PIXELS_PER_M)
    pixels = np.empty((high, wide, 3), np.uint8)
    pixels[:] = GRASS
    edge = round(BORDER_M * PIXELS_PER_M)
    pixels[[edge, -edge], edge:-edge] = LINE
    pixels[edge:-edge, [edge, -edge]] = LINE
    lines, columns = np.mgrid[0:high, 0:wide]

    def put(x: float, y: float, radius_m: float, colour: tuple[int, int, int]) -> None:
        across = columns / PIXELS_PER_M - BORDER_M - config.length_m / 2 - x
        down = lines / PIXELS_PER_M - BORDER_M - config.width_m / 2 - y
        pixels[across**2 + down**2 <= radius_m**2] = colour

    for number, player in enumerate(match.players):
        put(player[X], player[Y], 0.6, KEEPER if number < config.n_keepers else TAKER)
    put(match.ball[X], match.ball[Y], 0.3, BALL)
    return pixels
