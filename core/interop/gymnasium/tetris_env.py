"""The program's Tetris as a Gymnasium environment: `gymnasium.make("arl/Tetris-v0")`.

An action is a placement; with `actions="primitives"` it is one of the paper's four primitive actions, or
none, and the piece then falls by one row. Rules and pieces are those of `core.tetris`: the same episode seed
gives the same pieces as in a session.
"""

from typing import Any, ClassVar, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from core.interop.gymnasium.tetris_pictures import picture_pixels, picture_text
from core.interop.spaces import (
    N_ORIENTATIONS,
    board_cells,
    tetris_observation,
    tetris_observations,
    tetris_placements,
)
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.game import FallingPiece, Primitive, fallen, landing_row, moved, settle, spawn
from core.tetris.picture import Counts, Snapshot, Wall, snapshot

PRIMITIVES: tuple[Primitive | None, ...] = (None, *Primitive)
"""Actions with `actions="primitives"`, in order: none, left, right, rotate (clockwise), drop."""
LARGEST_SEED = 2**62
ABOVE = 8
"""Rows above the board in which a falling piece may be."""


class TetrisEnv(gymnasium.Env[dict[str, Any], Any]):  # type: ignore[misc]
    """Tetris: the reward is the number of lines that a step clears; an episode has no time limit.

    Observations are a dictionary: `board`, int8, shape (rows, columns), 1 = filled, row 0 the lowest;
    `piece`, 0..6, letters IOTZSJL. With primitives also `orientation` (quarter turns counter-clockwise), and
    `row` and `column` of the lowest left cell of the falling piece's box.

    Actions are (quarter turns counter-clockwise, leftmost column). One that the rules do not offer changes
    nothing, brings no reward, and `info["offered"]` is False. `info["action_mask"]`, int8, shape (4,
    columns), says which are offered. With primitives every action is offered.
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 4}

    def __init__(
        self,
        actions: Literal["placements", "primitives"] = "placements",
        render_mode: str | None = None,
        **rules: Any,
    ) -> None:
        """Take the rules.

        Args:
            actions: what a step is.
            render_mode: "ansi" for text, "rgb_array" for pictures.
            **rules: fields of `core.tetris.config.TetrisConfig`: rows, columns, game_over, pieces, ....

        Raises:
            ValueError: a mode or a rule is none.
            TypeError: a rule has an unknown name.
        """
        if actions not in ("placements", "primitives"):
            raise ValueError(f'actions is "placements" or "primitives", got {actions!r}')
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ValueError(f'render_mode is "ansi", "rgb_array" or None, got {render_mode!r}')
        self.render_mode = render_mode
        self.domain = Tetris(TetrisConfig(**rules))
        config = self.domain.config
        self._placing = actions == "placements"
        seen = tetris_observations(config)
        if self._placing:
            self.action_space: spaces.Space[Any] = tetris_placements(config)
            self.observation_space: spaces.Space[Any] = seen
        else:
            self.action_space = spaces.Discrete(len(PRIMITIVES))
            self.observation_space = spaces.Dict(
                {
                    **seen.spaces,
                    "orientation": spaces.Discrete(N_ORIENTATIONS),
                    "row": spaces.Discrete(config.rows + ABOVE),
                    "column": spaces.Discrete(config.columns),
                }
            )
        self._state = self.domain.initial(0)
        self._falling: FallingPiece | None = None
        self._wall = Wall(config.rows, config.columns)

    @property
    def state(self) -> TetrisState:
        """The board at rest and the piece to be placed, as the rest of the program has them."""
        return self._state

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: of the sequence of episodes.
            options: {"episode_seed": n}, 0 <= n < 2**63, begins the episode of a session with this seed.
        """
        super().reset(seed=seed)
        chosen = (options or {}).get("episode_seed")
        drawn = int(self.np_random.integers(LARGEST_SEED))
        self._state = self.domain.initial(drawn if chosen is None else int(chosen))
        self._wall = Wall(self.domain.config.rows, self.domain.config.columns)
        self._falling = None if self._placing else self._entering()
        return self._observation(), self._info(offered=True)

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Do an action; return observation, lines cleared, whether the game is over, False, info.

        Raises:
            ValueError: the action is not in the action space, or the game is over.
        """
        if not self.action_space.contains(action):
            raise ValueError(f"{action!r} is no action: {self.action_space} is expected")
        if self.domain.terminal(self._state):
            raise ValueError("the game is over: call reset()")
        before = self._state.lines
        offered = self._place(action) if self._placing else self._move(PRIMITIVES[int(action)])
        reward = float(self._state.lines - before)
        over = self.domain.terminal(self._state)
        return self._observation(), reward, over, False, self._info(offered=offered)

    def render(self) -> Any:
        """Return the picture in the mode asked for: text, or pixels of shape (height, width, 3)."""
        if self.render_mode is None:
            return None
        return (
            picture_text(self._picture()) if self.render_mode == "ansi" else picture_pixels(self._picture())
        )

    def _place(self, action: Any) -> bool:
        """Put the piece down; return whether the placement is offered."""
        orientation, column = int(action[0]), int(action[1])
        found = np.flatnonzero((self.domain.placements(self._state) == (orientation, column)).all(axis=1))
        if len(found) == 0:
            return False
        piece = self.domain.piece(self._state)
        row = landing_row(self._state.columns, piece, orientation, column)
        self._rest(FallingPiece(piece, orientation, row, column))
        self._state = self.domain.transition(self._state, int(found[0])).next_state
        return True

    def _move(self, primitive: Primitive | None) -> bool:
        """Do a primitive and let the piece fall by one row; fix it where it cannot fall."""
        assert self._falling is not None, "a piece falls until the game is over"
        board = self._state.columns
        after = self._falling if primitive is None else moved(board, self._falling, primitive)
        self._falling = fallen(board, after)
        if self._falling is after:
            settled = self._rest(after)
            self._state = TetrisState(
                settled.board,
                self._state.seed,
                self._state.k + 1,
                self._state.lines + len(settled.cleared),
                settled.over,
            )
            if not settled.over:
                self._falling = self._entering()
        return True

    def _rest(self, piece: FallingPiece) -> Any:
        config = self.domain.config
        settled = settle(self._state.columns, piece, config.rows, clear_on_overflow=config.clear_on_overflow)
        self._wall = self._wall.with_piece(piece).without(settled.cleared)
        return settled

    def _entering(self) -> FallingPiece:
        return spawn(self._state.columns, self.domain.piece(self._state), self.domain.config.rows)

    def _observation(self) -> dict[str, Any]:
        if self._falling is None:
            return tetris_observation(self.domain, self._state)
        falling = self._falling
        return {
            "board": board_cells(self._state.columns, self.domain.config.rows),
            "piece": np.int64(falling.piece),
            "orientation": np.int64(falling.orientation),
            "row": np.int64(falling.row),
            "column": np.int64(falling.column),
        }

    def _info(self, *, offered: bool) -> dict[str, Any]:
        about = {"lines": self._state.lines, "pieces": self._state.pieces, "episode_seed": self._state.seed}
        if self._placing:
            return {**about, "offered": offered, "action_mask": self._mask()}
        return about

    def _mask(self) -> NDArray[np.int8]:
        mask = np.zeros((N_ORIENTATIONS, self.domain.config.columns), np.int8)
        if not self.domain.terminal(self._state):
            orientations, columns = self.domain.placements(self._state).T
            mask[orientations, columns] = 1
        return mask

    def _picture(self) -> Snapshot:
        over = self.domain.terminal(self._state)
        counts = Counts(
            lines=self._state.lines,
            pieces=self._state.pieces,
            next_piece=self.domain.piece(self._state, 0 if self._falling is None else 1),
        )
        return snapshot(self._wall, None if over else self._falling, counts=counts, over=over)
