"""What the app has of Gymnasium environments (`arl_tui.games.registry`)."""

from typing import TYPE_CHECKING

from arl_tui.games.registry import GameScreens
from arl_tui.language import later, later_n, tr
from arl_tui.words import Words
from core.numerics.clock import NS_PER_MS
from core.session.protocol import Protocol, ScreenConfig

if TYPE_CHECKING:
    from arl_tui.games.gymnasium.panel import GymnasiumPanel
    from arl_tui.games.gymnasium.renderer import GymnasiumRenderer
    from arl_tui.palette import Palette

WORDS = Words(
    heading=later("Teach a computer a task"),
    welcome=later(
        "You will watch a computer try a task, {games}. It does not know yet how to do it well. "
        "{practises}You can help it: "
        "tell it what you think of what it has just done."
    ),
    rules=later(
        "The computer does one thing after another, and the task is scored as you see beside it: the more, "
        "the better."
        "\n\nTell it what you think of what it has just done:\n"
    ),
    practises=later("It practises on its own between games. "),
    performance=later("Reward"),
    units=later_n("point", "points"),
    steps=later("steps"),
    step=later("step"),
)
ACTIONS: dict[str, tuple[str, ...]] = {
    "CartPole": (later("push to the left"), later("push to the right")),
    "MountainCar": (later("drive to the left"), later("let it roll"), later("drive to the right")),
    "Acrobot": (later("push one way"), later("do nothing"), later("push the other way")),
    "LunarLander": (later("do nothing"), later("left engine"), later("main engine"), later("right engine")),
    "FrozenLake": (later("go left"), later("go down"), later("go right"), later("go up")),
    "CliffWalking": (later("go up"), later("go right"), later("go down"), later("go left")),
    "Blackjack": (later("stick"), later("take a card")),
    "Taxi": (
        later("go down"),
        later("go up"),
        later("go right"),
        later("go left"),
        later("pick up"),
        later("drop off"),
    ),
}
"""What the actions of Gymnasium's own environments are, by the environment's name without its version:
Gymnasium gives them numbers only (its documentation of each environment names them)."""


class GymnasiumScreens(GameScreens):
    """The environment's own picture, and figures."""

    name = "gymnasium"
    words = WORDS

    def slower(self, screen: ScreenConfig) -> str:
        """Return the pace and how it is made slower."""
        return f"[screen] tick_ms is {screen.tick_ms}: more is slower"

    def option(self, detail: dict[str, int], protocol: Protocol) -> str:
        """Return the action in words where it is one of `ACTIONS`, else its number."""
        from core.interop.gymnasium.config import GymnasiumConfig

        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        names = ACTIONS.get(protocol.domain.env.rpartition("-v")[0], ())
        number = detail["action"]
        if 0 <= number < len(names):
            return tr(names[number])
        return tr("action {number}", number=number)

    def renderer(self, protocol: Protocol) -> "GymnasiumRenderer":
        """Return what plays the environment again and lets it draw itself."""
        from arl_tui.games.gymnasium.renderer import GymnasiumRenderer
        from core.interop.gymnasium.config import GymnasiumConfig

        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        return GymnasiumRenderer(protocol.domain.env, protocol.screen.tick_ms * NS_PER_MS)

    def panel(self, protocol: Protocol, palette: "Palette") -> "GymnasiumPanel":
        """Return the picture and what stands beside it."""
        from arl_tui.games.gymnasium.panel import GymnasiumPanel

        return GymnasiumPanel()


SCREENS = GymnasiumScreens()
