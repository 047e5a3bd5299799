"""Tetris as a domain whose actions are placements, seen by what they leave behind."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.domain import Choices, Transition
from core.numerics.arrays import Ints
from core.numerics.compiled import kernel
from core.tetris.action import PlacedPiece
from core.tetris.board import (
    AFTER,
    COLUMNS,
    FEATURES,
    FEATURES_BEFORE,
    LEFT,
    MAX_PLACEMENTS,
    NOW,
    OVERFLOW,
    ROW,
    ROWS,
    SHAPE,
    fill_heights,
    mark_above,
    mark_ruled_out,
    new_work,
    place,
    rule_codes,
    scan_placements,
    wall_height,
)
from core.tetris.config import TetrisConfig
from core.tetris.features import NO_MOVE, feature_set, fill_after, fill_features
from core.tetris.game import reachable_mask
from core.tetris.pieces import FIRST_SHAPE, seven_bag_piece, uniform_piece


@dataclass(frozen=True, slots=True)
class TetrisState:
    """A board with a piece to be placed. Every later piece follows from `seed` and `k`."""

    columns: tuple[int, ...]
    """Bit masks of the columns from the left, bit r = row r from the bottom."""
    seed: int
    """Seed of the episode's piece stream."""
    k: int = 0
    """Number of the piece to be placed = pieces placed so far."""
    lines: int = 0
    """Lines cleared so far."""
    over: bool = False
    """Whether the game has ended."""

    @property
    def pieces(self) -> int:
        """Pieces placed so far."""
        return self.k


@dataclass(frozen=True, slots=True)
class Placement:
    """One way to put a piece down."""

    piece: int
    """Id, 0..6."""
    orientation: int
    """Quarter turns counter-clockwise."""
    column: int
    """Leftmost column."""
    row: int
    """Landing row: of the piece's lowest cell, before full rows are removed."""


class Tetris:
    """The domain: `choices` in MDPTetris' order, exact features, rules from a `TetrisConfig`."""

    name = "tetris"

    def __init__(self, config: TetrisConfig | None = None) -> None:
        """Take the rules; the default ones where `config` is None.

        Raises:
            ValueError: `lines_in_value` is on, which no learner of features could follow.
        """
        self.config = config if config is not None else TetrisConfig()
        if self.config.lines_in_value:
            raise ValueError(
                "lines_in_value is for given policies only (core.tetris.autoplay), not for a domain"
            )
        self._rules = rule_codes(self.config)
        self._features = feature_set(self.config.features, self.config.columns)
        self._feedback = feature_set(self.config.feedback_features, self.config.columns)
        self._piece = uniform_piece if self.config.pieces == "uniform" else seven_bag_piece

    @property
    def feature_names(self) -> tuple[str, ...]:
        """Names of the environment learner's features."""
        return self._features.names

    @property
    def observation_names(self) -> tuple[str, ...]:
        """Return nothing: placements are seen by what they leave behind."""
        return ()

    @property
    def feedback_feature_names(self) -> tuple[str, ...]:
        """Names of the features whose differences the human reward model sees."""
        return self._feedback.names

    def piece(self, state: TetrisState, ahead: int = 0) -> int:
        """Return the piece to be placed, or the one `ahead` pieces later."""
        return self._piece(state.seed, state.k + ahead)

    def initial(self, episode_seed: int) -> TetrisState:
        """Return an empty board; `episode_seed` in [0, 2**63)."""
        if not 0 <= episode_seed < 2**63:
            raise ValueError(f"an episode's seed is in [0, 2**63), got {episode_seed}")
        return TetrisState((0,) * self.config.columns, episode_seed)

    def terminal(self, state: TetrisState) -> bool:
        """Return whether the game is over, or no placement can be reached where that is asked for."""
        return state.over or (self.config.placements == "reachable" and len(self._scan(state)[1]) == 0)

    def _scan(self, state: TetrisState) -> tuple[Ints, NDArray[np.int64], NDArray[np.bool_]]:
        """Return working memory, the allowed actions' places in it, and which of them are ruled out."""
        if state.over:
            raise ValueError("the game is over: a terminal state has no actions")
        work, allowed, ruled_out = self._scan_board(state.columns, self.piece(state))
        if self.config.placements == "all":
            return work, allowed, ruled_out
        piece = self.piece(state)
        placements = np.column_stack([work[SHAPE, allowed] - FIRST_SHAPE[piece], work[LEFT, allowed]])
        reachable = reachable_mask(state.columns, piece, placements, self.config.rows)
        return work, allowed[reachable], ruled_out[reachable]

    def _scan_board(
        self, columns: tuple[int, ...], piece: int
    ) -> tuple[Ints, NDArray[np.int64], NDArray[np.bool_]]:
        work = new_work(columns)
        ruled_out = np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
        n, n_open = _scan_and_rule(work, self._rules, piece, ruled_out)
        if self._rules[OVERFLOW] == 0:
            allowed = np.flatnonzero(~ruled_out[:n])
            return work, allowed, np.zeros(n_open, dtype=np.bool_)
        return work, np.arange(n), ruled_out[:n]

    def placements(self, state: TetrisState) -> NDArray[np.int64]:
        """Return (orientation, leftmost column) of each action, shape (n, 2), in the order of `choices`."""
        work, allowed, _ = self._scan(state)
        orientations = work[SHAPE, allowed] - FIRST_SHAPE[self.piece(state)]
        return np.column_stack([orientations, work[LEFT, allowed]])

    def placements_on(self, columns: tuple[int, ...], piece: int) -> NDArray[np.int64]:
        """Return (orientation, leftmost column) of each action of `choices_on`, shape (n, 2), in its
        order.
        """
        work, allowed, _ = self._scan_board(columns, piece)
        return np.column_stack([work[SHAPE, allowed] - FIRST_SHAPE[piece], work[LEFT, allowed]])

    def placement(self, state: TetrisState, action: int) -> Placement:
        """Describe one action in full."""
        work, allowed, _ = self._scan(state)
        at = allowed[_checked(action, len(allowed))]
        piece = self.piece(state)
        orientation = work[SHAPE, at] - FIRST_SHAPE[piece]
        return Placement(piece, int(orientation), int(work[LEFT, at]), int(work[ROW, at]))

    def choices(self, state: TetrisState) -> Choices:
        """Describe the placements of the piece: features of the afterstate, differences for the human
        model.
        """
        return self._describe(*self._scan(state), time=state.k)

    def _describe(
        self, work: Ints, allowed: NDArray[np.int64], ruled_out: NDArray[np.bool_], *, time: int = 0
    ) -> Choices:
        features = np.empty((len(allowed), len(self._features.names)))
        feedback = np.empty((len(allowed), len(self._feedback.names)))
        _fill_choices(
            work, self._rules, allowed, self._features.code, self._feedback.code, features, feedback
        )
        return Choices(
            features / self._features.denominators,
            feedback / self._feedback.denominators,
            ruled_out,
            time=time,
        )

    def choices_on(self, columns: tuple[int, ...], piece: int) -> Choices:
        """Describe the placements of `piece` on any board: a board that was seen, not played to."""
        return self._describe(*self._scan_board(columns, piece))

    def feedback_difference(self, before: tuple[int, ...], after: tuple[int, ...]) -> NDArray[np.float64]:
        """Return psi of a step that led from one board to another, shape (G,).

        What only a move can tell (landing height, eroded cells) is 0.
        """
        work = new_work(before)
        work[AFTER, : self.config.columns] = after
        for board, out in ((NOW, FEATURES_BEFORE), (AFTER, FEATURES)):
            fill_heights(work, board, self.config.columns)
            fill_features(self._feedback.code, work, board, out, self._rules, NO_MOVE, 0, 0)
        n_features = len(self._feedback.names)
        difference: NDArray[np.float64] = (
            work[FEATURES, :n_features] - work[FEATURES_BEFORE, :n_features]
        ) / self._feedback.denominators
        return difference

    def recorded_state(self, state: TetrisState) -> list[float] | None:
        """Return nothing: rules, seed and actions are enough."""
        return None

    def action_record(self, state: TetrisState, action: int) -> PlacedPiece:
        """Return piece, orientation and column of an action, for recordings."""
        placement = self.placement(state, action)
        return PlacedPiece(placement.piece, placement.orientation, placement.column)

    def transition(self, state: TetrisState, action: int) -> Transition[TetrisState]:
        """Return the state after a placement and the lines it cleared."""
        work, allowed, _ = self._scan(state)
        at = allowed[_checked(action, len(allowed))]
        lines, over = _step(work, self._rules, at, self.piece(state, ahead=1))
        columns = tuple(int(column) for column in work[NOW, : self.config.columns])
        following = TetrisState(columns, state.seed, state.k + 1, state.lines + int(lines), bool(over))
        return Transition(following, float(lines), 1)

    def performance(self, state: TetrisState) -> float:
        """Return the lines cleared so far."""
        return float(state.lines)

    def time(self, state: TetrisState) -> int:
        """Return the number of pieces placed so far."""
        return state.k


def _checked(action: int, n_actions: int) -> int:
    if not 0 <= action < n_actions:
        raise ValueError(f"there is no action {action}: this decision has actions 0..{n_actions - 1}")
    return action


@kernel
def _scan_and_rule(work: Ints, rules: Ints, piece: int, ruled_out: NDArray[np.bool_]) -> tuple[int, int]:
    fill_heights(work, NOW, rules[COLUMNS])
    n = scan_placements(work, rules, piece)
    return n, mark_ruled_out(work, rules, n, ruled_out)


@kernel
def _fill_choices(
    work: Ints,
    rules: Ints,
    allowed: Ints,
    code: int,
    feedback_code: int,
    features: NDArray[np.float64],
    feedback: NDArray[np.float64],
) -> None:
    fill_features(feedback_code, work, NOW, FEATURES_BEFORE, rules, NO_MOVE, 0, 0)
    for action in range(len(allowed)):
        fill_after(code, work, rules, allowed[action])
        for feature in range(features.shape[1]):
            features[action, feature] = work[FEATURES, feature]
        if feedback_code != code:
            fill_after(feedback_code, work, rules, allowed[action])
        for feature in range(feedback.shape[1]):
            feedback[action, feature] = work[FEATURES, feature] - work[FEATURES_BEFORE, feature]


@kernel
def _step(work: Ints, rules: Ints, action: int, next_piece: int) -> tuple[int, bool]:
    """Put the piece down; return the lines cleared and whether the game is over, the next piece being
    known.
    """
    lines = place(work, NOW, rules[COLUMNS], action)
    if rules[OVERFLOW] != 0:
        return lines, wall_height(work, NOW, rules[COLUMNS]) > rules[ROWS]
    above = np.zeros(MAX_PLACEMENTS, dtype=np.bool_)
    n = scan_placements(work, rules, next_piece)
    return lines, mark_above(work, rules, n, above) == n
