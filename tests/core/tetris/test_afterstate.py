"""Placements, features and rules, against the slow twin and by hand."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import FEATURE_SETS, TetrisConfig
from core.tetris.pieces import N_PIECES, PIECE_NAMES
from tests.naive import tetris as naive

I, O, T, Z, S, J, L = range(N_PIECES)


class WithPiece(Tetris):
    """Tetris in which the next piece is always the same."""

    def __init__(self, config: TetrisConfig, piece: int) -> None:
        super().__init__(config)
        self._piece = lambda seed, k: piece


def state_of(rows: list[str]) -> TetrisState:
    """A board drawn from the top; X = filled."""
    upwards = rows[::-1]
    columns = range(len(rows[0]))
    return TetrisState(
        tuple(sum((row[c] == "X") << level for level, row in enumerate(upwards)) for c in columns), 0
    )


@st.composite
def rules(draw) -> TetrisConfig:
    overflow = draw(st.booleans())
    return TetrisConfig(
        rows=draw(st.integers(4, 14)),
        columns=draw(st.sampled_from([4, 5, 6, 10, 16])),
        game_over="overflow" if overflow else "fit-before-clear",
        clear_on_overflow=overflow and draw(st.booleans()),
        terminal_value="features" if overflow and draw(st.booleans()) else "minus-infinity",
        features=draw(st.sampled_from(FEATURE_SETS)),
        feedback_features=draw(st.sampled_from(FEATURE_SETS)),
    )


@st.composite
def boards(draw, config: TetrisConfig) -> tuple[int, ...]:
    """A board without full rows, often crowded and one cell short of full rows."""
    height = draw(st.integers(0, config.rows))
    rows = [draw(st.integers(0, 2**config.columns - 1)) for _ in range(height)]
    full = 2**config.columns - 1
    for level in range(height):
        if draw(st.booleans()):
            rows[level] = full
        if rows[level] == full:
            rows[level] ^= 1 << draw(st.integers(0, config.columns - 1))
    return tuple(
        sum((row >> c & 1) << level for level, row in enumerate(rows)) for c in range(config.columns)
    )


@settings(max_examples=120)
@given(st.data())
def test_choices_are_those_of_the_slow_twin(data):
    config = data.draw(rules())
    columns = data.draw(boards(config))
    piece = data.draw(st.integers(0, N_PIECES - 1))
    board = naive.board_from_columns(columns, config)
    expected = naive.allowed_outcomes(board, piece, config)
    domain, state = WithPiece(config, piece), TetrisState(columns, 0)
    if not expected:
        with pytest.raises(ValueError, match="at least one action"):
            domain.choices(state)
        return
    choices = domain.choices(state)
    assert domain.placements(state).tolist() == [[o.orientation, o.column] for o in expected]
    loses = config.terminal_value == "minus-infinity"
    assert choices.ruled_out.tolist() == [o.above and loses for o in expected]
    before = np.array(naive.features(config.feedback_features, board, config, None))
    for action, outcome in enumerate(expected):
        np.testing.assert_allclose(
            choices.features[action],
            naive.features(config.features, outcome.board, config, outcome),
            rtol=1e-14,
        )
        after = np.array(naive.features(config.feedback_features, outcome.board, config, outcome))
        np.testing.assert_allclose(choices.feedback_features[action], after - before, rtol=1e-12, atol=1e-9)


@settings(max_examples=80)
@given(st.data())
def test_a_placement_leaves_the_board_of_the_slow_twin(data):
    config = data.draw(rules())
    columns = data.draw(boards(config))
    piece = data.draw(st.integers(0, N_PIECES - 1))
    board = naive.board_from_columns(columns, config)
    domain, state = WithPiece(config, piece), TetrisState(columns, 0)
    for action, outcome in enumerate(naive.allowed_outcomes(board, piece, config)):
        transition = domain.transition(state, action)
        after = transition.next_state
        assert (naive.board_from_columns(after.columns, config) == outcome.board).all()
        assert (transition.reward, after.lines, after.k) == (outcome.lines, outcome.lines, 1)
        if config.game_over == "overflow":
            assert after.over == outcome.above
        else:
            assert after.over == (not naive.allowed_outcomes(outcome.board, piece, config))
        described = domain.placement(state, action)
        assert (described.orientation, described.column, described.row) == (
            outcome.orientation,
            outcome.column,
            outcome.landing_row,
        )


@settings(max_examples=60)
@given(st.data())
def test_cells_are_neither_made_nor_lost(data):
    config = data.draw(rules())
    columns = data.draw(boards(config))
    domain = WithPiece(config, data.draw(st.integers(0, N_PIECES - 1)))
    state = TetrisState(columns, 0)
    try:
        n_actions = len(domain.choices(state).features)
    except ValueError:
        return
    cells = sum(column.bit_count() for column in columns)
    for action in range(n_actions):
        transition = domain.transition(state, action)
        after = sum(column.bit_count() for column in transition.next_state.columns)
        assert after == cells + 4 - config.columns * transition.reward


def test_an_i_dropped_into_a_gap_clears_the_row_by_hand():
    state = state_of(["XX........", "XXXXXXXXX."])
    domain = WithPiece(TetrisConfig(), I)
    placements = domain.placements(state).tolist()
    after = domain.transition(state, placements.index([0, 9]))
    assert after.reward == 1.0
    # The upright I fills the gap; its upper three cells come down by one row.
    assert after.next_state.columns == (1, 1, 0, 0, 0, 0, 0, 0, 0, 0b111)


def test_the_21_features_by_hand():
    # heights 3 1 0 0 0 0 0 0 0 2, holes: one in column 0
    state = state_of(["X.........", "..........", "..........", "X........X", ".X.......X"])
    domain = WithPiece(TetrisConfig(), O)
    placements = domain.placements(state).tolist()
    row = domain.choices(state).features[placements.index([0, 4])]
    # the O lies on columns 4 and 5: heights 5 1 0 0 2 2 0 0 0 2
    assert row[:10].tolist() == [5, 1, 0, 0, 2, 2, 0, 0, 0, 2]
    assert row[10:19].tolist() == [4, 1, 0, 2, 0, 2, 0, 0, 2]
    # Column 0 has cells in rows 1 and 4: empty below them are rows 0, 2, 3.
    assert row[19:].tolist() == [5, 3]


def test_the_46_features_of_tamer_by_hand():
    state = state_of(["X.X.......", "X.X.......", "X.X......."])
    config = TetrisConfig(feedback_features="tamer-46", features="tamer-46")
    domain = WithPiece(config, O)
    row = domain.choices(state).features[domain.placements(state).tolist().index([0, 6])]
    # Row index of the top from the top: 20 - 3 = 17; empty columns 20; the O at columns 6, 7: 18.
    assert row[:10].tolist() == [17, 20, 17, 20, 20, 20, 18, 18, 20, 20]
    assert row[10] == 17
    assert row[11:20].tolist() == [3, 3, 3, 0, 0, 2, 0, 2, 0]
    # No hole; one well, column 1, three deep.
    assert row[20:23].tolist() == [0, 3, 3]
    # Squares: of heights and maximum by 100.
    assert row[23] == pytest.approx(17 * 17 / 100)
    assert row[33] == pytest.approx(17 * 17 / 100)
    assert row[34] == 9
    assert row[44:].tolist() == [9, 9]


def test_where_a_piece_must_fit_it_may_not_stick_out_even_if_it_would_clear():
    # Four rows on four columns; the right column is open. An upright I would clear one row but needs four
    # rows.
    config = TetrisConfig(rows=4, columns=4)
    state = state_of(["....", ".XXX", ".XXX", "X.XX"])
    placements = WithPiece(config, I).placements(state).tolist()
    assert placements == [[1, 0]]


def test_the_rule_on_clearing_above_the_top_decides_between_going_on_and_the_end():
    # A J upright in the left column sticks out above row 4 but fills the two upper rows.
    board = state_of([".XXX", ".XXX", "X.XX", "X.XX"])
    for clears, over in ((False, True), (True, False)):
        config = TetrisConfig(rows=4, columns=4, game_over="overflow", clear_on_overflow=clears)
        domain = WithPiece(config, I)
        action = domain.placements(board).tolist().index([0, 0])
        after = domain.transition(board, action)
        assert after.next_state.over is over
        assert after.reward == (2.0 if clears else 0.0)
        assert domain.choices(board).ruled_out[action] == over


def test_a_game_without_a_way_out_offers_ruled_out_actions_and_ends():
    config = TetrisConfig(rows=4, columns=4, game_over="overflow")
    domain, state = WithPiece(config, O), state_of([".XXX", "X.XX", ".XXX", "X.XX"])
    choices = domain.choices(state)
    assert choices.ruled_out.all()
    assert domain.transition(state, 0).next_state.over


def test_a_state_says_what_comes_next():
    domain = Tetris()
    state = domain.initial(7)
    assert domain.piece(state, ahead=1) == domain.piece(domain.transition(state, 0).next_state)
    assert {PIECE_NAMES[domain.piece(state, ahead=n)] for n in range(60)} == set(PIECE_NAMES)


def test_a_game_that_is_over_refuses_every_question():
    domain, state = Tetris(), TetrisState((0,) * 10, 0, over=True)
    assert domain.terminal(state)
    for question in (domain.choices, domain.placements):
        with pytest.raises(ValueError, match="the game is over"):
            question(state)


def test_lines_in_the_value_are_refused_where_a_learner_could_not_see_them():
    with pytest.raises(ValueError, match="lines_in_value"):
        Tetris(TetrisConfig(lines_in_value=True))


@pytest.mark.parametrize(
    ("settings_", "message"),
    [
        ({"rows": 3}, "rows of a Tetris board"),
        ({"rows": 41}, "rows of a Tetris board"),
        ({"columns": 3}, "columns of a Tetris board"),
        ({"columns": 17}, "columns of a Tetris board"),
        ({"features": "none"}, "features is one of"),
        ({"game_over": "never"}, "game_over is one of"),
        ({"clear_on_overflow": True}, "fit-before-clear never offers"),
        ({"terminal_value": "features"}, "fit-before-clear never offers"),
    ],
)
def test_senseless_rules_are_refused(settings_, message):
    with pytest.raises(ValueError, match=message):
        TetrisConfig(**settings_)


def test_every_feature_set_has_distinct_names_on_every_width():
    for name, columns in itertools.product(FEATURE_SETS, (4, 10, 16)):
        domain = Tetris(TetrisConfig(columns=columns, features=name))
        names = domain.feature_names
        assert len(set(names)) == len(names)
    assert [len(Tetris(TetrisConfig(features=name)).feature_names) for name in FEATURE_SETS] == [
        21,
        12,
        9,
        46,
    ]
