"""Where the keys of a TOML file stand, for error messages: the standard library's parser does not tell."""

import re

Path = tuple[str | int, ...]
"""Keys from the outermost table to a setting; the tables of a list count from 0."""
_NAME = r"(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')"
_DOTTED = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEADER = re.compile(rf"^\s*(\[\[?)\s*({_DOTTED})\s*\]")
_KEY = re.compile(rf"^\s*({_DOTTED})\s*=\s*(.*)$")
_INLINE = re.compile(rf"[{{,]\s*({_DOTTED})\s*=")
_FENCES = ('"""', "'''")


def places(text: str) -> dict[Path, int]:
    """Return the line, from 1, of every table and key of a TOML file that can be parsed.

    Keys of inline tables stand where the table does.
    """
    found: dict[Path, int] = {}
    table: Path = ()
    counts: dict[Path, int] = {}
    fence = ""
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), 1):
        if fence:
            fence = "" if line.count(fence) % 2 else fence
            continue
        header, key = _HEADER.match(line), _KEY.match(line)
        if header is not None:
            table = _names(header[2])
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            found.setdefault(table, number)
        elif key is not None:
            path = (*table, *_names(key[1]))
            for length in range(len(table) + 1, len(path) + 1):
                found.setdefault(path[:length], number)
            for inner in _INLINE.findall(key[2]) if key[2].startswith(("{", "[")) else ():
                found.setdefault((*path, *_names(inner)), number)
            fence = next((mark for mark in _FENCES if key[2].count(mark) % 2), "")
    return found


def line_of(path: Path, found: dict[Path, int]) -> int | None:
    """Return the line of a setting, or of the nearest table around it; None where the file has neither."""
    for length in range(len(path), 0, -1):
        if path[:length] in found:
            return found[path[:length]]
    return None


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(name.strip().strip("\"'") for name in re.findall(_NAME, dotted))
