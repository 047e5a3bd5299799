"""The app of `arl watch FILE.jsonl`."""

from pathlib import Path
from typing import ClassVar

from arl_tui.app.driver import own_driver
from arl_tui.app.with_palette import PaletteApp
from arl_tui.viewer.screen import ViewerScreen
from core.recording.undo import RecordingError


class ViewerApp(PaletteApp[str]):
    """One recording; the app's result is a line about where it was left."""

    CSS_PATH: ClassVar = ["../app.tcss", "app.tcss"]
    TITLE = "arl watch"

    def __init__(self, view: ViewerScreen, *, saved_in: Path | None = None) -> None:
        """Prepare; pictures are saved in a folder, the present one by default."""
        super().__init__(driver_class=mouse_driver())
        self.view = view
        self.saved_in = saved_in or Path.cwd()

    def on_mount(self) -> None:
        """Open the recording, and close with it."""
        super().on_mount()
        self.push_screen(self.view, callback=self.exit)

    def _handle_exception(self, error: Exception) -> None:
        # Textual's only place for what a message handler raised. A recording that is removed or changed while
        # it is looked at, or a full disk, is no fault of the program: the command says it in a sentence.
        if isinstance(error, OSError | RecordingError):
            self.view.broken = self.view.broken or error
            self.exit("")
        else:
            super()._handle_exception(error)


def mouse_driver() -> type | None:
    """Return the driver of all apps, which here asks for the mouse; None where Textual's own choice must
    stand.
    """
    if own_driver() is None:
        return None
    from arl_tui.app.steady_driver import SteadyDriver

    class MouseDriver(SteadyDriver):
        """The driver of all apps, with the mouse."""

        def __init__(self, *args: object, **kwargs: object) -> None:
            super().__init__(*args, **kwargs)  # type: ignore[arg-type]
            self._mouse = True

    return MouseDriver
