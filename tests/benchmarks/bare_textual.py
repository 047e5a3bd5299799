"""The least program that Textual can show: what every screen costs before anything is on it."""

from textual.app import App, ComposeResult
from textual.widgets import Static

SEEN = "nothing else"


class Bare(App[None]):
    """One line."""

    def compose(self) -> ComposeResult:
        yield Static(SEEN)


if __name__ == "__main__":
    Bare().run()
