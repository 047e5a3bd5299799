"""Speeds of Tetris, in CPU time on one core: medians of interleaved runs. Run with `pytest -n 0 -m
benchmark_run -s tests/benchmarks/test_tetris_speed.py`.

The slow thing beside it is the naive twin, which anybody can run. The C reference (MDPTetris, gcc -O2) was
measured at 212,592 pieces/s for the same work (greedy, 21 features, the published record weights) on the
machine the project was begun on; its program is not part of this project.
"""

import gzip
import json
import statistics
import subprocess
import sys
import time
from resource import RUSAGE_CHILDREN, getrusage

import numpy as np
import pytest

from core.combination.config import LINEAR, EpisodeWeights
from core.learners.policy_gradient import PolicyGradient, PolicyGradientConfig
from core.tetris.config import TetrisConfig
from core.tetris.policy_gradient import placement_scales
from tests.core.tetris.playing import play_combined, play_greedy, play_policy_gradient
from tests.core.tetris.test_autoplay import naive_game
from tests.data_folder import data_folder

pytestmark = pytest.mark.benchmark_run

C_REFERENCE_PIECES_PER_S = 212_592
CONFIG = TetrisConfig(game_over="overflow")


@pytest.fixture(scope="module")
def record_weights() -> np.ndarray:
    path = data_folder("tetris_oracle") / "26_record_bertsekas.jsonl.gz"
    with gzip.open(path, "rt") as lines:
        return np.array(json.loads(lines.readline())["weights"])


def pieces_per_s(play) -> float:
    """`play` returns the pieces it placed."""
    start = time.process_time()
    pieces = play()
    return pieces / (time.process_time() - start)


def test_greedy_play_places_two_million_pieces_a_second(record_weights):
    def compiled() -> int:
        return int(play_greedy(record_weights, range(30), CONFIG, piece_cap=50_000).pieces.sum())

    compiled()
    fast, slow = [], []
    for _ in range(7):
        fast.append(pieces_per_s(compiled))
        slow.append(pieces_per_s(lambda: naive_game(record_weights, 1, CONFIG, 8)[0]))
    speed, naive = statistics.median(fast), statistics.median(slow)
    print(
        f"\ngreedy: {speed:,.0f} pieces/s [{min(fast):,.0f} - {max(fast):,.0f}] = "
        f"{speed / C_REFERENCE_PIECES_PER_S:.1f} x "
        f"the C reference's recorded figure; naive twin {naive:,.0f} pieces/s"
    )
    assert speed > 4 * C_REFERENCE_PIECES_PER_S
    assert speed > 2_000_000


def test_combined_play_places_half_a_million_pieces_a_second(record_weights):
    human = record_weights * np.linspace(0.8, 1.2, 21)

    def play() -> int:
        weights = EpisodeWeights(LINEAR, 1.0, 0.5)
        return sum(
            play_combined(record_weights, human, seed, CONFIG, weights, piece_cap=50_000, window=500).pieces
            for seed in range(10)
        )

    play()
    speeds = [pieces_per_s(play) for _ in range(7)]
    print(f"\ncombined: {statistics.median(speeds):,.0f} pieces/s [{min(speeds):,.0f} - {max(speeds):,.0f}]")
    assert statistics.median(speeds) > 500_000


def test_policy_gradient_is_within_ten_times_of_greedy_play(record_weights):
    learner = PolicyGradient(PolicyGradientConfig(), scales=placement_scales(CONFIG))

    def learn() -> int:
        learner.memory.weights[:] = record_weights * learner.scales / 10.0
        return sum(
            play_policy_gradient(
                learner, np.zeros(21), seed, CONFIG, chance_seed=seed, piece_cap=20_000
            ).pieces
            for seed in range(5)
        )

    def greedy() -> int:
        return int(play_greedy(record_weights, range(5), CONFIG, piece_cap=20_000).pieces.sum())

    learn(), greedy()
    ratios, speeds = [], []
    for _ in range(7):
        speeds.append(pieces_per_s(learn))
        ratios.append(pieces_per_s(greedy) / speeds[-1])
    ratio = statistics.median(ratios)
    print(
        f"\npolicy gradient: {statistics.median(speeds):,.0f} pieces/s [{min(speeds):,.0f} - "
        f"{max(speeds):,.0f}], greedy "
        f"play has {ratio:.1f} times as many"
    )
    assert ratio < 10


def cpu_s(code: str) -> float:
    """Return the processor time of a new Python process that runs a program."""
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_a_warm_start_gives_its_first_result_within_four_times_of_importing_numba():
    first_result = (
        "import numpy as np; from core.tetris.autoplay import GreedyGames; "
        "from core.tetris.config import TetrisConfig; "
        "games = GreedyGames(-np.ones(21), [1], TetrisConfig()); games.advance(20); "
        "assert games.pieces[0] == 20"
    )
    cpu_s(first_result)  # this one may have to compile
    pairs = [(cpu_s(first_result), cpu_s("import numba")) for _ in range(5)]
    ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
    print(
        f"\nwarm start to first result: {ours:.2f} s, numba alone {theirs:.2f} s: {ours / theirs:.1f} times"
    )
    assert ours / theirs < 4.0
