"""What was on screen at a moment of a recording, drawn by the renderer that drew the session."""

import textwrap
from typing import Final, Protocol

import msgspec

from arl_tui.games.registry import screens_of
from arl_tui.games.rendering import TickView
from arl_tui.games.tetris.renderer import TetrisRenderer
from arl_tui.viewer.looks import Board, Look, tick_number
from arl_tui.viewer.rendered import RenderedPictures
from core.events import StepTaken
from core.feedback.keys import NS_PER_MS
from core.keepaway.pitch import KeepawayConfig
from core.plugins import GameError, View
from core.registry import game_of
from core.session.protocol import Protocol as SessionProtocol
from core.tetris.config import TetrisConfig
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
            return Look(snapshot(board.wall, counts=board.counts), "", None, board.ids)
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
            return Board(Wall(self._config.rows, self._config.columns), (), self._counts_at(game, 0, 0))
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
            placed = self._placed(step, before.wall)
            if placed is None:
                ticks: tuple[TickView, ...] = (TickView(snapshot(before.wall, counts=before.counts)),)
                after = before
            else:
                self._renderer.stand_at(before.wall, before.counts, self._seed(game))
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

    def _counts_at(self, game: int, lines: int, pieces: int) -> Counts:
        following = -1 if self._session.imported else self._piece_at(self._seed(game), pieces)
        return Counts(lines=lines, pieces=pieces, next_piece=following)

    def _before(self, row: int) -> Board:
        """Return the board on which a step was decided."""
        game = int(self._session.steps["episode"][row])
        if game != self._game:
            self._game, self._kept = game, {}
        first = int(self._session.games["first_step"][game])
        known = max((kept for kept in self._kept if kept <= row), default=-1)
        if known < 0:
            known = max(first, row - LOOK_BACK) if self._session.imported else first
            self._kept[known] = Board(
                self._seen_wall(known) or Wall(self._config.rows, self._config.columns),
                (),
                self._counts_at(game, 0, known - first),
            )
        board = self._kept[known]
        for step_row, step in enumerate(
            self._session.steps_taken(known, row - 1) if row > known else (), known
        ):
            placed = self._placed(step, board.wall)
            board = board if placed is None else self._after(board, placed)
            seen = self._seen_wall(step_row + 1)
            if seen is not None and seen.board != board.wall.board:
                board = Board(seen, (), board.counts)
            if (step_row + 1 - first) % KEPT_EVERY == 0 or step_row + 1 == row:
                self._kept[step_row + 1] = board
        return board

    def _seen_wall(self, row: int) -> Wall | None:
        """Return the board that an imported log holds before a step."""
        if not self._session.imported or row >= len(self._session.steps):
            return None
        observed = self._session.step_taken(row).observed or {}
        return Wall.of_board(tuple(observed["before"]), self._config.rows) if "before" in observed else None

    def _placed(self, step: StepTaken, wall: Wall) -> StepTaken | None:
        """Return a step that says where the piece came to rest; None where an imported log does not tell."""
        if "orientation" in step.detail:
            return step
        after = tuple((step.observed or {}).get("after", ()))
        piece = step.detail["piece"]
        for orientation in range(len(ORIENTATION_ROWS[piece])):
            for column in range(self._config.columns):
                if FallingPiece(piece, orientation, 0, column).width + column > self._config.columns:
                    continue
                rest = FallingPiece(
                    piece, orientation, landing_row(wall.board, piece, orientation, column), column
                )
                if settle(wall.board, rest, self._config.rows).board == after:
                    return msgspec.structs.replace(
                        step, detail={"piece": piece, "orientation": orientation, "column": column}
                    )
        return None

    def _after(self, board: Board, step: StepTaken) -> Board:
        piece, orientation, column = (step.detail[name] for name in ("piece", "orientation", "column"))
        wall = board.wall
        rest = FallingPiece(piece, orientation, landing_row(wall.board, piece, orientation, column), column)
        settled = settle(
            wall.board, rest, self._config.rows, clear_on_overflow=self._config.clear_on_overflow
        )
        filled = wall.with_piece(rest)
        ids = [list(level) for level in board.ids]
        ids += [[-1] * self._config.columns for _ in range(len(filled.levels) - len(ids))]
        for row, cell in rest.cells():
            ids[row][cell] = step.step
        kept = tuple(tuple(level) for row, level in enumerate(ids) if row not in settled.cleared)
        game = int(self._session.steps["episode"][self._session.step_row(step.step)])
        counts = self._counts_at(game, board.counts.lines + len(settled.cleared), board.counts.pieces + 1)
        return Board(filled.without(settled.cleared), kept, counts)


def _without_next(view: View) -> View:
    assert isinstance(view, Snapshot), "a picture of a board"
    return msgspec.structs.replace(view, counts=msgspec.structs.replace(view.counts, next_piece=-1))


class PitchPictures:
    """Pitches of Keepaway: the match is played again from the kick-off of its game."""

    def __init__(self, session: SessionView, config: KeepawayConfig, speed: float) -> None:
        from arl_tui.games.keepaway.renderer import (
            KeepawayRenderer,  # here, not above: compiled code comes with it
        )

        self._session = session
        self._renderer = KeepawayRenderer(config, speed)
        self._game = -1
        self._next = -1
        self._opening: tuple[TickView, ...] = ()
        self._ticks: tuple[TickView, ...] = ()
        self._otherwise = ""
        self.receivers: tuple[int, tuple[int, ...]] = (-1, ())
        """The row of the step drawn last, and to whom its options pass, in their order."""

    def at(self, moment: Moment) -> Look:
        """Return what was on screen at a moment."""
        if moment.frame < 0 or moment.game < 0:
            return Look(self._renderer.picture)
        if moment.step < 0:
            return self._between(moment)
        self._play_to(int(self._session.steps["episode"][moment.step]), moment.step)
        if not self._ticks:
            return Look(self._renderer.picture, self._otherwise)
        n = tick_number(self._session, moment, len(self._ticks), self._renderer.tick_ns)
        return Look(self._ticks[n].view, self._otherwise)

    def _between(self, moment: Moment) -> Look:
        games, frame_ns = self._session.games, int(self._session.frames["time"][moment.frame])
        game = moment.game
        while game > 0 and games["start"][game] > frame_ns:
            game -= 1
        first = int(games["first_step"][game])
        after = int(games["first_step"][game + 1]) if game + 1 < len(games) else len(self._session.steps)
        if after <= first or not 0 <= self._session.steps["shown"][first] <= frame_ns:
            self._begin(game)
            n = min(moment.visible_ns // self._renderer.tick_ns, len(self._opening) - 1)
            return Look(self._opening[n].view if self._opening else self._renderer.picture)
        self._play_to(game, after - 1)
        return Look(self._renderer.picture, self._otherwise)

    def _begin(self, game: int) -> None:
        self._opening = self._renderer.begin(self._session.game_started(game))
        self._game, self._next = game, int(self._session.games["first_step"][game])
        self._ticks, self._otherwise = (), ""

    def _play_to(self, game: int, row: int) -> None:
        """Play to the end of a step."""
        if game != self._game or row < self._next - 1:
            self._begin(game)
        if row < self._next or self._otherwise:
            return
        for step in self._session.steps_taken(self._next, row):
            if not self._renderer.could_be(step):
                self._otherwise = "This match comes out otherwise now: use the program that recorded it"
                return
            self.receivers = row, self._renderer.receivers
            self._ticks = self._renderer.act(step)
        self._next = row + 1
