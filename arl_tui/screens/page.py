"""A page of text in a box: what all screens without a game have in common."""

from collections.abc import Iterable

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.language import bold_cap, key_for, tr
from core.feedback.keys import KeyConfig

IN_SESSION = {"pause": "space", "help": "f1", "stop": "ctrl+q,ctrl+c"}
"""What can be done during a game (`arl_tui.language.OWN_KEYS`), and the keys that are there for it even if
the program's own key is one for feedback."""


key_cap = bold_cap
"""A key as it is printed on the keyboard, in markup."""


class PageScreen(Screen[bool], inherit_bindings=False):
    """A titled box in the middle of the screen; opaque, so that a game beneath it is not seen."""

    HEADING = ""
    """In English, marked with `later`."""
    _left = False

    def compose(self) -> ComposeResult:
        """Lay out the title and what is under it."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(tr(self.HEADING), classes="title")
            yield from self.body()

    def body(self) -> Iterable[Widget]:
        """Return the widgets under the title."""
        raise NotImplementedError

    def leave(self, result: bool) -> None:
        """Dismiss this page once, however often it is asked to: a second time would take the game away."""
        if not self._left:
            self._left = True
            self.dismiss(result)


def feedback_keys(keys: KeyConfig) -> str:
    """Return the three feedback keys and what they mean, one per line, in markup."""
    return "\n".join(
        [
            f"  {bold_cap(keys.good)}  " + tr("[$text-success]good[/] - the computer did well"),
            f"  {bold_cap(keys.bad)}  " + tr("[$text-error]bad[/] - the computer did badly"),
            f"  {bold_cap(keys.retract)}  " + tr("take my last press back"),
        ]
    )


def session_keys(keys: KeyConfig) -> str:
    """Return the keys that steer the session, one per line, in markup."""
    shown = [bold_cap(session_key(action, keys)) for action in IN_SESSION]
    pause, guide, leave = shown
    return "  " + "    ".join(
        [f"{pause}  {tr('pause')}", f"{guide}  {tr('help')}", f"{leave}  {tr('stop the session')}"]
    )


def session_key(action: str, keys: KeyConfig) -> str:
    """Return the key that steers the session: the program's own, or, where that is a key for feedback, the
    one that is always there.

    Args:
        action: one of `IN_SESSION`.
        keys: for feedback.
    """
    own = key_for(action)
    return IN_SESSION[action].split(",")[0] if own in {keys.good, keys.bad, keys.retract} else own
