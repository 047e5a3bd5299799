"""The home page: a list to choose from, and the pages that ask for what a command needs."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

from textual.app import ComposeResult, SystemCommand
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.screen import Screen
from textual.widgets import Input, OptionList, Static
from textual.widgets.option_list import Option

from arl_tui.app.with_palette import PaletteApp
from arl_tui.language import later, tr
from arl_tui.participants import wrong_code
from arl_tui.start.entries import (
    GAMES,
    HOME,
    Arguments,
    Entry,
    command_line,
    sessions_in,
    studies_in,
    study_steps,
)

TITLE_WIDTH = 20
"""Cells of an entry's title."""
BACK = later("Choose with the arrow keys and {key_enter}, {key_f1} help, {key_stop} back")
LEAVE = later("Choose with the arrow keys and {key_enter}, {key_f1} help, {key_stop} leave")


class ListPage(Screen[Entry | None], inherit_bindings=False):
    """A list of entries; its result is the chosen one, or None to go back."""

    MORE_KEYS = (("↑ ↓", later("Choose")), ("Enter", later("Take what is chosen")))
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q,escape,ctrl+q,ctrl+c", "back", "Back", id="home.back", tooltip="Go back"),
    ]

    def __init__(
        self,
        heading: str,
        entries: Sequence[Entry],
        *,
        remark: str = "",
        is_first: bool = False,
        marked: int = 0,
    ) -> None:
        """Prepare a page.

        Args:
            heading: in English, marked with `later`.
            entries: what can be chosen.
            remark: below the list, as it is to be shown.
            is_first: there is no page to go back to.
            marked: which entry is marked at first, from 0.
        """
        super().__init__()
        self._heading = heading
        self._entries = entries
        self._remark = remark
        self._is_first = is_first
        self._marked = marked

    def compose(self) -> ComposeResult:
        """Lay out heading, list, the command of the marked entry, and the keys."""
        with VerticalScroll(classes="page start", can_focus=False):
            yield Static(tr(self._heading), classes="title")
            yield OptionList(*(Option(line_of(entry)) for entry in self._entries), id="entries", markup=False)
            yield Static(id="command")
            yield Static(self._remark, classes="path", markup=False)
            yield Static(tr(LEAVE if self._is_first else BACK), classes="call")

    def on_mount(self) -> None:
        """Let the list have the keyboard."""
        entries = self.query_one(OptionList)
        entries.focus()
        entries.highlighted = self._marked if self._entries else None
        if not self._entries:
            self.query_one("#command", Static).update(tr("There is none yet."))

    def on_option_list_option_highlighted(self, event: OptionList.OptionHighlighted) -> None:
        """Say how the marked entry is typed."""
        entry = self._entries[event.option_index]
        more = " ..." if entry.asks else ""
        self.query_one("#command", Static).update(
            f"  {command_line(entry.arguments)}{more}".replace("[", "\\[")
        )

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Leave with the chosen entry."""
        self.dismiss(self._entries[event.option_index])

    def choose(self, entry: Entry) -> None:
        """Leave with an entry, as if it had been marked."""
        self.dismiss(entry)

    @property
    def entries(self) -> Sequence[Entry]:
        """What can be chosen."""
        return self._entries

    def action_back(self) -> None:
        """Leave without a choice."""
        self.dismiss(None)


class CodePage(Screen[str | None], inherit_bindings=False):
    """Asks for a participant's code; its result is the code, or None to go back."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape,ctrl+q,ctrl+c", "back", "Back", id="code.back", tooltip="Go back"),
    ]

    def compose(self) -> ComposeResult:
        """Lay out the question."""
        with VerticalScroll(classes="page start", can_focus=False):
            yield Static(tr("Code of the participant"), classes="title")
            yield Static(tr("A code, never a name: letters, digits, - and _."))
            yield Input(value="P00", id="code")
            yield Static(id="why")
            yield Static(tr("Type it, then {key_enter}; {key_escape} back"), classes="call")

    def on_mount(self) -> None:
        """Let the code be typed at once."""
        self.query_one(Input).focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Leave with the code, if it is one."""
        code = event.value.strip()
        if wrong_code(code):
            self.query_one("#why", Static).update(tr("This is no code: use letters, digits, - and _ only."))
        else:
            self.dismiss(code)

    def action_back(self) -> None:
        """Leave without a code."""
        self.dismiss(None)


class HomeApp(PaletteApp[Arguments]):
    """Leads to a command; the app's result is that command, or None to leave."""

    CSS_PATH = "../app.tcss"
    TITLE = "arl"

    def __init__(
        self, recordings: Path, *, why_there: str = "", language: str = "en", marked: int = 0
    ) -> None:
        """Prepare.

        Args:
            recordings: folder of the recordings.
            why_there: who chose that folder, in words.
            language: of the words on the page.
            marked: which entry of the first page is marked, from 0.
        """
        super().__init__(language=language)
        self.marked = marked
        """The entry of the first page that was chosen last: it is marked when the page returns."""
        self._recordings = recordings
        self._why_there = why_there

    def on_mount(self) -> None:
        """Show the list of everything."""
        super().on_mount()
        self.push_screen(self._page("home"), self._chosen)

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Yield what is in the list, then what the keys do."""
        if isinstance(screen, ListPage):
            for entry in screen.entries:
                title = tr(entry.title) if entry.what else entry.title
                choose = partial(self.call_later, screen.choose, entry)
                yield SystemCommand(title, command_line(entry.arguments), choose)
        yield from super().get_system_commands(screen)

    def _page(self, asks: str, entry: Entry | None = None) -> ListPage:
        match asks:
            case "game":
                return ListPage(later("Which game?"), GAMES)
            case "study":
                return ListPage(later("Which study?"), studies_in(Path()))
            case "step":
                assert entry is not None, "a study has been chosen"
                return ListPage(later("What about this study?"), study_steps(Path(entry.title)))
            case "session":
                return ListPage(later("Which session?"), sessions_in(self._recordings))
            case _:
                where = tr("Recordings: {folder}", folder=self._recordings)
                return ListPage(
                    later("Agents that learn from a few key presses"),
                    HOME,
                    remark=f"{where} ({self._why_there})" if self._why_there else where,
                    is_first=True,
                    marked=self.marked,
                )

    def _chosen(self, entry: Entry | None) -> None:
        """Leave, go back to the list, or ask for what is missing."""
        if entry in HOME:
            self.marked = HOME.index(entry)
        if entry is None:
            self.exit(None)
        elif entry.asks in ("code", "calibrate"):
            self.push_screen(CodePage(), self._with_code(entry))
        elif entry.asks:
            self.push_screen(self._page(entry.asks, entry), self._chosen_below)
        else:
            self.exit(entry.arguments)

    def _chosen_below(self, entry: Entry | None) -> None:
        if entry is None:
            self.push_screen(self._page("home"), self._chosen)
        else:
            self._chosen(entry)

    def _with_code(self, entry: Entry) -> Callable[[str | None], None]:
        def take(code: str | None) -> None:
            if code is None:
                self.push_screen(self._page("home"), self._chosen)
            else:
                self.exit((*entry.arguments, "--participant", code))

        return take


def line_of(entry: Entry) -> str:
    """Return an entry as it stands in the list: its title, and what it is."""
    if not entry.what:
        return entry.title  # the name of a file
    return f"{tr(entry.title):<{TITLE_WIDTH}}{tr(entry.what)}"
