"""A page of text in a box: what all screens without a game have in common."""

from collections.abc import Iterable

from textual import events
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from core.feedback.keys import KeyConfig

MORE = "more below: ↓ and Page Down"
PAGE_LINES = 10
"""How far the page keys move a text, lines."""


class PageScreen(Screen[bool], inherit_bindings=False):
    """A titled box in the middle of the screen; opaque, so that a game beneath it is not seen."""

    HEADING = ""
    _left = False

    def compose(self) -> ComposeResult:
        """Lay out the title and what is under it; what can be pressed stays in sight below a long text."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(self.HEADING, classes="title")
            yield from self.body()

    def on_resize(self, event: events.Resize) -> None:
        """Say where a text goes on below the window."""
        self.call_after_refresh(self._tell_more)

    def _tell_more(self) -> None:
        if self._left or not self.is_attached:
            return  # the page has been left before its turn came
        for scroll in self.query(VerticalScroll):
            below = scroll.max_scroll_y > 0 and scroll.scroll_target_y < scroll.max_scroll_y
            scroll.border_subtitle = MORE if below else ""

    def on_key(self, event: events.Key) -> None:
        """Move a text that is longer than the window."""
        if self._left:
            return
        scroll = self.query_one(VerticalScroll)
        by = {"up": -1, "down": 1, "pageup": -PAGE_LINES, "pagedown": PAGE_LINES}.get(event.key)
        if by is not None and scroll.max_scroll_y > 0:
            event.stop()
            scroll.scroll_relative(y=by, animate=False)
            self.call_after_refresh(self._tell_more)

    def body(self) -> Iterable[Widget]:
        """Return the widgets under the title."""
        raise NotImplementedError

    def leave(self, result: bool) -> None:
        """Dismiss this page once, however often it is asked to: a second time would take the game away."""
        if not self._left:
            self._left = True
            self.dismiss(result)


BAR_WIDTH = 20
"""Cells."""


def bar(fraction: float) -> str:
    """Return a bar for a fraction in [0, 1], and the fraction in per cent."""
    done = round(fraction * BAR_WIDTH)
    return f"{'━' * done}[dim]{'─' * (BAR_WIDTH - done)}[/] {fraction:.0%}"


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
