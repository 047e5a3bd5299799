"""What a live session leaves behind, and what its screens ask of the app. The app imports the screens, they
this.
"""

from abc import abstractmethod
from dataclasses import dataclass
from pathlib import Path

from arl_tui.app.plain_app import PlainApp
from arl_tui.app.tally import Tally
from core.events import StopReason
from core.recording.recorder import Kept


@dataclass(frozen=True, slots=True)
class SessionOutcome:
    """What is left when the app has closed."""

    recording: Path | None
    """None where the session was never started."""
    tally: Tally
    trouble: str | None = None
    """Why the session ended early, if something failed."""
    kept: Kept | None = None
    """How much of the session is in the file, and how much of that the disk has confirmed."""
    warning: str = ""
    """What the experimenter is told of the pace, if presses often miss their step."""
    stopped: StopReason | None = None
    """Why the session was asked to end before its last game; None where it was not."""


class SessionControls(PlainApp[SessionOutcome]):
    """The app of a session as its screens see it."""

    @abstractmethod
    def begin(self) -> None:
        """Start the session: the participant has pressed the start key."""

    @abstractmethod
    def leave(self) -> None:
        """Close without having started."""

    @abstractmethod
    def ask_to_stop(self, reason: StopReason = "participant", patience_s: float | None = None) -> None:
        """End the session; see `arl_tui.session_app.ArlApp.ask_to_stop`."""
