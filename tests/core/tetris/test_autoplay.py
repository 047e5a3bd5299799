"""Whole games in compiled code are the games one would play step by step."""

import gzip
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.combination.agreement import Agreement
from core.combination.config import EXPONENTIAL, LINEAR, LINEAR_RAW, EpisodeWeights
from core.combination.preference import best_action, choose, takes_control, worst_action
from core.combination.tally import AGREED, agreement_of
from core.learners.linear import action_values
from core.numerics.compiled import JIT_DISABLED
from core.numerics.fixed_point import exact_weights
from core.numerics.streams import stream
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.autoplay import GreedyGames, best_of, worst_of
from core.tetris.board import piece_at
from core.tetris.config import FEATURE_SETS, TetrisConfig
from core.tetris.evaluation import grid_weights
from core.tetris.features import DELLACHERIE_WEIGHTS, DT_10_WEIGHTS, DT_20_WEIGHTS, feature_set
from core.tetris.pieces import seven_bag_piece, uniform_piece
from tests.core.tetris.playing import play_combined, play_greedy
from tests.data_folder import data_folder
from tests.naive import tetris as naive

# Plain Python plays the same games, but fewer and shorter ones.
N_SEEDS, N_PIECES = (1, 25) if JIT_DISABLED else (3, 150)

RULES = {
    "default": {},
    "overflow": {"game_over": "overflow"},
    "overflow clearing": {"game_over": "overflow", "clear_on_overflow": True},
    "overflow by features": {"game_over": "overflow", "terminal_value": "features"},
    "seven-bag": {"pieces": "seven-bag"},
    "small": {"rows": 6, "columns": 5},
    "large": {"rows": 30, "columns": 16},
}


def n_features(name: str, config: TetrisConfig) -> int:
    return len(feature_set(name, config.columns).names)


def sensible_weights(name: str, config: TetrisConfig, seed: int) -> np.ndarray:
    """Weights under which a game lasts for a while, with some noise."""
    names = feature_set(name, config.columns).names
    good = {"holes": -8.0, "maximum": -1.0, "eroded cells": 1.0, "diversity": 1.0}
    base = [good.get(n, -2.0 if "difference" in n or "transitions" in n else -0.5) for n in names]
    if name == "tamer-46":  # heights count from the top
        base = [
            0.5 if "height" in n and "squared" not in n else 0.0 if "squared" in n else b
            for n, b in zip(names, base, strict=True)
        ]
    return np.array(base) + stream(seed, "weights").normal(size=len(names)) * 0.3


def values(rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
    return action_values(rows, exact_weights(weights))


@pytest.mark.parametrize("features", FEATURE_SETS)
@pytest.mark.parametrize("rules", RULES)
def test_a_greedy_game_is_the_one_played_step_by_step(rules, features):
    config = TetrisConfig(**RULES[rules], features=features)
    domain = Tetris(config)
    for seed in range(N_SEEDS):
        weights = sensible_weights(features, config, seed)
        state = domain.initial(seed)
        while not domain.terminal(state) and state.pieces < N_PIECES:
            choices = domain.choices(state)
            n = len(choices.features)
            action = best_action(values(choices.features, weights), choices.ruled_out, n)
            state = domain.transition(state, action).next_state
        games = play_greedy(weights, [seed], config, piece_cap=N_PIECES)
        assert games.boards[0, : config.columns].tolist() == list(state.columns)
        assert (games.pieces[0], games.lines[0], games.finished[0]) == (state.pieces, state.lines, state.over)


def naive_game(weights: np.ndarray, seed: int, config: TetrisConfig, cap: int) -> tuple[int, int, bool]:
    """Pieces, lines and over of a greedy game on the slow twin, 21 features."""
    board, lines, grid = naive.empty_board(config), 0, exact_weights(weights)
    for k in range(cap):
        outcomes = naive.allowed_outcomes(board, uniform_piece(seed, k), config)
        if not outcomes:
            return k, lines, True
        loses = config.terminal_value == "minus-infinity"
        worth = [
            -np.inf if o.above and loses else float(np.dot(grid, naive.bertsekas(o.board))) for o in outcomes
        ]
        chosen = outcomes[int(np.argmax(worth))]
        board, lines = chosen.board, lines + chosen.lines
        if chosen.above:
            return k + 1, lines, True
    return cap, lines, not naive.allowed_outcomes(board, uniform_piece(seed, cap), config)


@pytest.mark.parametrize(
    "rules", ["default", "overflow", "overflow clearing", "overflow by features", "small"]
)
def test_a_greedy_game_is_that_of_the_slow_twin(rules):
    config = TetrisConfig(**RULES[rules])
    for seed in range(2):
        rng = stream(seed, "any weights")
        weights = rng.integers(-3, 4, size=n_features("bertsekas-21", config)).astype(float)
        weights[-1] = -10.0
        games = play_greedy(weights, [seed], config, piece_cap=30)
        assert (games.pieces[0], games.lines[0], games.finished[0]) == naive_game(weights, seed, config, 30)


def test_games_played_in_slices_are_the_games_played_at_once():
    config = TetrisConfig(rows=10, columns=6)
    weights = np.stack([sensible_weights("bertsekas-21", config, seed) for seed in range(5)])
    whole = play_greedy(weights, range(5), config, piece_cap=400)
    sliced = GreedyGames(weights, range(5), config)
    for cap in (1, 2, 50, 51, 300, 400):
        sliced.advance(cap)
    np.testing.assert_array_equal(sliced.boards, whole.boards)
    np.testing.assert_array_equal(sliced.lines, whole.lines)
    np.testing.assert_array_equal(sliced.pieces, whole.pieces)
    np.testing.assert_array_equal(sliced.finished, whole.finished)


def test_each_game_has_its_own_cap_and_policy():
    config = TetrisConfig()
    weights = np.stack([sensible_weights("bertsekas-21", config, seed) for seed in range(3)])
    games = play_greedy(weights, [7, 7, 7], config, piece_cap=[5, 0, 20])
    assert games.pieces.tolist() == [5, 0, 20]
    alone = play_greedy(weights[2], [7], config, piece_cap=20)
    np.testing.assert_array_equal(games.boards[2], alone.boards[0])


def test_the_same_seed_deals_the_same_pieces_to_every_policy_in_kernels_and_in_python():
    for seed in (0, 1, 2**63 - 1):
        for k in (0, 1, 5, 6, 7, 1_000_003):
            assert piece_at(seed, k, 0) == uniform_piece(seed, k)
            assert piece_at(seed, k, 1) == seven_bag_piece(seed, k)


@given(st.lists(st.integers(-3, 3).map(float), min_size=1, max_size=40))
def test_the_short_cut_finds_the_same_best_and_worst_action(row):
    values_, none = np.array(row), np.zeros(len(row), dtype=bool)
    assert best_of(values_, len(row)) == best_action(values_, none, len(row))
    assert worst_of(values_, len(row)) == worst_action(values_, none, len(row))


COMBINATIONS = {
    "environment": EpisodeWeights(LINEAR, 1.0, 0.0),
    "linear": EpisodeWeights(LINEAR, 1.0, 0.4),
    "adversary": EpisodeWeights(LINEAR, 1.0, -0.3),
    "raw": EpisodeWeights(LINEAR_RAW, 1.0, 0.7),
    "exponential": EpisodeWeights(EXPONENTIAL, 1.0, 0.5),
    "human": EpisodeWeights(LINEAR, 0.0, 1.0),
    "shared": EpisodeWeights(LINEAR, 1.0, 0.0, handover=0.4),
}


@pytest.mark.parametrize("combination", COMBINATIONS)
@pytest.mark.parametrize("rules", ["default", "overflow", "small"])
@pytest.mark.parametrize("feedback", ["bertsekas-21", "tamer-46"])
def test_a_combined_episode_is_the_one_played_step_by_step(rules, combination, feedback):
    config = TetrisConfig(**RULES[rules], feedback_features=feedback)
    weighted = COMBINATIONS[combination]
    theta = sensible_weights("bertsekas-21", config, 1)
    v = sensible_weights(feedback, config, 2)
    domain = Tetris(config)
    state, boards, agree, agree_worst = domain.initial(3), [], 0, 0
    while not domain.terminal(state) and state.pieces < 120:
        boards.append(list(state.columns))
        choices = domain.choices(state)
        n = len(choices.features)
        r, h = values(choices.features, theta), values(choices.feedback_features, v)
        human = best_action(h, choices.ruled_out, n)
        agree += best_action(r, choices.ruled_out, n) == human
        agree_worst += best_action(r, choices.ruled_out, n) == worst_action(h, choices.ruled_out, n)
        action = choose(r, h, choices.ruled_out, n, weighted.form, weighted.w_r, weighted.w_h)
        if weighted.handover > 0 and takes_control(99, state.pieces, weighted.handover):
            action = human
        state = domain.transition(state, action).next_state
    game = play_combined(theta, v, 3, config, weighted, handover_seed=99, piece_cap=120, window=25)
    assert (game.pieces, game.lines, game.finished) == (state.pieces, state.lines, state.over)
    assert game.tally.tolist() == [state.pieces, agree, agree_worst]
    recent = range(max(0, game.pieces - 25), game.pieces)
    assert [list(game.kept(decision)[0]) for decision in recent] == boards[-25:]


def test_the_window_hands_back_states_whose_choices_can_be_looked_at_again():
    config = TetrisConfig()
    theta = sensible_weights("bertsekas-21", config, 1)
    game = play_combined(theta, theta, 3, config, piece_cap=40, window=10)
    domain = Tetris(config)
    for k in range(game.pieces - 10, game.pieces):
        state = TetrisState(game.kept(k)[0], 3, k)
        assert len(domain.choices(state).features) == len(domain.placements(state))


def test_an_environment_that_is_the_human_agrees_with_it_in_every_decision():
    theta = sensible_weights("bertsekas-21", TetrisConfig(), 4)
    game = play_combined(theta, theta, 5, TetrisConfig(), piece_cap=100)
    # Changes of the same features under the same weights: the same order of the actions.
    assert agreement_of(game.tally) == Agreement(100, 100, 0)
    opposite = play_combined(theta, -theta, 5, TetrisConfig(), piece_cap=100)
    assert opposite.tally[AGREED] == 0


def test_with_no_weight_on_the_human_a_combined_episode_is_the_greedy_game():
    theta = sensible_weights("bertsekas-21", TetrisConfig(), 4)
    game = play_combined(theta, np.ones(21), 5, TetrisConfig(), piece_cap=200)
    games = play_greedy(theta, [5], TetrisConfig(), piece_cap=200)
    assert (game.lines, game.pieces) == (games.lines[0], games.pieces[0])


def test_multiplying_the_weights_by_a_power_of_two_changes_no_game():
    theta = sensible_weights("bertsekas-21", TetrisConfig(), 6)
    one, other = (
        play_greedy(theta * factor, [1], TetrisConfig(), piece_cap=300) for factor in (1.0, 2.0**-9)
    )
    np.testing.assert_array_equal(one.boards, other.boards)


@pytest.mark.jit
@pytest.mark.parametrize("weights", [DELLACHERIE_WEIGHTS, DT_10_WEIGHTS, DT_20_WEIGHTS])
def test_the_published_controllers_survive_a_hundred_thousand_pieces(weights):
    # Published means: 660,000 lines (Dellacherie) and tens of millions; 100,000 pieces are 40,000 lines.
    # With an exponential length of 660,000 a game ends within 40,000 lines in 6 % of all cases.
    config = TetrisConfig(features="dellacherie-thiery")
    games = play_greedy(np.array(weights), [11], config, piece_cap=100_000)
    assert not games.finished[0]
    assert games.lines[0] == pytest.approx(40_000, abs=20)


@pytest.mark.jit
@pytest.mark.statistical
def test_the_record_policy_clears_as_many_lines_as_the_reference_measured():
    path = data_folder("tetris_oracle") / "26_record_bertsekas.jsonl.gz"
    with gzip.open(path, "rt") as lines:
        weights = np.array(json.loads(lines.readline())["weights"])
    games = play_greedy(weights, np.arange(8), TetrisConfig(game_over="overflow"))
    # Reference: 129,055 +- 12,993 lines over 60 games. Lengths are about exponential: our standard error is
    # mean / sqrt(8) = 45,600; together 47,400; allow 2.5 of them (a rule that differs changes it sevenfold).
    assert games.finished.all()
    assert games.lines.mean() == pytest.approx(129_055, abs=2.5 * 47_400)


@pytest.mark.parametrize(
    ("weights", "seeds", "message"),
    [
        (np.zeros(20), [1], "needs weights of shape"),
        (np.zeros((2, 21)), [1, 2, 3], "needs weights of shape"),
        (np.zeros(21), [-1], "seeds are numbers >= 0"),
        (np.full(21, np.nan), [1], "finite"),
    ],
)
def test_games_that_cannot_be_set_up_are_refused(weights, seeds, message):
    with pytest.raises(ValueError, match=message):
        GreedyGames(weights, seeds, TetrisConfig())


def test_a_combined_episode_cannot_value_lines_apart():
    with pytest.raises(ValueError, match="lines_in_value"):
        play_combined(np.zeros(21), np.zeros(21), 1, TetrisConfig(lines_in_value=True))
    with pytest.raises(ValueError, match="needs 21 weights"):
        play_combined(np.zeros(12), np.zeros(21), 1, TetrisConfig())


@pytest.mark.parametrize("n", [1, 5])
def test_one_policy_in_all_games_has_the_types_of_one_policy_each(n):
    # Another order of the array would be another type, for which the dearest kernel were compiled once more.
    one = np.arange(22.0)
    repeated, _ = grid_weights(np.broadcast_to(one, (n, 22)), 0.0)
    each, _ = grid_weights(np.tile(one, (n, 1)), 0.0)
    assert repeated.flags.c_contiguous
    assert each.flags.c_contiguous
    assert np.array_equal(repeated, each)
