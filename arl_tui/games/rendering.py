"""From a session's outputs to pictures: the same for a live session and for a recording that is looked at
again.
"""

from typing import NamedTuple, runtime_checkable
from typing import Protocol as Interface

from core.events import EpisodeStarted, StepTaken
from core.plugins import View

Place = tuple[tuple[int, ...], ...]
"""Where a step that was judged is to be seen, in numbers that a game's renderer writes and its panel reads
(Tetris: row from the bottom and column of each block; Keepaway: the keeper and whom it passed to); () where
it is no longer on screen."""


class TickView(NamedTuple):
    """A picture for one tick."""

    view: View
    ahead: View | None = None
    """The picture of the tick after, where what lies between can be shown."""


class Renderer(Interface):
    """Draws one session."""

    @property
    def tick_ns(self) -> int:
        """How long each picture is shown."""
        ...

    @property
    def picture(self) -> View:
        """The newest picture, which stays when an episode has ended."""
        ...

    def begin(self, episode: EpisodeStarted) -> tuple[TickView, ...]:
        """Return the pictures from the beginning of an episode to its first decision."""
        ...

    def act(self, step: StepTaken) -> tuple[TickView, ...]:
        """Return the pictures of a step; none where another step begins in the same moment."""
        ...

    def judged_after_ns(self, n_ticks: int) -> int:
        """Return from when on a step of so many pictures can be judged, since it came on screen."""
        ...

    def place_of(self, step: int) -> Place:
        """Return where one of the last steps is to be seen while the newest one is on screen."""
        ...


@runtime_checkable
class PlacesOptions(Interface):
    """A renderer that knows where an option of a question would be seen; others list options in words."""

    def place_of_option(self, detail: dict[str, int]) -> Place:
        """Return where an option is to be seen on the newest picture; `detail` as in `StepTaken.detail`."""
        ...
