"""An app outside of sessions: it has a palette of commands, which no session has."""

from collections.abc import Iterable
from functools import partial
from typing import Any, ClassVar, TypeVar

from textual.app import SystemCommand
from textual.binding import Binding, BindingType
from textual.dom import DOMNode
from textual.screen import Screen

from arl_tui.app.plain_app import PlainApp
from arl_tui.language import key_name, tr

Result = TypeVar("Result")


class PaletteApp(PlainApp[Result]):
    """An app whose page can be steered by the names of its commands, too: Ctrl+P."""

    ENABLE_COMMAND_PALETTE = True
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(
            "ctrl+p", "command_palette", "Commands", id="app.palette", tooltip="Find a command by its name"
        )
    ]

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Yield what the page's keys do, each once."""
        seen = {"command_palette"}
        for key, active in screen.active_bindings.items():
            binding = active.binding
            if binding.action in seen or not binding.id or not active.enabled:
                continue
            seen.add(binding.action)
            what = tr(binding.tooltip or binding.description)
            run = partial(self._run_for, active.node, binding.action)
            yield SystemCommand(f"{tr(binding.description)}  ({key_name(key)})", what, run)

    def _run_for(self, node: DOMNode, action: str) -> None:
        self.call_later(self.run_action, action, node)
