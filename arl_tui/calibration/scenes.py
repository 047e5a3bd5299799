"""The game that is watched in the feedback-lag task: a real position per trial, and a piece about to be dropped.

An expert controller plays one game. In each trial its piece hovers above the wall and is moved about by the paper's
primitives, once per tick, so that neither place nor time of the drop can be foreseen. Then it drops, within one
picture: where the expert would put it (good), or in one of the worst places (bad). The next trial goes on
as if the expert had placed it. Runs in a process of its own, because the expert needs compiled code.
"""

import sys

import msgspec
import numpy as np

from core.streams import stream, stream_seed
from core.tetris.config import TetrisConfig
from core.tetris.game import FallingPiece, Primitive, at_rest, fits, landing_row, moved
from core.tetris.picture import Counts, Snapshot, Wall, snapshot
from core.tetris.shapes import ORIENTATION_ROWS
from studies.reaction_time.protocol import Schedule

TICK_MS = 150
"""A hovering piece is moved once in this time (TAMER's Tetris: 150 ms)."""
PIECES_BEFORE = 15
"""Pieces on the wall in the first trial: enough that good and bad differ."""
N_WORST = 3
"""A bad placement is one of this many worst ones."""
HOVER_HEIGHT = 4
"""Rows below the top that a hovering piece keeps to: the tallest piece has as many."""


class Scene(msgspec.Struct, frozen=True, kw_only=True):
    """One trial's game."""

    wall: Wall
    counts: Counts
    hover: tuple[FallingPiece, ...]
    """Where the piece is in each tick; the last place is right above the one where it lands."""
    landed: FallingPiece
    note: str
    """What was shown, for the recording."""

    def hovering(self, tick: int) -> Snapshot:
        """Return the picture of a tick; the last one stays."""
        return _plain(self.wall, self.hover[min(tick, len(self.hover) - 1)], self.counts)

    def event(self) -> Snapshot:
        """Return the picture right after the drop: the piece bright, its shadow where it came from."""
        fallen = _plain(self.wall, self.landed, self.counts)
        return msgspec.structs.replace(fallen, ghost_row=self.hover[-1].row)


def _plain(wall: Wall, falling: FallingPiece, counts: Counts) -> Snapshot:
    """Return a picture that does not tell where the piece would come to rest."""
    return msgspec.structs.replace(snapshot(wall, falling, counts=counts), ghost_row=falling.row)


def make_scenes(schedule: Schedule) -> list[Scene]:
    """Return the scene of each trial, in order: they follow from the schedule alone."""
    # Here, not above: compiled code, and the screen's process imports this module.
    from core.tetris.afterstate import Tetris
    from core.tetris.oracle import TetrisOracle

    config = TetrisConfig(placements="reachable")
    domain, oracle = Tetris(config), TetrisOracle(config)
    state = domain.initial(stream_seed(schedule.root_seed, "feedback-lag game"))
    wall = Wall(config.rows, config.columns)
    scenes: list[Scene] = []
    for number in range(PIECES_BEFORE + len(schedule.trials)):
        order = np.argsort(oracle(state), kind="stable")
        best = int(order[-1])
        if number >= PIECES_BEFORE:
            plan = schedule.trials[number - PIECES_BEFORE]
            rng = stream(schedule.root_seed, "feedback-lag scene", plan.index)
            bad = plan.condition == "bad placement" or (plan.catch and bool(rng.integers(2)))
            choices = order[:N_WORST] if bad else order[-1:]
            action = int(choices[rng.integers(len(choices))])
            rank = len(order) - int(np.flatnonzero(order == action)[0])
            place = domain.placement(state, action)
            counts = Counts(lines=state.lines, pieces=state.pieces, next_piece=domain.piece(state, ahead=1))
            note = f"piece {place.piece}, orientation {place.orientation}, column {place.column}, rank {rank} of {len(order)}"
            landed = _resting(wall, place.piece, place.orientation, place.column)
            seconds = plan.foreperiod_s + (schedule.config.time_out_s if plan.catch else 0.0)
            hover = hover_path(wall, landed, int(seconds * 1000 / TICK_MS) + 1, rng=rng)
            scenes.append(Scene(wall=wall, counts=counts, hover=hover, landed=landed, note=note))
        place = domain.placement(state, best)
        filled = wall.with_piece(_resting(wall, place.piece, place.orientation, place.column))
        wall = filled.without(_full_rows(filled))
        state = domain.transition(state, best).next_state
        assert wall.board == state.columns, "the picture and the game show the same wall"
    return scenes


def _resting(wall: Wall, piece: int, orientation: int, column: int) -> FallingPiece:
    return FallingPiece(piece, orientation, landing_row(wall.board, piece, orientation, column), column)


def _full_rows(wall: Wall) -> tuple[int, ...]:
    return tuple(row for row, level in enumerate(wall.levels) if all(level))


def hover_path(
    wall: Wall, landed: FallingPiece, n_ticks: int, *, rng: np.random.Generator
) -> tuple[FallingPiece, ...]:
    """Return where a piece hovers, tick by tick, before it drops to where it lands.

    Made backwards from the drop: each place is one from which a primitive, or waiting, leads to the next.

    Args:
        wall: with free rows at the top.
        landed: where the piece ends up.
        n_ticks: how many places, >= 1.
        rng: chooses among the ways.
    """
    board, row = wall.board, wall.rows - HOVER_HEIGHT
    place = msgspec.structs.replace(landed, row=row)
    if not fits(board, place) or at_rest(board, place) != landed:
        raise ValueError(f"{landed} cannot be reached by a drop from row {row} of this wall")
    path = [place]
    while len(path) < n_ticks:
        before = [place, *_ways_to(wall, place)]
        place = before[int(rng.integers(len(before)))]
        path.append(place)
    return tuple(reversed(path))


def _ways_to(wall: Wall, place: FallingPiece) -> list[FallingPiece]:
    """Return the places from which one primitive leads to `place`, each once."""
    board = wall.board
    starts = [
        start
        for orientation in range(len(ORIENTATION_ROWS[place.piece]))
        for column in range(wall.columns)
        if fits(board, start := FallingPiece(place.piece, orientation, place.row, column)) and start != place
    ]
    steps = (Primitive.LEFT, Primitive.RIGHT, Primitive.ROTATE)
    return [start for start in starts if any(moved(board, start, step) == place for step in steps)]


def main() -> None:
    """Read a schedule from the standard input, write its scenes to the standard output, both JSON."""
    from core.interpreting import start_interpreting

    schedule = msgspec.json.decode(sys.stdin.buffer.read(), type=Schedule)
    start_interpreting()  # faster than compiling, and all compiled code is still to be loaded
    sys.stdout.buffer.write(msgspec.json.encode(make_scenes(schedule)))


if __name__ == "__main__":
    main()
