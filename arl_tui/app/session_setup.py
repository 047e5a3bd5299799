"""What a live session is started with."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from core.session.protocol import Protocol

if TYPE_CHECKING:
    from core.recording.joined import FinishedPart


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionSetup:
    """Who plays what, and where it is recorded."""

    protocol: Protocol
    root_seed: int
    participant: str
    """Pseudonym; never a name."""
    recordings: Path
    simulated: bool = False
    """A simulated participant presses keys, too."""
    source: Mapping[str, str] = field(default_factory=dict)
    """Where the credit rule comes from, for the recording's header."""
    study: Mapping[str, str] = field(default_factory=dict)
    """Where the session belongs in a study, for the recording's header; empty outside of studies."""
    kept: "FinishedPart | None" = None
    """What the session had done before it broke off; None where it begins."""
    practice: bool = False
    """Nothing counts; it ends after the game in which both keys have been pressed in time."""
    part: str = ""
    """Where in a visit the session is, in words ("Block 2 of 3"); empty where it is all there is."""
