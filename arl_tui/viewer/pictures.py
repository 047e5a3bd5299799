"""What was on screen at a moment of a recording, drawn by the renderer that drew the session."""

import textwrap
from typing import Final, Protocol

import msgspec
from msgspec import UNSET

from arl_tui.games.registry import screens_of
from arl_tui.games.rendering import TickView
from arl_tui.games.tetris.renderer import TetrisRenderer
from arl_tui.viewer.looks import Board, Look, board_of, tick_number
from arl_tui.viewer.played_again import PlayedAgain
from arl_tui.viewer.rendered import RenderedPictures
from core.events import StepTaken
from core.keepaway.pitch import KeepawayConfig
from core.numerics.clock import NS_PER_MS
from core.plugins import GameError, View
from core.session.protocol import Protocol as SessionProtocol
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig
from core.tetris.game import Board as BitBoard
from core.tetris.game import FallingPiece, landing_row, settle
from core.tetris.picture import Counts, Snapshot, Wall, snapshot
from core.tetris.practice import PIECE_STREAMS
from core.tetris.shapes import ORIENTATION_ROWS
from studies.session_view.session import Moment, SessionView

KEPT_EVERY: Final = 64
"""Of so many boards of a game one is kept, from which the others are found."""
LOOK_BACK: Final = 24
"""Pieces of an imported log that are followed back to tell which cell belongs to which piece."""


class Pictures(Protocol):
    """Finds pictures of one recording."""

    def at(self, moment: Moment) -> Look:
        """Return what was on screen at a moment."""
        ...


def pictures_of(session: SessionView) -> Pictures:
    """Return what draws the game of a recording."""
    protocol = session.protocol
    if protocol is None:
        return NoPictures()
    match protocol.domain:
        case KeepawayConfig() as pitch:
            return PitchPictures(session, pitch, protocol.screen.speed)
        case TetrisConfig() as board:
            return BoardPictures(session, board, protocol.screen.tick_ms * NS_PER_MS)
        case _:
            return _rendered(session, protocol)


def _rendered(session: SessionView, protocol: SessionProtocol) -> Pictures:
    """Return what draws a game that came as a plug-in, or why it cannot be drawn here."""
    try:
        from core.registry import game_of  # here, not above: compiled code comes with it

        domain = game_of(protocol).domain(protocol)
        return RenderedPictures(session, screens_of(protocol).renderer(protocol), domain)
    except GameError as error:
        return NoPictures("\n".join(textwrap.wrap(str(error), 38)))


class NoPictures:
    """Of a recording that cannot be drawn, with the reason."""

    def __init__(self, reason: str = "This recording holds presses\nwithout the states they judge") -> None:
        self._reason = reason

    def at(self, moment: Moment) -> Look:
        """Return no picture, and why."""
        return Look(None, self._reason)


class BoardPictures:
    """Boards of Tetris."""

    def __init__(self, session: SessionView, config: TetrisConfig, tick_ns: int) -> None:
        self._session = session
        self._config = config
        self._renderer = TetrisRenderer(config, tick_ns)
        self._piece_at = PIECE_STREAMS[config.pieces]
        self._game = -1
        self._kept: dict[int, Board] = {}
        self._ticks: tuple[int, tuple[TickView, ...], Board, Board] | None = None

    def at(self, moment: Moment) -> Look:
        """Return what was on screen at a moment."""
        if moment.frame < 0 or moment.game < 0:
            return Look(self._empty(), "")
        if moment.step < 0:
            board = self._between(moment)
            counts = self._counts(moment.game, board)
            return Look(snapshot(board.wall, counts=counts), "", None, board.ids)
        ticks, before, after = self._step(moment.step)
        n = tick_number(self._session, moment, len(ticks), self._renderer.tick_ns)
        landed = n == len(ticks) - 1
        return Look(ticks[n].view, "", before, after.ids if landed else before.ids)

    def _empty(self) -> Snapshot:
        return snapshot(Wall(self._config.rows, self._config.columns), counts=Counts())

    def _between(self, moment: Moment) -> Board:
        """Return the board of a frame without a step: the last one, or an empty one before the first
        piece.
        """
        games, frame_ns = self._session.games, int(self._session.frames["time"][moment.frame])
        game = moment.game
        while game > 0 and games["start"][game] > frame_ns:
            game -= 1
        first = int(games["first_step"][game])
        last = self._last_of(game)
        if last < first or not 0 <= self._session.steps["shown"][first] <= frame_ns:
            return board_of(Wall(self._config.rows, self._config.columns), 0, 0)
        return self._step(last)[2]

    def _last_of(self, game: int) -> int:
        games = self._session.games
        after = int(games["first_step"][game + 1]) if game + 1 < len(games) else len(self._session.steps)
        return after - 1

    def _step(self, row: int) -> tuple[tuple[TickView, ...], Board, Board]:
        """Return the pictures of a step, and the boards before and after it."""
        if self._ticks is None or self._ticks[0] != row:
            before = self._before(row)
            step = self._session.step_taken(row)
            game = int(self._session.steps["episode"][row])
            placed, counts = self._placed(step, before.columns), self._counts(game, before)
            if placed is None:
                ticks: tuple[TickView, ...] = (TickView(snapshot(before.wall, counts=counts)),)
                after = before
            else:
                self._renderer.stand_at(before.wall, counts, self._seed(game))
                ticks = self._known_pieces(self._renderer.act(placed))
                after = self._after(before, placed)
            self._ticks = row, ticks, before, after
        return self._ticks[1:]

    def _known_pieces(self, ticks: tuple[TickView, ...]) -> tuple[TickView, ...]:
        """Take the next piece out of the pictures of an imported log, which does not hold it."""
        if not self._session.imported:
            return ticks
        return tuple(TickView(_without_next(tick.view)) for tick in ticks)

    def _seed(self, game: int) -> int:
        return int(self._session.games["seed"][game])

    def _counts(self, game: int, board: Board) -> Counts:
        following = -1 if self._session.imported else self._piece_at(self._seed(game), board.pieces)
        return Counts(lines=board.lines, pieces=board.pieces, next_piece=following)

    def _before(self, row: int) -> Board:
        """Return the board on which a step was decided."""
        game = int(self._session.steps["episode"][row])
        if game != self._game:
            self._game, self._kept = game, {}
        first = int(self._session.games["first_step"][game])
        known = max((kept for kept in self._kept if kept <= row), default=-1)
        if known < 0:
            known = max(first, row - LOOK_BACK) if self._session.imported else first
            wall = self._seen_wall(known) or Wall(self._config.rows, self._config.columns)
            self._kept[known] = board_of(wall, 0, known - first)
        board = self._kept[known]
        for step_row, step in enumerate(
            self._session.steps_taken(known, row - 1) if row > known else (), known
        ):
            placed = self._placed(step, board.columns)
            board = board if placed is None else self._after(board, placed)
            seen = self._seen_wall(step_row + 1)
            if seen is not None and seen.board != board.columns:
                board = board_of(seen, board.lines, board.pieces)
            if (step_row + 1 - first) % KEPT_EVERY == 0 or step_row + 1 == row:
                self._kept[step_row + 1] = board
        return board

    def _seen_wall(self, row: int) -> Wall | None:
        """Return the board that an imported log holds before a step."""
        if not self._session.imported or row >= len(self._session.steps):
            return None
        observed = self._session.step_taken(row).observed or {}
        return Wall.of_board(tuple(observed["before"]), self._config.rows) if "before" in observed else None

    def _placed(self, step: StepTaken, board: BitBoard) -> StepTaken | None:
        """Return a step that says where the piece came to rest; None where an imported log does not tell."""
        placed = PlacedPiece.of(step)
        if placed.column is not UNSET:
            return step
        after = tuple((step.observed or {}).get("after", ()))
        piece = placed.piece
        for orientation in range(len(ORIENTATION_ROWS[piece])):
            for column in range(self._config.columns):
                if FallingPiece(piece, orientation, 0, column).width + column > self._config.columns:
                    continue
                row = landing_row(board, piece, orientation, column)
                rest = FallingPiece(piece, orientation, row, column)
                if settle(board, rest, self._config.rows).board == after:
                    found = PlacedPiece(piece, orientation, column)
                    return msgspec.structs.replace(step, detail=found.plain())
        return None

    def _after(self, board: Board, step: StepTaken) -> Board:
        placed = PlacedPiece.of(step)
        piece, (orientation, column) = placed.piece, placed.place
        row = landing_row(board.columns, piece, orientation, column)
        rest = FallingPiece(piece, orientation, row, column)
        settled = settle(
            board.columns, rest, self._config.rows, clear_on_overflow=self._config.clear_on_overflow
        )
        filled = board.wall.with_piece(rest)
        # Only the rows that the piece reaches change.
        ids = list(board.ids)
        ids += [(-1,) * self._config.columns] * (len(filled.levels) - len(ids))
        for row, cell in rest.cells():
            ids[row] = (*ids[row][:cell], step.step, *ids[row][cell + 1 :])
        cleared = settled.cleared
        if cleared:
            ids = [level for row, level in enumerate(ids) if row not in cleared]
            filled = filled.without(cleared)
        return Board(filled, tuple(ids), board.lines + len(cleared), board.pieces + 1, settled.board)


def _without_next(view: View) -> View:
    assert isinstance(view, Snapshot), "a picture of a board"
    return msgspec.structs.replace(view, counts=msgspec.structs.replace(view.counts, next_piece=-1))


class PitchPictures(PlayedAgain):
    """Pitches of Keepaway: the match is played again from the kick-off of its game."""

    def __init__(self, session: SessionView, config: KeepawayConfig, speed: float) -> None:
        from arl_tui.games.keepaway.renderer import (
            KeepawayRenderer,  # here, not above: compiled code comes with it
        )

        self._match = KeepawayRenderer(config, speed)
        super().__init__(
            session, self._match, "This match comes out otherwise now: use the program that recorded it"
        )
        self.receivers: tuple[int, tuple[int, ...]] = (-1, ())
        """The row of the step drawn last, and to whom its options pass, in their order."""

    def _opening_view(self, moment: Moment) -> View:
        n = min(moment.visible_ns // self._match.tick_ns, len(self._opening) - 1)
        return self._opening[n].view

    def _could_be(self, step: StepTaken) -> bool:
        return self._match.could_be(step)

    def _follow(self, step: StepTaken, row: int) -> None:
        self.receivers = row, self._match.receivers
