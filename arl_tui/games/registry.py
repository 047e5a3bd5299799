"""What the app has of each game, found by the game's name: words, renderer, panel.

A package that shows a game of its own (`core.plugins`) names an instance of `GameScreens` in its metadata,

    [project.entry-points."arl.screens"]
    our-game = "our_package.screens:SCREENS"

under the name of the game. Without one the game can be simulated and replayed, and not be played in front of
people.
"""

from abc import ABC, abstractmethod
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar

import msgspec

from arl_tui.words import JudgingWords, Words
from core.feedback.config import TrainerConfig
from core.plugins import GameError
from core.session.protocol import DEFAULTS, Protocol, ScreenConfig
from studies.reaction_time.protocol import Schedule

if TYPE_CHECKING:
    from arl_tui.games.panel import Panel
    from arl_tui.games.rendering import Renderer
    from arl_tui.games.trial_view import TrialView
    from arl_tui.palette import Palette

GROUP = "arl.screens"
BUILT_IN = {
    "tetris": "arl_tui.games.tetris.screens:SCREENS",
    "keepaway": "arl_tui.games.keepaway.screens:SCREENS",
    "gymnasium": "arl_tui.games.gymnasium.screens:SCREENS",
}
"""Name to where the screens of the program's own games are."""


class GameScreens(ABC):
    """One game in the app. Importing it imports neither compiled code nor widgets."""

    name: ClassVar[str]
    """Of the game (`core.plugins.GamePlugin.name`)."""
    words: ClassVar[Words]
    """What participants are told."""

    judging_module: ClassVar[str] = ""
    """Module that prepares the game of the feedback-lag task in a process of its own; "" where there is
    none."""
    judging: ClassVar[JudgingWords] = JudgingWords("", "")
    """What participants are told there."""

    def trial_view(self, prepared: bytes, schedule: Schedule, palette: "Palette") -> "TrialView":
        """Return what the trials of the feedback-lag task look like.

        Args:
            prepared: what `judging_module` has written.
            schedule: of the task.
            palette: colours.

        Raises:
            GameError: there is no such task for this game.
        """
        raise GameError(f"the delay of judging {self.name} cannot be measured: it has no feedback-lag task")

    def picture_ms(self, screen: ScreenConfig) -> float:
        """Return how long a session shows one picture, in milliseconds."""
        return float(screen.tick_ms)

    def words_for(self, protocol: Protocol) -> Words:
        """Return what participants of a protocol are told, in the language in use where it is not marked."""
        return self.words

    @abstractmethod
    def slower(self, screen: ScreenConfig) -> str:
        """Return a protocol's pace, and how it is made slower, in words."""

    def demo(self, trainer: TrainerConfig | None) -> Protocol:
        """Return a session of about a minute for `arl demo`.

        Args:
            trainer: the simulated participant who presses; None: the one of the game's default protocol.
        """
        default: Protocol = DEFAULTS[self.name]
        return msgspec.structs.replace(default, name="demo", trainer=trainer or default.trainer)

    def option(self, detail: dict[str, int], protocol: Protocol) -> str:
        """Return an option of a question in words.

        Args:
            detail: of the action, as in `core.events.StepTaken.detail`.
            protocol: of the session.
        """
        return ", ".join(f"{name} {value}" for name, value in detail.items())

    @abstractmethod
    def renderer(self, protocol: Protocol) -> "Renderer":
        """Return what makes pictures of a session's outputs; compiled code may come with it."""

    @abstractmethod
    def panel(self, protocol: Protocol, palette: "Palette") -> "Panel":
        """Return what shows these pictures in the play screen."""


def screens_called(name: str) -> GameScreens:
    """Return what the app has of a game.

    Raises:
        GameError: it has nothing of this game, or it cannot be loaded.
    """
    where = BUILT_IN.get(name) or _installed().get(name)
    if where is None:
        raise GameError(
            f"the game {name!r} has no screens: simulate it (`arl.screens` is the entry point of a package's "
            f"own)"
        )
    return _loaded(name, where)


def screens_of(protocol: Protocol) -> GameScreens:
    """Return what the app has of the game that a protocol is about."""
    return screens_called(protocol.game)


def words_of(game: str) -> Words:
    """Return the words of a game by its name (`core.session.protocol.Protocol.game`)."""
    return screens_called(game).words


def try_out(protocol: Protocol) -> None:
    """Make what a protocol is about, and what draws it; compiled code may come with it.

    Raises:
        GameError: it cannot be played in front of people; the message says what would be needed.
    """
    from core.registry import game_of  # here, not above: compiled code comes with it

    game_of(protocol).domain(protocol)
    screens_of(protocol).renderer(protocol)


@cache
def _installed() -> dict[str, str]:
    # Here, not above: it takes a tenth of a second, and the program's own games are found without it.
    from importlib.metadata import entry_points

    return {point.name: point.value for point in entry_points(group=GROUP)}


@cache
def _loaded(name: str, where: str) -> GameScreens:
    module, _, attribute = where.partition(":")
    try:
        screens = getattr(import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise GameError(f"the screens of {name!r} at {where} cannot be loaded: {error}") from error
    if not isinstance(screens, GameScreens):
        raise GameError(f"{where} is not an instance of a subclass of arl_tui.games.registry.GameScreens")
    return screens
