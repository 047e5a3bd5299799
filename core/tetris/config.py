"""The rules of a Tetris game and what is seen of it, as one frozen record. No compiled code is imported."""

from typing import Annotated, Literal

import msgspec

from core.configuration.fields import number, one_of
from core.plugins import DomainConfig

GameOverRule = Literal["fit-before-clear", "overflow"]
TerminalValue = Literal["minus-infinity", "features"]
PieceStream = Literal["uniform", "seven-bag"]
Placements = Literal["all", "reachable"]

FEATURE_SETS: tuple[str, ...] = ("bertsekas-21", "paper-12", "dellacherie-thiery", "tamer-46")
"""Names of the feature sets; `core.tetris.features` defines them."""

MIN_COLUMNS, MAX_COLUMNS = 4, 16
MIN_ROWS, MAX_ROWS = 4, 40


class TetrisConfig(msgspec.Struct, DomainConfig, frozen=True, forbid_unknown_fields=True, tag="tetris"):
    """Board, rules and features of a Tetris domain."""

    rows: Annotated[int, number("rows", ge=MIN_ROWS, le=MAX_ROWS)] = 20
    """Height of the board, 4..40. 20 as in the paper (section 4) and in nearly all studies."""
    columns: Annotated[int, number("columns", ge=MIN_COLUMNS, le=MAX_COLUMNS)] = 10
    """Width of the board, 4..16. 10 as in the paper."""
    game_over: GameOverRule = "fit-before-clear"
    """When a game ends. fit-before-clear: a piece must lie fully inside before full rows are removed; a game
    ends when the next piece fits nowhere. overflow: any placement is allowed, and the game ends when the wall
    is higher than the board after full rows are removed (MDPTetris, "simplified"). The paper does not say;
    the default is the rule that leaves no doubt about rows above the board."""
    clear_on_overflow: bool = False
    """overflow only: whether full rows are removed when the piece sticks out above the board. MDPTetris has
    both; its library's default is False."""
    terminal_value: TerminalValue = "minus-infinity"
    """overflow only: value of a placement that ends the game: minus-infinity (never chosen while another
    exists) or that of its features. The default because cross-entropy search from N(0, 100) often never
    starts otherwise (docs/decisions/tetris-rules.md)."""
    pieces: PieceStream = "uniform"
    """uniform: independent, equally likely (Bertsekas & Ioffe 1996 and all since); seven-bag: each seven in
    a row are the seven pieces shuffled (today's commercial games)."""
    placements: Placements = "all"
    """Which placements are offered: all that a straight drop allows (as in all work on placements), or only
    those that the paper's primitive actions can steer the falling piece to. Whole games in compiled code
    (`core.tetris.autoplay`) always offer all; on boards below the top rows the two are the same."""
    lines_in_value: bool = False
    """Whether the lines a placement clears are added to its value (an option of MDPTetris). Only for given
    policies played by `core.tetris.autoplay`: a learner that sees features alone could not add them."""
    features: Annotated[str, one_of(FEATURE_SETS)] = "bertsekas-21"
    """Feature set of the environment's learner; the paper's "21 features", section 4."""
    feedback_features: Annotated[str, one_of(FEATURE_SETS)] = "bertsekas-21"
    """Feature set whose differences (afterstate minus board before) the human reward model sees; differences
    as in TAMER (Knox & Stone 2009)."""

    def __post_init__(self) -> None:
        _check_range("rows", self.rows, MIN_ROWS, MAX_ROWS)
        _check_range("columns", self.columns, MIN_COLUMNS, MAX_COLUMNS)
        _check_choice("game_over", self.game_over, ("fit-before-clear", "overflow"))
        _check_choice("terminal_value", self.terminal_value, ("minus-infinity", "features"))
        _check_choice("pieces", self.pieces, ("uniform", "seven-bag"))
        _check_choice("placements", self.placements, ("all", "reachable"))
        _check_choice("features", self.features, FEATURE_SETS)
        _check_choice("feedback_features", self.feedback_features, FEATURE_SETS)
        if self.game_over == "fit-before-clear" and (
            self.clear_on_overflow or self.terminal_value == "features"
        ):
            raise ValueError(
                "clear_on_overflow and terminal_value='features' speak of pieces above the board; "
                "fit-before-clear never offers such a placement: use game_over='overflow'"
            )


def _check_range(name: str, value: int, lowest: int, highest: int) -> None:
    if not lowest <= value <= highest:
        raise ValueError(f"{name} of a Tetris board is {lowest}..{highest}, got {value}")


def _check_choice(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise ValueError(f"{name} is one of {', '.join(known)}; got {value!r}")
