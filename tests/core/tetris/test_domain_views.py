"""What the Tetris domain says of boards that were seen, of reachable placements, and of the oracle."""

import numpy as np
import pytest

from core.numerics.streams import stream
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.game import reachable_placements
from core.tetris.oracle import TetrisOracle
from core.tetris.pieces import uniform_piece


def played(domain: Tetris, seed: int, steps: int) -> TetrisState:
    """Return a state some random steps into an episode."""
    rng = stream(1, "played", seed)
    state = domain.initial(seed)
    for _ in range(steps):
        following = domain.transition(
            state, int(rng.integers(len(domain.choices(state).ruled_out)))
        ).next_state
        if domain.terminal(following):
            break
        state = following
    return state


def seed_with_first_piece(piece: int) -> int:
    return next(seed for seed in range(1000) if uniform_piece(seed, 0) == piece)


@pytest.mark.parametrize("seed", range(6))
def test_a_board_that_was_seen_offers_what_the_same_board_in_play_offers(seed):
    domain = Tetris(TetrisConfig(feedback_features="tamer-46"))
    state = played(domain, seed, 15)
    seen, in_play = domain.choices_on(state.columns, domain.piece(state)), domain.choices(state)
    assert np.array_equal(seen.features, in_play.features)
    assert np.array_equal(seen.feedback_features, in_play.feedback_features)


@pytest.mark.parametrize("features", ["bertsekas-21", "paper-12", "tamer-46"])
def test_the_change_between_two_boards_is_the_feedback_feature_of_the_step(features):
    domain = Tetris(TetrisConfig(feedback_features=features))
    for seed in range(4):
        state = played(domain, seed, 20)
        rows = domain.choices(state).feedback_features
        for action, row in enumerate(rows):
            after = domain.transition(state, action).next_state.columns
            assert np.array_equal(domain.feedback_difference(state.columns, after), row)


def test_an_action_is_described_by_piece_orientation_and_column():
    domain = Tetris()
    state = domain.initial(seed_with_first_piece(0))
    # I: ten upright placements come first, then seven flat ones.
    assert domain.action_record(state, 0).plain() == {"piece": 0, "orientation": 0, "column": 0}
    assert domain.action_record(state, 10).plain() == {"piece": 0, "orientation": 1, "column": 0}


def test_only_what_primitives_can_steer_to_is_offered_where_that_is_asked_for():
    config = TetrisConfig(placements="reachable")
    domain, free = Tetris(config), Tetris()
    # A wall of full height but for the two leftmost and the two rightmost columns: nothing gets across it.
    wall = (0, 0, *[(1 << 19) - 1] * 6, 0, 0)
    state = TetrisState(wall, seed_with_first_piece(0))
    offered = {tuple(placement) for placement in domain.placements(state).tolist()}
    assert offered == set(reachable_placements(wall, 0, 20)) & {
        tuple(placement) for placement in free.placements(state).tolist()
    }
    assert len(offered) < len(free.placements(state))


def test_on_an_empty_board_everything_is_reachable():
    reachable, free = Tetris(TetrisConfig(placements="reachable")), Tetris()
    for piece in range(7):
        state = free.initial(seed_with_first_piece(piece))
        assert np.array_equal(reachable.placements(state), free.placements(state))


@pytest.mark.jit
@pytest.mark.statistical
def test_the_oracle_plays_far_better_than_chance():
    config = TetrisConfig()
    domain, oracle = Tetris(config), TetrisOracle(config)
    for seed in range(3):
        state = domain.initial(seed)
        while not domain.terminal(state) and state.pieces < 250:
            state = domain.transition(state, int(np.argmax(oracle(state)))).next_state
        # 250 pieces are 1,000 cells; on a board it keeps low that is nearly 100 lines. Random play clears
        # none.
        assert not state.over
        assert state.lines >= 90


def test_the_oracle_never_prefers_a_placement_that_ends_the_game():
    config = TetrisConfig(game_over="overflow")
    domain, oracle = Tetris(config), TetrisOracle(config)
    state = played(domain, 3, 200)
    values, ruled_out = oracle(state), domain.choices(state).ruled_out
    assert np.array_equal(np.isneginf(values), ruled_out)
