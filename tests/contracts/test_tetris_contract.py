"""Tetris keeps the contract of a domain, under every rule."""

import pytest

from core.tetris.afterstate import Tetris
from core.tetris.config import TetrisConfig
from tests.contracts.domain_contract import DomainContract

CONFIGS = {
    "fit before clear": TetrisConfig(),
    "reachable placements": TetrisConfig(placements="reachable"),
    "overflow": TetrisConfig(game_over="overflow"),
    "overflow, clearing, by features": TetrisConfig(
        game_over="overflow", clear_on_overflow=True, terminal_value="features"
    ),
    "small board, seven-bag, other features": TetrisConfig(
        rows=8, columns=6, pieces="seven-bag", features="paper-12", feedback_features="tamer-46"
    ),
}


class TestTetris(DomainContract):
    """All of the contract, for each set of rules."""

    @pytest.fixture(params=CONFIGS.values(), ids=CONFIGS)
    def domain(self, request):
        return Tetris(request.param)

    def test_performance_and_time_begin_at_zero(self, domain):
        assert domain.performance(domain.initial(3)) == 0
        assert domain.time(domain.initial(3)) == 0
