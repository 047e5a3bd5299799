"""What the app has of Gymnasium environments (`arl_tui.games.registry`)."""

from dataclasses import replace
from functools import partial
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
WELCOME = later(
    "You will watch a computer try a task, {games}: {task}. It does not know yet how to do it well. "
    "{practises}You can help it: tell it what you think of what it has just done."
)
"""With a task in words."""
RULES = later(
    "The task: {task}. {about}The screen says what the computer has just done, and its points so far: the "
    "more, the better.\n\nTell it what you think of what it has just done:\n"
)
"""With a task in words."""
TASKS: dict[str, tuple[str, str]] = {
    "CartPole": (
        later("keep the pole upright"),
        later("The cart can be pushed to one side or the other. Each step until the pole falls is a point. "),
    ),
    "MountainCar": (
        later("get the car up to the flag"),
        later("Its engine is too weak for the hill, so the car has to swing. Each step costs a point. "),
    ),
    "Acrobot": (
        later("swing the lower end up to the line"),
        later("Only the joint in the middle can be pushed. Each step costs a point. "),
    ),
    "LunarLander": (
        later("land softly between the two flags"),
        later("A crash costs many points, and so does a detour. "),
    ),
    "FrozenLake": (
        later("cross the ice to the goal, around the holes"),
        later("The ice is slippery: it often slides another way than it meant. The goal is one point. "),
    ),
    "CliffWalking": (
        later("walk to the goal, and not over the cliff"),
        later("Each step costs a point, a fall a hundred. "),
    ),
    "Blackjack": (
        later("get close to 21, and not above"),
        later("A game won is a point, a game lost costs one. "),
    ),
    "Taxi": (
        later("fetch the passenger and bring them to the hotel"),
        later(
            "Each step costs a point, a stop at a wrong place ten; the passenger at the right one is twenty. "
        ),
    ),
}
"""Of Gymnasium's own environments, by their name without its version: the task, and more of it."""
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

    def words_for(self, protocol: Protocol) -> Words:
        """Return the words with the protocol's own task, or with that of an environment that is known."""
        from textual.markup import escape  # here, not above: words are needed without widgets

        from core.interop.gymnasium.config import GymnasiumConfig

        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        task, about = TASKS.get(_base(protocol.domain.env), ("", ""))
        if protocol.domain.task:
            task, about = escape(protocol.domain.task), ""
        else:
            task, about = tr(task), tr(about)
        if not task:
            return WORDS
        return replace(WORDS, welcome=WELCOME, rules=RULES, task=task, about=about)

    def slower(self, screen: ScreenConfig) -> str:
        """Return the pace and how it is made slower."""
        return f"[screen] tick_ms is {screen.tick_ms}: more is slower"

    def option(self, detail: dict[str, int], protocol: Protocol) -> str:
        """Return the action in words where there are any (`[domain] actions`, `ACTIONS`), else its number."""
        return action_name(protocol, detail["action"])

    def renderer(self, protocol: Protocol) -> "GymnasiumRenderer":
        """Return what plays the environment again and lets it draw itself."""
        from arl_tui.games.gymnasium.renderer import GymnasiumRenderer
        from core.interop.gymnasium.config import GymnasiumConfig

        assert isinstance(protocol.domain, GymnasiumConfig), "a protocol of Gymnasium"
        return GymnasiumRenderer(protocol.domain.env, protocol.screen.tick_ms * NS_PER_MS)

    def panel(self, protocol: Protocol, palette: "Palette") -> "GymnasiumPanel":
        """Return the picture and what stands beside it."""
        from arl_tui.games.gymnasium.panel import GymnasiumPanel

        return GymnasiumPanel(partial(action_name, protocol))


def action_name(protocol: Protocol, number: int) -> str:
    """Return what participants read of an action, by the environment's own number of it."""
    from core.interop.gymnasium.config import GymnasiumConfig

    domain = protocol.domain
    assert isinstance(domain, GymnasiumConfig), "a protocol of Gymnasium"
    names = domain.actions or tuple(tr(name) for name in ACTIONS.get(_base(domain.env), ()))
    return names[number] if 0 <= number < len(names) else tr("action {number}", number=number)


def _base(env: str) -> str:
    """Return the name of an environment without its version; variants of one task have its words."""
    name = env.rpartition("-v")[0]
    return {"FrozenLake8x8": "FrozenLake", "CliffWalkingSlippery": "CliffWalking"}.get(name, name)


SCREENS = GymnasiumScreens()
