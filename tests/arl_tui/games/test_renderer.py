"""Outputs become pictures; the boards in them are those of the game."""

import numpy as np
import pytest

from arl_tui.games.tetris.renderer import TetrisRenderer
from core.numerics.streams import stream
from core.tetris.afterstate import Tetris
from core.tetris.config import TetrisConfig
from core.tetris.picture import EMPTY
from tests.arl_tui.fakes import episode_started, step_taken


@pytest.mark.parametrize("seed", range(5))
def test_the_board_on_screen_is_the_board_of_the_game(seed: int) -> None:
    config = TetrisConfig()
    game = Tetris(config)
    state = game.initial(seed)
    renderer = TetrisRenderer(config)
    renderer.begin(episode_started(seed=seed))
    rng = stream(seed, "test")
    for step in range(25):
        if game.terminal(state):
            break
        choices = game.choices(state)
        allowed = np.flatnonzero(~choices.ruled_out)
        if len(allowed) == 0:
            break
        action = int(rng.choice(allowed))
        detail = game.action_record(state, action).plain()
        taken = step_taken(
            step, piece=detail["piece"], orientation=detail["orientation"], column=detail["column"]
        )
        pictures = renderer.act(taken)
        next_state = game.transition(state, action).next_state
        if not game.terminal(next_state):
            assert pictures[0].view.counts.next_piece == game.action_record(next_state, 0).plain()["piece"]
        shown = np.frombuffer(renderer.picture.cells, dtype=np.uint8).reshape(config.rows, config.columns)[
            ::-1
        ]
        columns = [sum(1 << row for row in np.flatnonzero(column != EMPTY).tolist()) for column in shown.T]
        assert columns == list(next_state.columns)
        assert renderer.picture.counts.lines == game.performance(next_state)
        state = next_state


def test_a_new_episode_clears_the_board() -> None:
    renderer = TetrisRenderer(TetrisConfig())
    renderer.begin(episode_started())
    renderer.act(step_taken(0))
    ((picture, _),) = renderer.begin(episode_started(1))
    assert set(picture.cells) == {EMPTY}
    assert picture.counts.pieces == 0
