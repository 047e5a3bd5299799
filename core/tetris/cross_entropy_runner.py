"""The cross-entropy method on Tetris: populations played in compiled code, and no piece more than needed.

An iteration needs to know which samples are the elite, not how long their games would have gone on. Games are
played to a cap in pieces that doubles until that is certain: whatever the games still running would come to,
the elite would be the same. So the search is the one that plays every game to its end (tested), and its worst
iteration costs what the best sample outside the elite costs. Budgets are in pieces, never in seconds.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.learners.cross_entropy import CrossEntropy
from core.numerics.streams import stream
from core.tetris.autoplay import GreedyGames
from core.tetris.config import TetrisConfig

START_CAP = 2_500
"""Pieces of the first round: about 1,000 lines."""
PIECE_CEILING = 2_000_000
"""No game of a sample is played further: for rules under which a policy might never lose. Samples that get
there count with the lines they have."""
N_EVALUATION_GAMES = 30
"""Games of the mean vector after each iteration (Szita & Lorincz 2006)."""


@dataclass(frozen=True, slots=True, eq=False)
class IterationReport:
    """What an iteration cost and came to."""

    iteration: int
    """Number of the iteration that ended, from 1."""
    lines: NDArray[np.int64]
    """Lines of each sample, shape (population,); of an unfinished game, lines so far."""
    finished: NDArray[np.bool_]
    """Whether the sample's game ended, shape (population,); the rest are certain to be elite (or at the
    ceiling)."""
    pieces: int
    """Pieces placed in all games."""


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """Games of one policy, some of them perhaps cut by a cap."""

    lines: NDArray[np.int64]
    """Lines of each game, shape (n,)."""
    finished: NDArray[np.bool_]
    """Whether it ended, shape (n,)."""
    pieces: int
    """Pieces placed in all games."""

    @property
    def mean_lines(self) -> float:
        """Lines per game: the plain mean, or with cut games the estimate for exponential lengths.

        Lengths of a policy's games are close to exponential, for which the maximum-likelihood mean under a
        cap is all lines over the number of games that ended.

        Raises:
            ValueError: no game ended; `lines.sum()` is all that is known from below.
        """
        ended = int(self.finished.sum())
        if ended == 0:
            raise ValueError(
                f"none of {len(self.lines)} games ended, so their mean is unknown: more than "
                f"{self.lines.mean():.0f} lines; raise the cap"
            )
        return float(self.lines.sum() / ended)


def run_iteration(
    search: CrossEntropy,
    config: TetrisConfig,
    *,
    start_cap: int = START_CAP,
    piece_ceiling: int = PIECE_CEILING,
) -> IterationReport:
    """Play one game with each sample of the search's population and let the search move to the elite.

    Args:
        search: the distribution over weights of `config.features`; moved on by one iteration.
        config: board and rules.
        start_cap: pieces of the first round, >= 1; has no influence on the search.
        piece_ceiling: no game is played further than this.
    """
    if not 1 <= start_cap <= piece_ceiling:
        raise ValueError(f"need 1 <= start_cap <= piece_ceiling, got {start_cap} and {piece_ceiling}")
    samples = search.population()
    seeds = stream(search.root_seed, "pieces", search.iteration).integers(0, 2**62, size=len(samples))
    games = GreedyGames(samples, seeds, config)
    caps = np.full(len(samples), start_cap, dtype=np.int64)
    while True:
        games.advance(caps)
        undecided = undecided_games(games.lines, games.finished, search.config.elite_size)
        undecided &= games.pieces < piece_ceiling
        if not undecided.any():
            break
        caps[undecided] = np.minimum(2 * caps[undecided], piece_ceiling)
    search.update(games.lines)
    return IterationReport(search.iteration, games.lines, games.finished, int(games.pieces.sum()))


def undecided_games(
    lines: NDArray[np.int64], finished: NDArray[np.bool_], elite_size: int
) -> NDArray[np.bool_]:
    """Return the running games that might still end either inside or outside the elite.

    Lines only grow, and of equal games the first one is better. So a running game is certain to be elite
    where fewer than `elite_size` others can ever be ahead of what it has already.

    Args:
        lines: so far, shape (n,).
        finished: whether these are final, shape (n,).
        elite_size: 1..n.
    """
    running = np.flatnonzero(~finished)
    if len(running) > elite_size:
        return np.asarray(~finished)
    # Running games can all be ahead; of the finished ones those that are ahead now.
    room = elite_size - len(running)
    done = np.flatnonzero(finished)
    ranked = done[np.argsort(-lines[done], kind="stable")]
    undecided = np.zeros(len(lines), dtype=np.bool_)
    if len(ranked) > room:
        best_outside = ranked[room]
        behind = (lines[running] < lines[best_outside]) | (
            (lines[running] == lines[best_outside]) & (running > best_outside)
        )
        undecided[running[behind]] = True
    return undecided


def evaluate(
    weights: NDArray[np.float64],
    config: TetrisConfig,
    *,
    rng: np.random.Generator,
    n_games: int = N_EVALUATION_GAMES,
    piece_cap: int = PIECE_CEILING,
) -> Evaluation:
    """Play `n_games` fresh games of one policy, each to its end or to `piece_cap` pieces.

    Args:
        weights: under `config.features`, shape (F,).
        config: board and rules.
        rng: deals the seeds of the games.
        n_games: >= 1.
        piece_cap: >= 1.
    """
    games = GreedyGames(weights, rng.integers(0, 2**62, size=n_games), config)
    games.advance(piece_cap)
    return Evaluation(games.lines, games.finished, int(games.pieces.sum()))
