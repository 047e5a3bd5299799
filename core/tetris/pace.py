"""How long pieces are on screen: some games are drawn, piece by piece, and their pictures counted.

The pieces land where they come to rest lowest. On the default board they take 8.0 pictures on average, as
those of a session do (7.1 where an agent plays at random, 8.5 over the ten games of a default session without
feedback).
"""

from collections.abc import Iterator
from itertools import islice

from core.numerics.streams import stream
from core.tetris.config import TetrisConfig
from core.tetris.game import landing_row, reachable_placements
from core.tetris.picture import Counts, Wall, animate
from core.tetris.practice import PIECE_STREAMS

PIECES = 300
MOST_PER_GAME = 60


def pictures_per_piece(config: TetrisConfig) -> tuple[int, ...]:
    """Return of how many pictures (ticks) each of 300 pieces consists, in order, over as many games as it
    takes.

    The result is the same at every call.
    """
    return tuple(islice(_endless(config), PIECES))


def _endless(config: TetrisConfig) -> Iterator[int]:
    seed = 0
    while True:
        yield from _one_game(config, seed)
        seed += 1


def _one_game(config: TetrisConfig, seed: int) -> Iterator[int]:
    ties = stream(seed, "pace")
    wall = Wall(config.rows, config.columns)
    for number in range(MOST_PER_GAME):
        piece = PIECE_STREAMS[config.pieces](seed, number)
        board = wall.board
        plans = reachable_placements(board, piece, config.rows)
        if not plans:
            return
        landing = {placement: landing_row(board, piece, *placement) for placement in sorted(plans)}
        row = min(landing.values())
        lowest = [placement for placement in landing if landing[placement] == row]
        placement = lowest[ties.integers(len(lowest))]
        shown = animate(wall, piece, placement, plans[placement], counts=Counts())
        yield shown.ticks
        if shown.settled.over:
            return
        wall = shown.wall
