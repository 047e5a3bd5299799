"""Pictures of any game that brings a renderer: each game of a recording is played again from its seed and
actions.
"""

from typing import Any

from arl_tui.games.rendering import Renderer, TickView
from arl_tui.viewer.looks import Look, tick_number
from core.domain import Domain
from core.events import StepTaken
from studies.session_view.session import Moment, SessionView

OTHERWISE = "This game comes out otherwise now: use the program and the environment that recorded it"


class RenderedPictures:
    """Draws steps by the game's renderer, and compares what the game is in with what was recorded."""

    def __init__(self, session: SessionView, renderer: Renderer, domain: Domain[Any]) -> None:
        """Prepare.

        Args:
            session: the recording.
            renderer: draws its game.
            domain: plays its game: the renderer alone would not notice that it comes out otherwise.
        """
        self._session = session
        self._renderer = renderer
        self._domain = domain
        self._state: Any = None
        self._game = -1
        self._next = -1
        self._opening: tuple[TickView, ...] = ()
        self._ticks: tuple[TickView, ...] = ()
        self._otherwise = ""

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
        """Return the last picture of the game before, or the first of one whose steps have not begun."""
        games, frame_ns = self._session.games, int(self._session.frames["time"][moment.frame])
        game = moment.game
        while game > 0 and games["start"][game] > frame_ns:
            game -= 1
        first = int(games["first_step"][game])
        after = int(games["first_step"][game + 1]) if game + 1 < len(games) else len(self._session.steps)
        if after <= first or not 0 <= self._session.steps["shown"][first] <= frame_ns:
            self._begin(game)
            return Look(self._opening[-1].view if self._opening else self._renderer.picture)
        self._play_to(game, after - 1)
        return Look(self._renderer.picture, self._otherwise)

    def _begin(self, game: int) -> None:
        started = self._session.game_started(game)
        self._opening = self._renderer.begin(started)
        self._state = self._domain.initial(started.episode_seed)
        self._game, self._next = game, int(self._session.games["first_step"][game])
        self._ticks, self._otherwise = (), ""

    def _play_to(self, game: int, row: int) -> None:
        """Play to the end of a step."""
        if game != self._game or row < self._next - 1:
            self._begin(game)
        if row < self._next or self._otherwise:
            return
        for step in self._session.steps_taken(self._next, row):
            if not self._could_be(step):
                self._otherwise = OTHERWISE
                return
            self._state = self._domain.transition(self._state, step.action).next_state
            self._ticks = self._renderer.act(step)
        self._next = row + 1

    def _could_be(self, step: StepTaken) -> bool:
        """Return whether a step can have been recorded where the game is now."""
        if self._domain.terminal(self._state):
            return False
        return (
            self._domain.recorded_state(self._state) == step.state
            and self._domain.action_record(self._state, step.action).plain() == step.detail
        )
