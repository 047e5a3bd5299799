"""What simulated people know of Tetris."""

import numpy as np
import pytest

from core.numerics.streams import stream_seed
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.oracle import KNOWLEDGE_WEIGHTS, TetrisOracle
from tests.core.tetris.playing import play_greedy

CONFIG = TetrisConfig()
# Column 0 is 2 high over a hole in row 0; the rest of row 0 is full but for column 9.
COLUMNS = (0b10, *[0b1] * 8, 0)


def piece_state(piece: int) -> TetrisState:
    """A state on COLUMNS whose next piece is `piece`."""
    domain = Tetris(CONFIG)
    seed = next(s for s in range(200) if domain.piece(TetrisState(COLUMNS, s)) == piece)
    return TetrisState(COLUMNS, seed)


def test_values_by_hand():
    """An I piece upright in column 9: landing height 1.5, nothing removed (a hole is left in row 0), no new
    hole."""
    state, domain = piece_state(0), Tetris(CONFIG)
    upright = [tuple(p) for p in domain.placements(state)]
    tall = next(i for i, (_, left) in enumerate(upright) if left == 9)
    # landing height is the mean row of the piece: rows 0..3, 1.5; the board's one hole remains
    assert TetrisOracle(CONFIG, "lay")(state)[tall] == pytest.approx(-1.5 - 1.0)
    assert TetrisOracle(CONFIG, "myopic")(state)[tall] == pytest.approx(-1.5)


def test_a_lay_person_minds_holes_and_a_myopic_one_does_not():
    state, domain = piece_state(0), Tetris(CONFIG)
    holes = domain.choices(state).features[:, -1]
    lay, myopic = TetrisOracle(CONFIG, "lay")(state), TetrisOracle(CONFIG, "myopic")(state)
    np.testing.assert_allclose(myopic - lay, holes)
    assert len(set(holes)) > 1


@pytest.mark.jit
def test_the_expert_plays_better_than_the_lay_person_and_that_one_better_than_the_myopic():
    config = TetrisConfig(features="dellacherie-thiery")
    seeds = [stream_seed(1, "games", k) for k in range(20)]
    lines = {
        name: play_greedy(np.array(weights), seeds, config, piece_cap=5000).lines.mean()
        for name, weights in KNOWLEDGE_WEIGHTS.items()
    }
    assert lines["expert"] > 10 * lines["lay"]
    assert lines["lay"] > 2 * lines["myopic"]
