"""Whole games of Tetris in one call, for tests."""

from core.combination.config import EpisodeWeights
from core.tetris.autoplay import GreedyGames
from core.tetris.combined import CombinedGame
from core.tetris.config import TetrisConfig
from core.tetris.policy_gradient import PolicyGradientGame

PIECE_LIMIT = 2**40


def play_combined(
    theta, v, seed: int, config: TetrisConfig, *weights: EpisodeWeights, piece_cap=PIECE_LIMIT, **settings
) -> CombinedGame:
    """Return a game of environment and participant after its end, or `piece_cap` pieces; arguments as in
    `CombinedGame`."""
    game = CombinedGame(theta, v, seed, config, *weights, **settings)
    game.advance(piece_cap)
    return game


def play_policy_gradient(
    learner, v, seed: int, config: TetrisConfig, *weights: EpisodeWeights, piece_cap=PIECE_LIMIT, **settings
) -> PolicyGradientGame:
    """Return the game after one episode in which the learner has learned; arguments as in
    `PolicyGradientGame`."""
    game = PolicyGradientGame(learner, v, seed, config, *weights, **settings)
    game.advance(piece_cap)
    learner.end_episode()
    return game


def play_greedy(weights, seeds, config: TetrisConfig, piece_cap=PIECE_LIMIT) -> GreedyGames:
    """Play games to their end or to `piece_cap` pieces; arguments as in `GreedyGames`."""
    games = GreedyGames(weights, seeds, config)
    games.advance(piece_cap)
    return games
