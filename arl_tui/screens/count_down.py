"""The count-down before a game begins or goes on: a number in the game's place, and nothing to judge."""

from asyncio import TimerHandle
from collections.abc import Callable

from textual.message_pump import MessagePump

from arl_tui.app.once import after
from arl_tui.widgets.big_letters import big
from arl_tui.widgets.coverable import CoverableWidget

SECOND_S = 1.0


class CountDown:
    """Counts whole seconds down over a picture of a game."""

    def __init__(self, pump: MessagePump, game: CoverableWidget, seconds: int) -> None:
        """Prepare.

        Args:
            pump: whose task counts.
            game: what is covered.
            seconds: how many, >= 0.
        """
        self._pump = pump
        self._game = game
        self._seconds = seconds
        self._timer: TimerHandle | None = None

    @property
    def running(self) -> bool:
        """Whether a number is on screen."""
        return self._timer is not None

    def start(self, title: str, then: Callable[[], None]) -> None:
        """Count from the beginning, then uncover the game and call back; at once where there are no seconds.

        Args:
            title: above the number, such as "Game 2"; short.
            then: called when the game is to be seen again.
        """
        self.stop()
        self._count(title, self._seconds, then)

    def stop(self) -> None:
        """Uncover the game without calling back."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
            self._game.uncover()

    def _count(self, title: str, left: int, then: Callable[[], None]) -> None:
        if left <= 0:
            self.stop()
            then()
            return
        self._game.cover("\n".join([title, "", *big(str(left))]))
        self._timer = after(self._pump, SECOND_S, lambda: self._count(title, left - 1, then))
