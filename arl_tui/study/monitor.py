"""`arl study status --watch`: running sittings from another terminal, and notes of the experimenter."""

from collections.abc import Callable
from typing import ClassVar

from rich.markup import escape
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import VerticalScroll
from textual.widgets import Input, Static

from arl_tui.app.with_palette import PaletteApp
from studies.lab.watching import RunningRow

LOOK_S = 1.0
"""How often the files are looked at, seconds."""
KEYS = "[reverse] N [/] note   [reverse] Q [/] leave   [reverse] F1 [/] help   [reverse] Ctrl+P [/] commands"


class Monitor(PaletteApp[None]):
    """Shows what the files say, once a second; asks nobody and disturbs nothing."""

    TITLE = "arl study status"
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("n", "note", "Note", id="monitor.note", tooltip="Write a note down"),
        Binding("escape", "no_note", "No note", id="monitor.no-note", show=False),
        Binding("q,ctrl+q,ctrl+c", "leave", "Leave", id="monitor.leave", tooltip="Leave; nothing is stopped"),
    ]

    def __init__(
        self,
        heading: str,
        look: Callable[[], tuple[str, tuple[RunningRow, ...]]],
        note: Callable[[str, tuple[str, ...]], str],
    ) -> None:
        """Prepare.

        Args:
            heading: names the study.
            look: returns how far the study is, in a line, and the running sittings.
            note: keeps a note with the codes of running participants; returns what to say about it.
        """
        super().__init__()
        self._heading = heading
        self._look = look
        self._note = note
        self._codes: tuple[str, ...] = ()

    def compose(self) -> ComposeResult:
        """Lay out heading, sittings, the line for a note, and the keys."""
        yield Static(self._heading, id="heading")
        with VerticalScroll(can_focus=False):
            yield Static(id="sittings")
        yield Static(id="said")
        yield Input(placeholder="Note, then Enter", id="note", disabled=True)
        yield Static(KEYS)

    def on_mount(self) -> None:
        """Look now, and every second."""
        super().on_mount()
        self.query_one("#note").display = False
        self.show()
        self.set_interval(LOOK_S, self.show)

    def show(self) -> None:
        """Write anew what the files say."""
        so_far, rows = self._look()
        self._codes = tuple(row.code for row in rows)
        lines = [so_far, ""]
        for row in rows:
            lines += lines_of(row)
        if not rows:
            lines.append("No sitting is running.")
        self.query_one("#sittings", Static).update("\n".join(lines))

    def action_note(self) -> None:
        """Ask for a note."""
        field = self.query_one("#note", Input)
        field.display, field.disabled = True, False
        field.focus()

    def action_no_note(self) -> None:
        """Leave the note."""
        field = self.query_one("#note", Input)
        field.value = ""
        field.display, field.disabled = False, True

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Keep the note."""
        if event.value.strip():
            self.query_one("#said", Static).update(escape(self._note(event.value.strip(), self._codes)))
        self.action_no_note()

    def action_leave(self) -> None:
        """Leave; the sittings go on."""
        self.exit()


def lines_of(row: RunningRow) -> list[str]:
    """Return a sitting in lines, markup."""
    silent = "now" if row.silent_s < 2 else f"{row.silent_s:.0f} s ago"
    lines = [f"[b]{escape(row.code)}[/]  {escape(row.where)}   last sign of life: {silent}"]
    if row.session is not None:
        lag = "-" if row.session.lag_ms is None else f"{row.session.lag_ms:.0f} ms"
        lines.append(
            f"    game {row.session.games}, {row.session.presses_per_minute:.1f} presses per minute, lag "
            f"{lag}"
        )
    lines += [f"    [b]![/] {escape(warning)}" for warning in row.warnings]
    return lines
