"""From a session's outputs to pictures: the same for a live session and for a recording that is looked at again."""

from typing import Protocol as Interface

from core.episode import EpisodeStarted, StepTaken
from core.protocol import Protocol
from core.tetris.config import TetrisConfig
from core.tetris.game import reachable_placements
from core.tetris.picture import Counts, Snapshot, Wall, animate, snapshot
from core.tetris.practice import PIECE_STREAMS


class Stage(Interface):
    """Draws one session."""

    @property
    def picture(self) -> Snapshot:
        """The newest picture: of a game at rest, it stays when an episode has ended."""
        ...

    def begin(self, episode: EpisodeStarted) -> tuple[Snapshot, ...]:
        """Return the pictures from the beginning of an episode to its first decision, one per tick."""
        ...

    def act(self, step: StepTaken) -> tuple[Snapshot, ...]:
        """Return the pictures of a step, one per tick."""
        ...


class TetrisStage:
    """Draws what the agent does, step by step, as a piece that is moved and dropped.

    The board is known from the steps alone: no simulator is asked.
    """

    def __init__(self, config: TetrisConfig) -> None:
        self.picture = snapshot(Wall(config.rows, config.columns), counts=Counts())
        """The newest picture of a board at rest."""
        self._config = config
        self._piece_at = PIECE_STREAMS[config.pieces]
        self._wall = Wall(config.rows, config.columns)
        self._counts = Counts()
        self._episode_seed = 0

    def begin(self, episode: EpisodeStarted) -> tuple[Snapshot, ...]:
        """Clear the board."""
        self._wall = Wall(self._config.rows, self._config.columns)
        self._episode_seed = episode.episode_seed
        self._counts = Counts(next_piece=self._piece_at(self._episode_seed, 0))
        self.picture = snapshot(self._wall, counts=self._counts)
        return (self.picture,)

    def act(self, step: StepTaken) -> tuple[Snapshot, ...]:
        """Return the pictures of a step, one per tick; the last one stays."""
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
        self._wall = shown.wall
        self.picture = shown.frames[-1]
        self._counts = self.picture.counts
        return shown.frames


def stage_of(protocol: Protocol) -> Stage:
    """Return the stage of a protocol's game."""
    assert isinstance(protocol.domain, TetrisConfig), "Keepaway has no stage yet"
    return TetrisStage(protocol.domain)
