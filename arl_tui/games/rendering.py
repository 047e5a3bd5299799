"""From a session's outputs to pictures: the same for a live session and for a recording that is looked at again."""

from typing import NamedTuple
from typing import Protocol as Interface

from arl_tui.app.link import View
from core.events import EpisodeStarted, StepTaken
from core.feedback.keys import NS_PER_MS
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import KeepawayConfig
from core.session.protocol import Protocol
from core.tetris.config import TetrisConfig
from core.tetris.game import reachable_placements
from core.tetris.picture import Counts, PieceAnimation, Snapshot, Wall, animate, snapshot
from core.tetris.practice import PIECE_STREAMS

Blocks = tuple[tuple[int, int], ...]
"""(row from the bottom, column) of blocks on a wall."""
PIECES_REMEMBERED = 8


class Shot(NamedTuple):
    """A picture for one tick of the stage."""

    view: View
    ahead: PitchFrame | None = None
    """The picture of the tick after, where what lies between can be shown."""


class Place(NamedTuple):
    """Where a step that was judged is to be seen now."""

    blocks: Blocks = ()
    """Tetris: what is left of the piece."""
    player: int = -1
    """Keepaway: who chose."""
    target: int = -1
    """Keepaway: who was passed to; -1 for a hold."""


class Stage(Interface):
    """Draws one session."""

    @property
    def tick_ns(self) -> int:
        """How long each picture is shown."""
        ...

    @property
    def picture(self) -> View:
        """The newest picture, which stays when an episode has ended."""
        ...

    def begin(self, episode: EpisodeStarted) -> tuple[Shot, ...]:
        """Return the pictures from the beginning of an episode to its first decision."""
        ...

    def act(self, step: StepTaken) -> tuple[Shot, ...]:
        """Return the pictures of a step; none where another step begins in the same moment."""
        ...

    def judged_after_ns(self, n_shots: int) -> int:
        """Return from when on a step of so many pictures can be judged, since it came on screen."""
        ...

    def place_of(self, step: int) -> Place:
        """Return where one of the last steps is to be seen while the newest one is on screen."""
        ...


def stage_of(protocol: Protocol) -> Stage:
    """Return the stage of a protocol's game."""
    if isinstance(protocol.domain, KeepawayConfig):
        from arl_tui.games.keepaway.renderer import PitchStage  # here, not above: compiled code comes with it

        return PitchStage(protocol.domain, protocol.screen.speed)
    return TetrisStage(protocol.domain, protocol.screen.tick_ms * NS_PER_MS)


class TetrisStage:
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
        self._landed: dict[int, Blocks] = {}
        """What is left of the last pieces on the wall, by step, oldest first."""
        self._cleared: tuple[int, ...] = ()
        """Rows that the newest piece has cleared; to the older ones that happens when it has landed."""

    def begin(self, episode: EpisodeStarted) -> tuple[Shot, ...]:
        """Clear the board."""
        self._wall = Wall(self._config.rows, self._config.columns)
        self._landed, self._cleared = {}, ()
        self._episode_seed = episode.episode_seed
        self._counts = Counts(next_piece=self._piece_at(self._episode_seed, 0))
        self.picture = snapshot(self._wall, counts=self._counts)
        return (Shot(self.picture),)

    def stand_at(self, wall: Wall, counts: Counts, episode_seed: int) -> None:
        """Go to any board of an episode, as if its steps so far had been drawn."""
        self._wall, self._counts, self._episode_seed = wall, counts, episode_seed
        self.picture = snapshot(wall, counts=counts)

    def act(self, step: StepTaken) -> tuple[Shot, ...]:
        """Return the pictures of a step; the last one stays."""
        piece = step.detail["piece"]
        placement = (step.detail["orientation"], step.detail["column"])
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
        return tuple(Shot(frame) for frame in shown.frames)

    def judged_after_ns(self, n_shots: int) -> int:
        """Return the time on screen: a step is judged when the piece has landed."""
        return n_shots * self.tick_ns

    def place_of(self, step: int) -> Place:
        """Return the piece's blocks on the wall; none where all have been cleared, or it is too long ago."""
        return Place(blocks=self._landed.get(step, ()))

    def _note_landed(self, step: int, shown: PieceAnimation) -> None:
        self._landed = {
            known: _after_clearing(blocks, self._cleared)
            for known, blocks in list(self._landed.items())[-PIECES_REMEMBERED:]
        }
        at_rest = next(frame.falling for frame in reversed(shown.frames) if frame.falling is not None)
        self._cleared = shown.settled.cleared
        self._landed[step] = _after_clearing(tuple(at_rest.cells()), self._cleared)


def _after_clearing(blocks: Blocks, cleared: tuple[int, ...]) -> Blocks:
    """Return where blocks are when rows have gone: what was above them is lower."""
    return tuple(
        (row - sum(gone < row for gone in cleared), column) for row, column in blocks if row not in cleared
    )
