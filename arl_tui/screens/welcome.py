"""The first screen: what will happen, in plain words, and which keys there are."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, ClassVar, cast

from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.screens.page import Page, feedback_keys
from arl_tui.words import words_of
from core.protocol import Protocol

if TYPE_CHECKING:
    from arl_tui.app import ArlApp


class WelcomeScreen(Page):
    """Explains, and waits for the start key while the worker warms up."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "start", "Start", id="welcome.start", tooltip="Start the session"),
        Binding("q,ctrl+q,ctrl+c", "leave", "Leave", id="welcome.leave", tooltip="Leave without starting"),
    ]

    def __init__(self, protocol: Protocol, participant: str, *, simulated: bool) -> None:
        super().__init__()
        self._protocol = protocol
        self._words = words_of(protocol.game)
        self.HEADING = self._words.heading
        self._participant = participant
        self._simulated = simulated
        self._started = False

    def body(self) -> Iterable[Widget]:
        """Return the explanation."""
        keys, session = self._protocol.keys, self._protocol.session
        games = "one game" if session.episodes == 1 else f"{session.episodes} games"
        presses = keys.max_presses_per_episode
        words = self._words
        practises = words.practises if session.unseen_between else ""
        yield Static(words.welcome.format(games=games, practises=practises))
        yield Static(f"\n{feedback_keys(keys)}\n")
        yield Static(
            f"You have [b]{presses} presses in each game[/], so save them for what matters, and press as soon as "
            "you have made up your mind. Nothing you press is wrong: only your opinion counts."
        )
        if keys.wrong_press_rate > 0:
            yield Static(
                "\nNow and then the screen asks you to press the [b]wrong[/] key on purpose. Please do it then: "
                "we want to know how the computer copes with mistakes."
            )
        if self._simulated:
            yield Static(
                "\nThis is a demonstration: a [b]simulated person[/] presses keys as well. You may press, too, "
                "or just watch."
            )
        yield Static(
            "\n[dim]Your key presses and their times are written to a file on this computer under the code[/] "
            f"[b]{self._participant}[/][dim]. You can pause or stop at any time.[/]"
        )
        yield Static(id="call", classes="call")

    def on_mount(self) -> None:
        """Say whether the start key works already."""
        self.show_ready()

    def show_ready(self) -> None:
        """Update the last line, and start if that has been asked for."""
        if not self.query("#call"):
            return  # Not laid out yet: `on_mount` comes back here.
        app = cast("ArlApp", self.app)
        if app.live.ready:
            line = "Press [reverse] Enter [/] to start, [reverse] Q [/] to leave"
        elif self._started:
            line = "Getting ready ..."
        else:
            line = "Press [reverse] Enter [/] to start, [reverse] Q [/] to leave  [dim](getting ready)[/]"
        self.query_one("#call", Static).update(line)
        if app.live.ready and self._started:
            app.begin()

    def action_start(self) -> None:
        """Start, or as soon as the worker is ready."""
        if not self._started:
            self._started = True
            self.show_ready()

    def action_leave(self) -> None:
        """Leave: nothing has been recorded."""
        cast("ArlApp", self.app).leave()
