"""Results of `arl timing` beside the recordings, and what a session's header says of them.

A result speaks for one machine and one kind of terminal connection: a session takes the newest one of its
own.
"""

import hashlib
import platform
from datetime import datetime, timedelta
from pathlib import Path

import msgspec

from arl_tui.timing.result import TimingResult, header_facts, read_timing

FOLDER = "timing"
"""Below the folder of recordings."""
TERMINAL_FACTS = ("connection", "multiplexer", "TERM", "TERM_PROGRAM")
"""What makes a terminal another one."""
NONE = "none for this machine and terminal (`arl timing` makes one)"
_MACHINE_ID = Path("/etc/machine-id")


def machine_code() -> str:
    """Return twelve hex digits that differ from machine to machine, and tell nothing of it."""
    try:
        identity = _MACHINE_ID.read_text(encoding="ascii").strip()
    except (OSError, UnicodeDecodeError):
        identity = ""
    return hashlib.sha256(f"arl {identity or platform.node()}".encode()).hexdigest()[:12]


def this_terminal(facts: dict[str, str]) -> dict[str, str]:
    """Return what is compared of `arl_tui.app.facts.terminal`."""
    return {name: facts[name] for name in TERMINAL_FACTS if name in facts}


def keep_timing(recordings: Path, result: TimingResult) -> Path:
    """Write a result into the folder of recordings; return where. No file is overwritten."""
    folder = recordings / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    stamp = result.created_utc.replace("+00:00", "Z").replace("-", "").replace(":", "")
    path, number = folder / f"{stamp}.json", 2
    while path.exists():
        path, number = folder / f"{stamp}-{number}.json", number + 1
    with path.open("xb") as file:
        file.write(msgspec.json.format(msgspec.json.encode(result), indent=1) + b"\n")
    return path


def timing_facts(recordings: Path, terminal: dict[str, str], now_utc: str) -> dict[str, str]:
    """Return what a session's header says: the newest result of this machine and terminal, its age, or that
    there is none.

    Args:
        recordings: folder of recordings.
        terminal: facts about the session's terminal, from `arl_tui.app.facts.terminal`.
        now_utc: ISO 8601.
    """
    machine, wanted = machine_code(), this_terminal(terminal)
    unreadable: list[str] = []
    results: list[tuple[str, str, TimingResult]] = []
    for path in sorted((recordings / FOLDER).glob("*.json")):
        try:
            result = read_timing(path)
        except (ValueError, OSError):
            unreadable.append(path.name)
            continue
        if result.machine == machine and this_terminal(result.terminal) == wanted:
            results.append((result.created_utc, path.name, result))
    facts = {"timing": NONE}
    if results:
        _, name, newest = max(results, key=lambda each: each[:2])
        age = datetime.fromisoformat(now_utc) - datetime.fromisoformat(newest.created_utc)
        facts = {"timing": name, "timing_age_h": f"{age / timedelta(hours=1):.1f}"} | header_facts(newest)
    if unreadable:
        facts["timing_unreadable"] = " ".join(unreadable)
    return facts
