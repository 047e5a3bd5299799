"""F1 on a page that has no help of its own: what its keys do."""

from collections.abc import Iterable
from typing import Any, ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import Static

from arl_tui.language import key_name, tr

SIGNS = {"up": "↑", "down": "↓", "left": "←", "right": "→"}
"""How keys without a letter are shown."""
HELP = Binding("f1", "page_help", "Help", id="app.help", tooltip="What the keys of this page do")
"""For every page that the app's own binding does not reach."""


class KeyHelp(Screen[None], inherit_bindings=False):
    """What each key of a page does."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(
            "f1,h,space,enter,escape,q",
            "back",
            "Go on",
            id="key-help.back",
            tooltip="Back to the page",
        )
    ]

    def __init__(self, page: Screen[Any]) -> None:
        """Prepare the help on a page."""
        super().__init__()
        self._rows = list(rows_of(page))

    def compose(self) -> ComposeResult:
        """Lay out the keys and their meanings."""
        widest = max((len(keys) for keys, _ in self._rows), default=0)
        with VerticalScroll(classes="page", can_focus=False):
            yield Static(tr("What the keys of this page do"), classes="title")
            for keys, meaning in self._rows:
                yield Static(f"  [b]{keys:<{widest}}[/]   {meaning}")
            yield Static(tr("Press {key_f1} or {key_space} to go on"), classes="call")

    def action_back(self) -> None:
        """Go on."""
        self.dismiss()


def rows_of(page: Screen[Any]) -> Iterable[tuple[str, str]]:
    """Yield keys and meaning of each thing that can be done on a page, as they are bound now.

    Keys that a page reads itself are in its attribute `MORE_KEYS`: pairs of keys and English words.
    """
    for keys, words in getattr(page, "MORE_KEYS", ()):
        yield keys, tr(words)
    found: dict[str, tuple[list[str], str]] = {}
    for key, active in page.active_bindings.items():
        binding = active.binding
        # Textual's own widgets have keys without an id. Ctrl+C is bound everywhere, and need not be named.
        if not binding.id or binding.action == "page_help" or key == "ctrl+c":
            continue
        keys, _ = found.setdefault(binding.action, ([], tr(binding.tooltip or binding.description)))
        keys.append(SIGNS.get(key) or key_name(key))
    for keys, meaning in found.values():
        yield ", ".join(keys), meaning
