"""From a session's steps to pictures of the board: a piece that is moved and dropped."""

from arl_tui.games.rendering import Place, TickView
from core.events import EpisodeStarted, StepTaken
from core.numerics.clock import NS_PER_MS
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig
from core.tetris.game import FallingPiece, landing_row, reachable_placements
from core.tetris.picture import Counts, PieceAnimation, Snapshot, Wall, animate, snapshot
from core.tetris.practice import PIECE_STREAMS

PIECES_REMEMBERED = 8


class TetrisRenderer:
    """Draws what the agent does, step by step, as a piece that is moved and dropped.

    The board is known from the steps alone: no simulator is asked.
    """

    def __init__(self, config: TetrisConfig, tick_ns: int = 80 * NS_PER_MS) -> None:
        self.tick_ns = tick_ns
        """How long each picture is shown: the time per primitive action."""
        self.picture: Snapshot = snapshot(Wall(config.rows, config.columns), counts=Counts())
        """The newest picture of a board at rest."""
        self._config = config
        self._piece_at = PIECE_STREAMS[config.pieces]
        self._wall = Wall(config.rows, config.columns)
        self._counts = Counts()
        self._episode_seed = 0
        self._landed: dict[int, Place] = {}
        """What is left of the last pieces on the wall, by step, oldest first."""
        self._cleared: tuple[int, ...] = ()
        """Rows that the newest piece has cleared; to the older ones that happens when it has landed."""

    def begin(self, episode: EpisodeStarted) -> tuple[TickView, ...]:
        """Clear the board."""
        self._wall = Wall(self._config.rows, self._config.columns)
        self._landed, self._cleared = {}, ()
        self._episode_seed = episode.episode_seed
        self._counts = Counts(next_piece=self._piece_at(self._episode_seed, 0))
        self.picture = snapshot(self._wall, counts=self._counts)
        return (TickView(self.picture),)

    def stand_at(self, wall: Wall, counts: Counts, episode_seed: int) -> None:
        """Go to any board of an episode, as if its steps so far had been drawn."""
        self._wall, self._counts, self._episode_seed = wall, counts, episode_seed
        self.picture = snapshot(wall, counts=counts)

    def act(self, step: StepTaken) -> tuple[TickView, ...]:
        """Return the pictures of a step; the last one stays."""
        placed = PlacedPiece.of(step)
        piece, placement = placed.piece, placed.place
        counts = Counts(
            lines=self._counts.lines,
            pieces=self._counts.pieces,
            next_piece=self._piece_at(self._episode_seed, self._counts.pieces + 1),
        )
        plans = reachable_placements(self._wall.board, piece, self._config.rows)
        shown = animate(
            self._wall,
            piece,
            placement,
            plans.get(placement),
            counts=counts,
            clear_on_overflow=self._config.clear_on_overflow,
        )
        self._note_landed(step.step, shown)
        self._wall = shown.wall
        self.picture = shown.frames[-1]
        self._counts = self.picture.counts
        return tuple(TickView(frame) for frame in shown.frames)

    def judged_after_ns(self, n_ticks: int) -> int:
        """Return the time on screen: a step is judged when the piece has landed."""
        return n_ticks * self.tick_ns

    def place_of(self, step: int) -> Place:
        """Return the piece's blocks on the wall; none where all have been cleared, or it is too long ago."""
        return self._landed.get(step, ())

    def place_of_option(self, detail: dict[str, int]) -> Place:
        """Return where the piece would come to rest."""
        piece, orientation, column = detail["piece"], detail["orientation"], detail["column"]
        row = landing_row(self._wall.board, piece, orientation, column)
        return tuple(FallingPiece(piece, orientation, row, column).cells())

    def _note_landed(self, step: int, shown: PieceAnimation) -> None:
        self._landed = {
            known: _after_clearing(blocks, self._cleared)
            for known, blocks in list(self._landed.items())[-PIECES_REMEMBERED:]
        }
        at_rest = next(frame.falling for frame in reversed(shown.frames) if frame.falling is not None)
        self._cleared = shown.settled.cleared
        self._landed[step] = _after_clearing(tuple(at_rest.cells()), self._cleared)


def _after_clearing(blocks: Place, cleared: tuple[int, ...]) -> Place:
    """Return where blocks are when rows have gone: what was above them is lower."""
    return tuple(
        (row - sum(gone < row for gone in cleared), column) for row, column in blocks if row not in cleared
    )
