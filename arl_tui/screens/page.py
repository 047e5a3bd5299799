"""A page of text in a box: what all screens without a game have in common."""

from collections.abc import Iterable
from itertools import zip_longest

from textual import events
from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.feedback_words import short_words, word_of
from arl_tui.language import bold_cap, key_for, later, tr, trn
from core.feedback.keys import KeyConfig
from core.session.protocol import Protocol

MOST_LINES = 3
"""More people than this share lines: the smallest window has no more."""
PAGE_WIDTH = 74
"""Columns of a page in the smallest window."""

IN_SESSION = {"pause": "space", "help": "f1", "stop": "ctrl+q,ctrl+c"}
"""What can be done during a game (`arl_tui.language.OWN_KEYS`), and the keys that are there for it even if
the program's own key is one for feedback."""
MORE = later("more below: ↓ and Page Down")
PAGE_LINES = 10
"""How far the page keys move a text, lines."""

key_cap = bold_cap
"""A key as it is printed on the keyboard, in markup."""


class PageScreen(Screen[bool], inherit_bindings=False):
    """A titled box in the middle of the screen; opaque, so that a game beneath it is not seen."""

    HEADING = ""
    """In English, marked with `later`."""
    _left = False

    def compose(self) -> ComposeResult:
        """Lay out the title and what is under it; what can be pressed stays in sight below a long text."""
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(tr(self.HEADING), classes="title")
            yield from self.body()

    def on_resize(self, event: events.Resize) -> None:
        """Say where a text goes on below the window."""
        self.call_after_refresh(self._tell_more)

    def _tell_more(self) -> None:
        if self._left or not self.is_attached:
            return  # the page has been left before its turn came
        for scroll in self.query(VerticalScroll):
            below = scroll.max_scroll_y > 0 and scroll.scroll_target_y < scroll.max_scroll_y
            scroll.border_subtitle = tr(MORE) if below else ""

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


def feedback_keys(keys: KeyConfig) -> str:
    """Return the feedback keys and what they mean, one or two per line, in markup."""
    if keys.graded:
        grades = "  ".join(f"{key_cap(key)} {word_of(value)}" for key, value in keys.meanings.items())
        return f"  {grades}\n  {key_cap(keys.retract)} " + tr("take my last press back")
    return "\n".join(
        [
            f"  {key_cap(keys.good)}  " + tr("[$text-success]good[/] - the computer did well"),
            f"  {key_cap(keys.bad)}  " + tr("[$text-error]bad[/] - the computer did badly"),
            f"  {key_cap(keys.retract)}  " + tr("take my last press back"),
        ]
    )


def keys_of_all(protocol: Protocol) -> str:
    """Return the feedback keys of all who take part, in markup: of several participants a line for each, or
    two in a line where there are many.
    """
    if not protocol.people:
        return feedback_keys(protocol.keys)
    widest = max(len(person.name) for person in protocol.people)
    back = tr("take back") if len(protocol.people) <= MOST_LINES else tr("back")
    entries, widths = [], []
    for person, keys in zip(protocol.people, protocol.keys_of_people, strict=True):
        caps = [*short_words(keys), (keys.retract, back)]
        named = "  ".join(f"{key_cap(key)} {word}" for key, word in caps)
        entries.append(f"{person.name:{widest}}  {named}")
        widths.append(widest + sum(len(word) + 6 for _, word in caps))
    if len(entries) <= MOST_LINES or 2 * max(widths) + 4 > PAGE_WIDTH:
        return "\n".join(f"  {entry}" for entry in entries)
    gaps = [" " * (max(widths) - width + 4) for width in widths]
    lefts = [f"  {entry}{gap}" for entry, gap in zip(entries[::2], gaps[::2], strict=True)]
    return "\n".join(left + right for left, right in zip_longest(lefts, entries[1::2], fillvalue=""))


def presses_of_all(protocol: Protocol) -> str:
    """Return how many presses there are in each game, in words: "5 presses in each game"."""
    most = [keys.max_presses_per_episode for keys in protocol.keys_of_people]
    if len(most) == 1:
        return trn("{n} press in each game", "{n} presses in each game", most[0])
    if len(set(most)) == 1:
        return trn("{n} press each in every game", "{n} presses each in every game", most[0])
    of_each = ", ".join(f"{person.name} {n}" for person, n in zip(protocol.people, most, strict=True))
    return tr("so many presses in each game: {of_each}", of_each=of_each)


def session_keys(*keys: KeyConfig) -> str:
    """Return the keys that steer the session, one per line, in markup; `keys` are those of each person."""
    pause, guide, leave = (key_cap(session_key(action, *keys)) for action in IN_SESSION)
    return "  " + "    ".join(
        [f"{pause}  {tr('pause')}", f"{guide}  {tr('help')}", f"{leave}  {tr('stop the session')}"]
    )


def session_key(action: str, *keys: KeyConfig) -> str:
    """Return the key that steers the session: the program's own, or, where that is a key for feedback, the
    one that is always there.

    Args:
        action: one of `IN_SESSION`.
        keys: for feedback, of each person.
    """
    own = key_for(action)
    used = {letter for each in keys for letter in each.letters}
    return IN_SESSION[action].split(",")[0] if own in used else own
