"""What a recording's header says about this program, this machine and this terminal."""

import os
import platform
import shutil
import subprocess
import time
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from core.plugins import plugins

LIBRARIES = ("numpy", "scipy", "numba", "msgspec", "textual")
"""Numbers or time stamps depend on these."""

REPOSITORY = Path(__file__).resolve().parents[2]


def software() -> dict[str, str]:
    """Return versions: of this program (with its commit, where it runs from a checkout), its games, Python
    and libraries.
    """
    facts = {"arl-tui": _version("arl-tui"), "python": platform.python_version()}
    facts |= {f"{game.name} play": str(game.revision) for game in plugins()}
    facts.update((library, _version(library)) for library in LIBRARIES)
    commit = git_commit(REPOSITORY)
    if commit:
        facts["commit"] = commit
    return facts


def differing(recorded: Mapping[str, str]) -> list[str]:
    """Return what the software of a recording was and is now, in words, where it is not the same."""
    return [
        f"{name} {recorded.get(name, '(not said)')}, now {now}"
        for name, now in software().items()
        if recorded.get(name) != now
    ]


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "not installed"


def git_commit(checkout: Path) -> str | None:
    """Return the checkout's commit, with "+changes" if files differ from it; None where there is no
    checkout.
    """
    if not (checkout / ".git").exists() or shutil.which("git") is None:
        return None
    try:
        described = subprocess.run(
            [
                "git",
                "-C",
                str(checkout),
                "describe",
                "--always",
                "--abbrev=40",
                "--exclude=*",
                "--dirty=+changes",
            ],
            env={**os.environ, "GIT_OPTIONAL_LOCKS": "0"},
            capture_output=True,
            text=True,
            timeout=2.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return described.stdout.strip() or None


def terminal(columns: int, rows: int, *, stamps: str, frames_per_s: int) -> dict[str, str]:
    """Return facts about the terminal that matter to times and colours.

    Args:
        columns: width in cells.
        rows: height in cells.
        stamps: where a frame's time comes from: "flush" or "queued".
        frames_per_s: upper bound of the drawing rate.
    """
    environment = os.environ
    facts = {
        "size": f"{columns}x{rows}",
        "stamps": stamps,
        "frames_per_s": str(frames_per_s),
        "system": f"{platform.system()} {platform.release()}",
        "connection": connection(),
    }
    for name in ("TERM", "TERM_PROGRAM", "COLORTERM", "LANG"):
        if environment.get(name):
            facts[name] = environment[name]
    if environment.get("TMUX") or environment.get("STY"):
        facts["multiplexer"] = "tmux" if environment.get("TMUX") else "screen"
    return facts


def connection() -> str:
    """Return how the participant's keys get here: "local", "ssh" or "web"."""
    if os.environ.get("TEXTUAL_DRIVER"):
        return "web"
    return "ssh" if os.environ.get("SSH_CONNECTION") else "local"


def clock_facts() -> tuple[str, int]:
    """Return the name and the resolution in ns of the clock behind all times."""
    info = time.get_clock_info("monotonic")
    return info.implementation, max(1, round(info.resolution * 1e9))
