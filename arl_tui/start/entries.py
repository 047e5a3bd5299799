"""What can be chosen on the home page, and which command it is. No screen."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from arl_tui.language import later
from arl_tui.recordings import ENDINGS

Arguments = tuple[str, ...]
"""Of the command `arl`, such as ("play", "tetris")."""
MOST_LISTED = 200
"""Newest recordings that are listed: more than one looks through by hand."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One thing to choose."""

    title: str
    """In English, marked with `later`, or the name of a file."""
    what: str
    """What it is, in English and marked, or ""."""
    arguments: Arguments
    """The command, or what of it is known before more is asked for."""
    asks: str = ""
    """What is asked for next: "game", "code", "study", "session", "step", or nothing."""


HOME = (
    Entry(later("Take part"), later("watch an agent learn, and judge it by key presses"), ("play",), "game"),
    Entry(
        later("Calibrate"),
        later("measure how fast a participant reacts and judges"),
        ("calibrate",),
        "calibrate",
    ),
    Entry(later("Studies"), later("lead a participant through a study, or follow one"), ("study",), "study"),
    Entry(later("Recordings"), later("list what is recorded, and check it"), ("recordings",)),
    Entry(later("Look at a session"), later("see a recording again, step by step"), ("watch",), "session"),
    Entry(later("Practice"), later("play the game yourself, with the agent's moves"), ("practice",)),
    Entry(later("Demonstration"), later("the whole path in a minute"), ("demo",)),
    Entry(later("Doctor"), later("check this machine and terminal: go or no go"), ("doctor",)),
)
GAMES = (
    Entry("Tetris", later("falling pieces"), ("play", "tetris"), "code"),
    Entry("Keepaway", later("keepers pass a ball among themselves"), ("play", "keepaway"), "code"),
)


def study_steps(file: Path) -> tuple[Entry, ...]:
    """Return what can be done with a study."""
    name = str(file)
    return (
        Entry(later("Run"), later("lead a participant through their next sitting"), ("study", "run", name)),
        Entry(
            later("Status"),
            later("follow running sittings, write notes"),
            ("study", "status", name, "--watch"),
        ),
        Entry(
            later("Check"), later("what it asks of participants, what is missing"), ("study", "check", name)
        ),
        Entry(
            later("Simulate"),
            later("send simulated participants through all pages"),
            ("study", "simulate", name),
        ),
    )


def studies_in(folder: Path) -> tuple[Entry, ...]:
    """Return the study files in a folder and in those directly below it."""
    files = sorted({*folder.glob("study.toml"), *folder.glob("*/study.toml")})
    found = [Entry(str(file), "", ("study",), "step") for file in files]
    new = Entry(
        later("A new one"), later("copy the ready demonstration to a folder"), ("study", "new", "my-study")
    )
    return (*found, new)


def sessions_in(folder: Path) -> tuple[Entry, ...]:
    """Return the newest recordings in a folder, the newest first."""
    files = [path for path in folder.glob("*") if path.name.endswith(ENDINGS) and path.is_file()]
    files.sort(key=lambda path: path.stat().st_mtime_ns, reverse=True)
    return tuple(Entry(path.name, "", ("watch", str(path))) for path in files[:MOST_LISTED])


def command_line(arguments: Sequence[str]) -> str:
    """Return how a command is typed."""
    return shlex.join(("arl", *arguments))
