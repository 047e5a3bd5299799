"""How messages about a configuration write its places, names and values."""

import difflib
import json
from collections.abc import Mapping, Sequence

from core.system import foreign_text

Path = tuple[str | int, ...]
"""Of a setting: keys, and numbers in lists of tables from 0."""
LONGEST_SHOWN = 60
"""A value is cut after so many characters in a message."""


def nearest(word: str, known: Sequence[str]) -> str | None:
    """Return the known word that is most like `word`; None where none is much like it."""
    found = difflib.get_close_matches(word.lower(), known, n=1, cutoff=0.6)
    return found[0] if found else None


def shown_path(path: Path) -> str:
    """Return a place as it is written in a file: "[agent.scheme] beta_0"; "name" at the top."""
    if not path:
        return ""
    table, key = path[:-1], path[-1]
    if isinstance(key, int):
        return f"[[{shown_key(table)}]] number {key + 1}"
    return f"[{shown_key(table)}] {printable(key)}" if table else printable(key)


def shown_key(path: Path) -> str:
    """Return a table's name; of a list of tables with the number, from 1."""
    return ".".join(f"{part + 1}" if isinstance(part, int) else printable(part) for part in path)


def shown(value: object) -> str:
    """Return a value as it is written in a file, cut where it is long, safe for a terminal."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        text = printable(json.dumps(value[: LONGEST_SHOWN + 1], ensure_ascii=False))
    elif isinstance(value, Mapping):
        return "(a table)"
    elif isinstance(value, list | tuple):
        text = "[" + ", ".join(shown(item) for item in value[:10]) + (", ...]" if len(value) > 10 else "]")
    else:
        text = repr(value) if isinstance(value, int | float) else str(value)
    return text if len(text) <= LONGEST_SHOWN else text[:LONGEST_SHOWN] + "..."


def printable(text: str) -> str:
    """Return a text without anything that a terminal could take for a command."""
    return foreign_text.printable(text, longest=None)


def quoted(names: Sequence[str]) -> str:
    """Return names in quotation marks."""
    return ", ".join(f'"{name}"' for name in names)
