"""What can lie over the game: pause, help, the question whether to stop, and a window that is too small."""

from collections.abc import Iterable
from typing import ClassVar

from textual import events
from textual.binding import Binding, BindingType
from textual.geometry import Size
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.language import key_for, key_name, later, tr, trn
from arl_tui.screens.page import PageScreen, bar, keys_of_all, presses_of_all, session_keys
from arl_tui.words import Words
from core.session.protocol import Protocol


class PauseScreen(PageScreen):
    """The game waits."""

    HEADING = later("Pause")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("p,space,enter,escape", "back", "Go on", id="pause.back", tooltip="Go on with the game")
    ]

    def __init__(self, *, gap_s: float | None = None) -> None:
        """Prepare.

        Args:
            gap_s: how long the program stood still, seconds, where the session paused by itself for that.
        """
        super().__init__()
        self._gap_s = gap_s

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        if self._gap_s is not None:
            yield Static(
                trn(
                    "The computer slept or was held up for {n} second, so the game has been paused.",
                    "The computer slept or was held up for {n} seconds, so the game has been paused.",
                    round(self._gap_s),
                )
                + "\n"
            )
        yield Static(tr("The game waits for you. Take as long as you like; key presses do not count now."))
        yield Static(tr("Press {key_pause} or {key_space} to go on"), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)


class BreakScreen(PageScreen):
    """Between two blocks of a session: nothing happens until the participant goes on."""

    HEADING = later("Time for a break")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("space,enter", "back", "Go on", id="break.back", tooltip="Go on with the next block")
    ]

    def __init__(self, done: int, count: int) -> None:
        """Prepare.

        Args:
            done: games that have been watched.
            count: games of the whole session.
        """
        super().__init__()
        self._done, self._count = done, count

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        told = tr("{done} of {all} games are done.", done=self._done, all=self._count)
        yield Static(f"{told}\n{bar(self._done / self._count)}\n")
        yield Static(tr("Look away from the screen, and stretch. The game waits for you."))
        yield Static(tr("Press {key_space} to go on"), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)


class HelpScreen(PageScreen):
    """All keys and what they do."""

    HEADING = later("Help")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h,f1,space,enter,escape", "back", "Go on", id="help.back", tooltip="Go on with the game")
    ]

    def __init__(self, protocol: Protocol, words: Words) -> None:
        """Prepare.

        Args:
            protocol: which keys mean what, and how many presses there are.
            words: of the game, with its rules.
        """
        super().__init__()
        self._protocol = protocol
        self._words = words

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        words = self._words
        yield Static(tr(words.rules, task=words.task, about=words.about))
        yield Static(keys_of_all(self._protocol))
        yield Static(
            "\n"
            + tr(
                "You have {presses}. A press counts once, however long you hold the key. If a press does not "
                "count, the screen says why.",
                presses=presses_of_all(self._protocol),
            )
            + "\n"
        )
        yield Static(session_keys(*self._protocol.keys_of_people))
        yield Static(tr("Press {key_help} or {key_space} to go on"), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)


class StopScreen(PageScreen):
    """Asks whether to stop."""

    HEADING = later("Stop the session?")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("y", "stop", "Stop", id="stop.yes", tooltip="Stop and save"),
        Binding("n,space,enter,escape", "back", "Go on", id="stop.no", tooltip="Go on with the game"),
    ]

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(tr("What has happened so far is kept and counts in full."))
        yield Static(tr("Press {key_stop_yes} to stop, {key_no} or {key_space} to go on"), classes="call")

    def action_stop(self) -> None:
        """Stop."""
        self.leave(True)

    def action_back(self) -> None:
        """Go on."""
        self.leave(False)


class SmallWindowScreen(PageScreen):
    """Asks for a larger window, and leaves by itself when it is there; answers False to stop."""

    HEADING = later("This window is too small")
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q,ctrl+q,ctrl+c", "stop", "Stop", id="small.stop", tooltip="Stop; what is done is kept")
    ]

    def __init__(self, needed: Size) -> None:
        super().__init__()
        self._needed = needed

    def body(self) -> Iterable[Widget]:
        """Return the text."""
        yield Static(
            tr(
                "{columns} columns and {lines} lines are needed. It goes on when the window is larger, or "
                "the letters are smaller. {stop} stops.",
                columns=self._needed.width,
                lines=self._needed.height,
                stop=key_name(key_for("stop")),
            )
        )

    def action_stop(self) -> None:
        """Stop."""
        self.leave(False)

    def on_screen_resume(self) -> None:
        """Go on at once where the window has grown before this page was there."""
        self.call_later(lambda: self._leave_if(self.app.size))

    def on_resize(self, event: events.Resize) -> None:
        """Go on when there is room."""
        self._leave_if(event.size)

    def _leave_if(self, size: Size) -> None:
        if fits_into(self._needed, size):
            self.leave(True)


def fits_into(needed: Size, available: Size) -> bool:
    """Return whether a game of this size can be shown in full."""
    return available.width >= needed.width and available.height >= needed.height
