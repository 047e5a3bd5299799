"""A page of text in a box: what all screens without a game have in common."""

from collections.abc import Iterable
from itertools import zip_longest

from textual.app import ComposeResult
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.feedback_words import short_words, word_of
from core.feedback.keys import KeyConfig
from core.session.protocol import Protocol

MOST_LINES = 3
"""More people than this share lines: the smallest window has no more."""
PAGE_WIDTH = 74
"""Columns of a page in the smallest window."""


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
    """Return the feedback keys and what they mean, one or two per line, in markup."""
    if keys.graded:
        grades = "  ".join(f"{key_cap(key)} {word_of(value)}" for key, value in keys.meanings.items())
        return f"  {grades}\n  {key_cap(keys.retract)} take my last press back"
    return (
        f"  {key_cap(keys.good)}  [$text-success]good[/] - the computer did well\n"
        f"  {key_cap(keys.bad)}  [$text-error]bad[/] - the computer did badly\n"
        f"  {key_cap(keys.retract)}  take my last press back"
    )


def keys_of_all(protocol: Protocol) -> str:
    """Return the feedback keys of whoever takes part, in markup: of several people a line for each, or two in
    a line where there are many.
    """
    if not protocol.people:
        return feedback_keys(protocol.keys)
    widest = max(len(person.name) for person in protocol.people)
    back = "take back" if len(protocol.people) <= MOST_LINES else "back"
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
        return f"{most[0]} presses in each game"
    if len(set(most)) == 1:
        return f"{most[0]} presses each in every game"
    of_each = (f"{person.name} {n}" for person, n in zip(protocol.people, most, strict=True))
    return f"so many presses in each game: {', '.join(of_each)}"


def session_keys(*keys: KeyConfig) -> str:
    """Return the keys that steer the session, one per line, in markup; `keys` are those of each person."""
    used = {letter for each in keys for letter in each.letters}
    pause = "Space" if "p" in used else "P"
    guide = "F1" if "h" in used else "H"
    leave = "Ctrl+Q" if "q" in used else "Q"
    return f"  {key_cap(pause)}  pause    {key_cap(guide)}  help    {key_cap(leave)}  stop the session"
