"""The game that is watched in the feedback-lag task: a real position per trial, and a piece that drops.

An expert controller plays one game. In each trial a piece enters, is moved by the paper's primitives and
drops, in the pictures of a session and at its pace: where the expert would put it (good), or in one of the
worst places (bad). The stimulus is the first picture of the drop: until then the piece might still be moved,
from then on its place is known. The next trial goes on as if the expert had placed it. Runs in a process of
its own, because the expert needs compiled code.
"""

import sys

import msgspec
import numpy as np

from core.numerics.streams import stream, stream_seed
from core.tetris.config import TetrisConfig
from core.tetris.game import FallingPiece, landing_row, reachable_placements
from core.tetris.picture import Counts, Snapshot, Wall, animate, snapshot
from core.tetris.plugin import TETRIS
from studies.reaction_time.protocol import Schedule

PIECES_BEFORE = 15
"""Pieces on the wall in the first trial: enough that good and bad differ."""
N_WORST = 3
"""A bad placement is one of this many worst ones."""


class TrialPosition(msgspec.Struct, frozen=True, kw_only=True):
    """One trial's game: pictures of a session, each shown for a tick."""

    waiting: Snapshot
    """The board before the piece enters."""
    before: tuple[Snapshot, ...]
    """From the piece's entering to the last picture before its drop."""
    event: tuple[Snapshot, ...]
    """From the first picture of the drop to the settled board, which stays."""
    note: str
    """What was shown, for the recording."""

    def at(self, ticks_left: int) -> Snapshot:
        """Return the picture that is shown so many ticks before the drop, >= 1."""
        return self.before[-ticks_left] if ticks_left <= len(self.before) else self.waiting


def tick_ms(schedule: Schedule) -> int:
    """Return how long a picture is shown: the session's pace."""
    return round(schedule.config.picture_ms or TETRIS.screen.tick_ms)


def make_positions(schedule: Schedule) -> list[TrialPosition]:
    """Return the position of each trial, in order: they follow from the schedule alone."""
    # Here, not above: compiled code, and the screen's process imports this module.
    from core.tetris.afterstate import Tetris
    from core.tetris.oracle import TetrisOracle

    config = TetrisConfig(placements="reachable")
    domain, oracle = Tetris(config), TetrisOracle(config)
    state = domain.initial(stream_seed(schedule.root_seed, "feedback-lag game"))
    wall = Wall(config.rows, config.columns)
    positions: list[TrialPosition] = []
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
            note = (
                f"piece {place.piece}, orientation {place.orientation}, column {place.column}, rank {rank} "
                f"of {len(order)}"
            )
            positions.append(position_of(wall, place.piece, (place.orientation, place.column), counts, note))
        place = domain.placement(state, best)
        filled = wall.with_piece(_resting(wall, place.piece, place.orientation, place.column))
        wall = filled.without(_full_rows(filled))
        state = domain.transition(state, best).next_state
        assert wall.board == state.columns, "the picture and the game show the same wall"
    return positions


def position_of(
    wall: Wall, piece: int, placement: tuple[int, int], counts: Counts, note: str
) -> TrialPosition:
    """Return a placement as a session draws it, cut where the drop begins.

    Args:
        wall: what has settled before.
        piece: id of the piece that enters.
        placement: (orientation, leftmost column), one that primitives can bring about.
        counts: the figures while the piece falls.
        note: for the recording.
    """
    plan = reachable_placements(wall.board, piece, wall.rows)[placement]
    # A picture per move; the last primitive of a plan is the drop.
    pictures = animate(wall, piece, placement, plan, counts=counts).frames
    moves = len(plan)
    return TrialPosition(
        waiting=snapshot(wall, counts=counts), before=pictures[:moves], event=pictures[moves:], note=note
    )


def _resting(wall: Wall, piece: int, orientation: int, column: int) -> FallingPiece:
    return FallingPiece(piece, orientation, landing_row(wall.board, piece, orientation, column), column)


def _full_rows(wall: Wall) -> tuple[int, ...]:
    return tuple(row for row, level in enumerate(wall.levels) if all(level))


def main() -> None:
    """Read a schedule from the standard input, write its positions to the standard output, both JSON."""
    from core.numerics.interpreting import start_interpreting

    schedule = msgspec.json.decode(sys.stdin.buffer.read(), type=Schedule)
    start_interpreting()  # faster than compiling, and all compiled code is still to be loaded
    sys.stdout.buffer.write(msgspec.json.encode(make_positions(schedule)))


if __name__ == "__main__":
    main()
