"""A page of text in a box: what all screens without a game have in common."""

from collections.abc import Iterable

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from core.feedback.keys import KeyConfig


class PageScreen(Screen[bool], inherit_bindings=False):
    """A titled box in the middle of the screen; opaque, so that a game beneath it is not seen."""

    HEADING = ""
    _left = False

    def compose(self) -> ComposeResult:
        """Lay out the title and what is under it."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(self.HEADING, classes="title")
            yield from self.body()

    def body(self) -> Iterable[Widget]:
        """Return the widgets under the title."""
        raise NotImplementedError

    def leave(self, result: bool) -> None:
        """Dismiss this page once, however often it is asked to: a second time would take the game away."""
        if not self._left:
            self._left = True
            self.dismiss(result)


def key_cap(key: str) -> str:
    """Return a key as it is printed on the keyboard, in markup."""
    return f"[reverse b] {key.upper()} [/]"


def feedback_keys(keys: KeyConfig) -> str:
    """Return the three feedback keys and what they mean, one per line, in markup."""
    return (
        f"  {key_cap(keys.good)}  [$text-success]good[/] - the computer did well\n"
        f"  {key_cap(keys.bad)}  [$text-error]bad[/] - the computer did badly\n"
        f"  {key_cap(keys.retract)}  take my last press back"
    )


def session_keys(keys: KeyConfig) -> str:
    """Return the keys that steer the session, one per line, in markup."""
    used = {keys.good, keys.bad, keys.retract}
    pause = "Space" if "p" in used else "P"
    guide = "F1" if "h" in used else "H"
    leave = "Ctrl+Q" if "q" in used else "Q"
    return f"  {key_cap(pause)}  pause    {key_cap(guide)}  help    {key_cap(leave)}  stop the session"
