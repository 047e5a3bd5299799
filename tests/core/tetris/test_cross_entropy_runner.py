"""Cross-entropy search on Tetris: saving pieces changes nothing but the pieces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.learners.cross_entropy import CrossEntropy, CrossEntropyConfig
from core.numerics.streams import stream
from core.tetris.config import TetrisConfig
from core.tetris.cross_entropy_runner import Evaluation, evaluate, run_iteration, undecided_games
from tests.core.tetris.playing import play_greedy

CONFIG = TetrisConfig(rows=12, columns=6)


def new_search() -> CrossEntropy:
    return CrossEntropy(CrossEntropyConfig(population=30), n_weights=13, root_seed=3)


@pytest.mark.jit
def test_the_growing_cap_leaves_the_search_as_it_would_be_with_every_game_played_out():
    capped, uncapped = new_search(), new_search()
    saved = 0
    for _ in range(8):
        seeds = stream(uncapped.root_seed, "pieces", uncapped.iteration).integers(0, 2**62, size=30)
        games = play_greedy(uncapped.population(), seeds, CONFIG)
        uncapped.update(games.lines)
        report = run_iteration(capped, CONFIG, start_cap=5)
        saved += int(games.pieces.sum()) - report.pieces
        np.testing.assert_array_equal(capped.mean, uncapped.mean)
        np.testing.assert_array_equal(capped.variance, uncapped.variance)
    assert saved > 0


@pytest.mark.jit
def test_the_first_cap_has_no_influence():
    searches = [new_search() for _ in range(3)]
    for search, cap in zip(searches, (1, 40, 100_000), strict=True):
        for _ in range(5):
            run_iteration(search, CONFIG, start_cap=cap)
    for search in searches[1:]:
        np.testing.assert_array_equal(search.mean, searches[0].mean)


def test_by_hand_which_games_are_undecided():
    lines = np.array([10, 4, 7, 7])
    finished = np.array([False, True, True, True])
    # One running game with 10 lines is certain to be among the best two; with 6 lines it is not.
    assert not undecided_games(lines, finished, 2).any()
    assert undecided_games(np.array([6, 4, 7, 7]), finished, 2).tolist() == [True, False, False, False]
    # Ahead of it are at most 2, so three places are enough (6 > 4).
    assert not undecided_games(np.array([6, 4, 7, 7]), finished, 3).any()
    # Three running games for two places.
    assert undecided_games(np.array([50, 40, 30, 1]), np.array([False, False, False, True]), 2).sum() == 3


@given(st.data())
def test_however_the_decided_games_go_on_the_elite_is_the_same(data):
    n = data.draw(st.integers(2, 8))
    elite_size = data.draw(st.integers(1, n))
    lines = np.array(data.draw(st.lists(st.integers(0, 6), min_size=n, max_size=n)))
    finished = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    if undecided_games(lines, finished, elite_size).any():
        return
    more = np.array(data.draw(st.lists(st.integers(0, 9), min_size=n, max_size=n))) * ~finished
    search = CrossEntropy(
        CrossEntropyConfig(population=n, elite_fraction=elite_size / n), n_weights=1, root_seed=1
    )
    assert search.config.elite_size == elite_size
    assert search.elite(lines).tolist() == search.elite(lines + more).tolist()


def test_a_ceiling_stops_games_that_would_go_on():
    report = run_iteration(new_search(), CONFIG, start_cap=3, piece_ceiling=6)
    assert report.pieces <= 30 * 6
    assert not report.finished.all()


def test_evaluation_is_seeded():
    weights = np.array([*[0.0] * 11, -1.0, -4.0])
    one, same, other = (evaluate(weights, CONFIG, rng=stream(seed, "e"), n_games=5) for seed in (1, 1, 2))
    assert one.lines.tolist() == same.lines.tolist() != other.lines.tolist()


def test_cut_games_are_estimated_by_lines_per_ended_game():
    cut = Evaluation(np.array([10, 30, 50]), np.array([True, True, False]), 300)
    assert cut.mean_lines == 90 / 2
    with pytest.raises(ValueError, match="none of 1 games ended"):
        _ = Evaluation(np.array([10]), np.array([False]), 30).mean_lines


@pytest.mark.jit
@pytest.mark.statistical
def test_the_estimate_from_cut_games_agrees_with_games_played_out():
    weights = np.array([*[-1.0] * 6, *[-2.0] * 5, -1.0, -8.0])
    whole = evaluate(weights, CONFIG, rng=stream(1, "whole"), n_games=600)
    assert whole.finished.all()
    cut = evaluate(weights, CONFIG, rng=stream(2, "cut"), n_games=600, piece_cap=int(whole.pieces / 600))
    assert 100 < cut.finished.sum() < 600
    # Exponential lengths: the standard error of a mean is mean / sqrt(games that ended).
    error = np.hypot(*(each.mean_lines / np.sqrt(each.finished.sum()) for each in (whole, cut)))
    # Lengths are only close to exponential (no game ends in its first pieces): 5 standard errors.
    assert abs(whole.mean_lines - cut.mean_lines) < 5 * error
