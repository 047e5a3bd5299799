"""All keys of the viewer."""

from collections.abc import Iterable
from typing import ClassVar

from rich.text import Text
from textual.binding import Binding, BindingType
from textual.widget import Widget
from textual.widgets import Static

from arl_tui.screens.page import PageScreen

ROWS = (
    ("space", "play, pause"), ("+ -", "speed, 1/8 to 64"), (". ,", "next, previous frame"),
    ("→ ←", "next, previous step"), ("] [", "next, previous press"), ("↓ ↑", "next, previous game"),
    ("shift+→ ←", "scrub; page down, page up: far"), ("home end", "beginning, end"),
    ("z x", "timeline closer, further (or the wheel)"), ("j", "go to a press by its number"),
    ("c C", "credit rule on the strip: next, previous"), ("m", "marks on the game on, off"),
    ("w", "what-if with the rule on the strip; again: end it"), ("n N", "next, previous decision that differs"),  # noqa: E501
    ("1-9", "tag this moment"), ("t", "write a note"), ("d T", "remove the tag at hand; go to the next"),
    ("e", "write tagged moments as CSV"), ("p", "save the screen as SVG and PNG"), ("q", "leave"),
)  # fmt: skip


class ViewerHelp(PageScreen):
    """What every key does."""

    HEADING = "Looking at a session"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("h,f1,q,space,enter,escape", "back", "Go on", id="viewer-help.back", tooltip="Go on")
    ]

    def body(self) -> Iterable[Widget]:
        """Return the keys and their meanings."""
        widest = max(len(key) for key, _ in ROWS)
        text = Text()
        for key, meaning in ROWS:
            # No markup: brackets are keys here, and small letters are other keys than capital ones.
            text.append(f" {key} ", style="bold reverse")
            text.append(f"{' ' * (widest - len(key))}  {meaning}\n")
        text.rstrip()
        yield Static(text)

    def action_back(self) -> None:
        """Go on."""
        self.leave(True)
