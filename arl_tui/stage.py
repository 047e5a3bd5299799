"""From a session's outputs to pictures: the same for a live session and for a recording that is looked at again."""

from core.episode import EpisodeStarted, StepTaken
from core.tetris.config import TetrisConfig
from core.tetris.game import reachable_placements
from core.tetris.picture import Counts, Snapshot, Wall, animate, snapshot
from core.tetris.practice import PIECE_STREAMS


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

    def begin(self, episode: EpisodeStarted) -> Snapshot:
        """Clear the board."""
        self._wall = Wall(self._config.rows, self._config.columns)
        self._episode_seed = episode.episode_seed
        self._counts = Counts(next_piece=self._piece_at(self._episode_seed, 0))
        self.picture = snapshot(self._wall, counts=self._counts)
        return self.picture

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
