"""Pictures of any game that brings a renderer: each game of a recording is played again from its seed and
actions.
"""

from typing import Any

from arl_tui.games.rendering import Renderer
from arl_tui.viewer.played_again import PlayedAgain
from core.domain import Domain
from core.events import StepTaken
from studies.session_view.session import SessionView

OTHERWISE = "This game comes out otherwise now: use the program and the environment that recorded it"


class RenderedPictures(PlayedAgain):
    """Draws steps by the game's renderer, and compares what the game is in with what was recorded."""

    def __init__(self, session: SessionView, renderer: Renderer, domain: Domain[Any]) -> None:
        """Prepare.

        Args:
            session: the recording.
            renderer: draws its game.
            domain: plays its game: the renderer alone would not notice that it comes out otherwise.
        """
        super().__init__(session, renderer, OTHERWISE)
        self._domain = domain
        self._state: Any = None

    def _begin(self, game: int) -> None:
        super()._begin(game)
        self._state = self._domain.initial(self._session.game_started(game).episode_seed)

    def _could_be(self, step: StepTaken) -> bool:
        if self._domain.terminal(self._state):
            return False
        return (
            self._domain.recorded_state(self._state) == step.state
            and self._domain.action_record(self._state, step.action).plain() == step.detail
        )

    def _follow(self, step: StepTaken, row: int) -> None:
        self._state = self._domain.transition(self._state, step.action).next_state
