"""Shows pages of a study one after the other, in an app of their own."""

from collections.abc import Callable, Sequence
from pathlib import Path

from textual.screen import Screen

from arl_tui.app.plain_app import PlainApp

Results = list[object]
"""One result per page that was left; see `arl_tui.study.pages`."""


class PageApp(PlainApp[Results]):
    """Shows each page until it is left; ends early where a page is left with None (stop) or False
    (decline).
    """

    CSS_PATH = Path(__file__).parent.parent / "app.tcss"
    TITLE = "arl"

    def __init__(
        self,
        pages: Sequence[Callable[[], Screen[object]]],
        on_result: Callable[[int, object], None] = lambda number, result: None,
        *,
        theme: str = "dark",
        language: str = "en",
    ) -> None:
        """Prepare.

        Args:
            pages: each is made when its turn comes.
            on_result: called with the number of a page, from 0, and its result before the next page is shown.
            theme: of the pages (`arl_tui.themes`).
            language: of the words that are not the study's own.
        """
        super().__init__(theme=theme, language=language)
        self._pages = list(pages)
        self._on_result = on_result
        self.results: Results = []

    def on_mount(self) -> None:
        """Show the first page."""
        super().on_mount()
        self._show_next()

    def _show_next(self) -> None:
        if len(self.results) == len(self._pages):
            self.exit(self.results)
        else:
            self.push_screen(self._pages[len(self.results)](), self._page_left)

    def _page_left(self, result: object) -> None:
        self._on_result(len(self.results), result)
        self.results.append(result)
        if result is None or result is False:
            self.exit(self.results)
        else:
            self._show_next()
