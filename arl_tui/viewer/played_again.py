"""Pictures of a recording whose games are played again from their seeds and actions by a renderer."""

from abc import ABC, abstractmethod

from arl_tui.games.rendering import Renderer, TickView
from arl_tui.viewer.looks import Look, tick_number
from core.events import StepTaken
from core.plugins import View
from studies.session_view.session import Moment, SessionView


class PlayedAgain(ABC):
    """Plays to the step that was on screen, and stops where a game comes out otherwise than recorded."""

    def __init__(self, session: SessionView, renderer: Renderer, otherwise: str) -> None:
        """Prepare.

        Args:
            session: the recording.
            renderer: draws its game.
            otherwise: what is said where a game comes out otherwise.
        """
        self._session = session
        self._renderer = renderer
        self._when_otherwise = otherwise
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
        """Return the last picture of the game before, or one of the opening of a game without a step yet."""
        games, frame_ns = self._session.games, int(self._session.frames["time"][moment.frame])
        game = moment.game
        while game > 0 and games["start"][game] > frame_ns:
            game -= 1
        first = int(games["first_step"][game])
        after = int(games["first_step"][game + 1]) if game + 1 < len(games) else len(self._session.steps)
        if after <= first or not 0 <= self._session.steps["shown"][first] <= frame_ns:
            self._begin(game)
            return Look(self._opening_view(moment) if self._opening else self._renderer.picture)
        self._play_to(game, after - 1)
        return Look(self._renderer.picture, self._otherwise)

    def _opening_view(self, moment: Moment) -> View:
        """Return which picture of the opening was on screen; there is at least one."""
        return self._opening[-1].view

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
            if not self._could_be(step):
                self._otherwise = self._when_otherwise
                return
            self._follow(step, row)
            self._ticks = self._renderer.act(step)
        self._next = row + 1

    @abstractmethod
    def _could_be(self, step: StepTaken) -> bool:
        """Return whether a step can have been recorded where the game is now."""

    @abstractmethod
    def _follow(self, step: StepTaken, row: int) -> None:
        """Take note of a step on the way to the one in `row`, before it is drawn."""
