"""What shows a study's pages and runs its sessions: a terminal, or a simulated participant's headless
screens.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol

from textual.screen import Screen

from arl_tui.study.page_app import PageApp, Results
from studies.lab.config import Block, Calibration, Practice

How = Literal["finished", "stopped", "window-closed", "failed"]
Pages = Sequence[Callable[[], Screen[object]]]
OnResult = Callable[[int, object], None]


def ignore_result(number: int, result: object) -> None:
    """Take a page's result and do nothing."""


def do_nothing() -> None:
    """Do nothing."""


@dataclass(frozen=True, slots=True)
class Played:
    """What is left of a session, a practice or a calibration."""

    how: How
    file: str = ""
    """Name of the recording in the participant's folder; empty where nothing was recorded."""
    games: tuple[float, ...] = ()
    """Performance of each watched game."""
    presses: int = 0
    """Accepted presses that were not taken back."""
    taken_back: int = 0
    """Accepted presses that were taken back."""
    unit: str = ""
    """Of the performances."""
    trouble: str = ""
    """For the experimenter, where it failed."""
    more_files: tuple[str, ...] = ()
    """Names of further files: a calibration has one per task."""
    remark: str = ""
    """For the experimenter, where it did not fail."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockCall:
    """A session, a practice or a calibration that a study asks for."""

    step: Block | Practice | Calibration
    condition: str
    code: str
    folder: Path
    seed: int
    resume: Path | None
    """The recording that this session goes on with."""
    facts: Mapping[str, str]
    """Study, place, sitting and condition, for the recording's header."""
    part: str = ""
    """Where in the visit the step is, in words, for the participant."""
    on_gone: Callable[[], None] = do_nothing
    """Called where the window is closed and the process is about to end."""


class Presenter(Protocol):
    """What shows pages and plays sessions."""

    on_gone: Callable[[], None]
    """Called where the window is closed and the process is about to end."""

    def pages(self, pages: Pages, on_result: OnResult = ignore_result) -> tuple[Results, bool]:
        """Show pages; return their results, and whether the window was closed.

        `on_result` is called with each page's number and result before the next page is shown.
        """
        ...

    def play(self, call: BlockCall) -> Played:
        """Run a session, a practice or a calibration."""
        ...


class Terminal:
    """Pages in this terminal; `play` is handed in, because it belongs to the commands."""

    def __init__(
        self, play: Callable[[BlockCall], Played], *, theme: str = "dark", language: str = "en"
    ) -> None:
        """Prepare.

        Args:
            play: runs a session, a practice or a calibration.
            theme: of the pages (`arl_tui.themes`).
            language: of the words that are not the study's own.
        """
        self.play = play
        self._theme = theme
        self._language = language
        self.on_gone: Callable[[], None] = do_nothing

    def pages(self, pages: Pages, on_result: OnResult = ignore_result) -> tuple[Results, bool]:
        """Show pages in an app of their own."""
        app = PageApp(pages, on_result, theme=self._theme, language=self._language)
        app.before_leaving = self.on_gone
        results = app.run_in_terminal()
        return (app.results if results is None else results), app.ended_by is not None or results is None
