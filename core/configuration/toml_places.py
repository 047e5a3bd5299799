"""Where the keys of a TOML file stand, for error messages: the standard library's parser does not tell."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

Path = tuple[str | int, ...]
"""Keys from the outermost table to a setting; the tables of a list count from 0."""
_NAME = r"(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')"
_DOTTED = rf"{_NAME}(?:\s*\.\s*{_NAME})*"
_HEADER = re.compile(rf"^\s*(\[\[?)\s*({_DOTTED})\s*\]")
_KEY = re.compile(rf"^\s*({_DOTTED})\s*=\s*(.*)$")
_TOKEN = re.compile(
    rf"(?P<string>\"\"\".*?\"\"\"|'''.*?'''|\"(?:\\.|[^\"\\\n])*\"(?!\s*=)|'[^'\n]*'(?!\s*=))|(?P<comment>#[^\n]*)"
    rf"|(?P<key>{_DOTTED})\s*=|(?P<mark>[\[\]{{}},\n])",
    re.DOTALL,
)
_FENCES = ('"""', "'''")


def places(text: str) -> dict[Path, int]:
    """Return the line, from 1, of every table and key of a TOML file that can be parsed.

    Inline tables and lists of them are looked into, over several lines, too.
    """
    found: dict[Path, int] = {}
    table: Path = ()
    counts: dict[Path, int] = {}
    fence = ""
    lines = text.replace("\r\n", "\n").split("\n")
    for number, line in enumerate(lines, 1):
        if fence:
            fence = "" if line.count(fence) % 2 else fence
            continue
        header, key = _HEADER.match(line), _KEY.match(line)
        if header is not None:
            table = _within(_names(header[2]), counts)
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            found.setdefault(table, number)
        elif key is not None:
            path = (*table, *_names(key[1]))
            for length in range(len(table) + 1, len(path) + 1):
                found.setdefault(path[:length], number)
            if key[2].startswith(("{", "[")):
                rest = "\n".join(lines[number:])
                for inner, offset in _inside(key[2] + "\n" + rest):
                    found.setdefault((*path, *inner), number + offset)
            fence = next((mark for mark in _FENCES if key[2].count(mark) % 2), "")
    return found


def line_of(path: Path, found: dict[Path, int]) -> int | None:
    """Return the line of a setting, or of the nearest table around it; None where the file has neither."""
    for length in range(len(path), 0, -1):
        if path[:length] in found:
            return found[path[:length]]
    return None


def _within(names: Path, counts: dict[Path, int]) -> Path:
    """Return a header's path with the number of the newest table of each list above it."""
    path: Path = names[:1]
    for name in names[1:]:
        if path in counts:
            path = (*path, counts[path])
        path = (*path, name)
    return path


@dataclass(slots=True)
class _Open:
    """A list or an inline table that has begun and not ended."""

    path: Path
    is_list: bool
    items: int = 0


def _inside(value: str) -> Iterator[tuple[Path, int]]:
    """Yield the places within a list or inline table that `value` begins with, each with how many lines it is
    below.
    """
    opened: list[_Open] = []
    place: Path = ()
    below = 0
    for token in _TOKEN.finditer(value):
        mark, key = token["mark"], token["key"]
        if key and opened and not opened[-1].is_list:
            place = (*opened[-1].path, *_names(key))
            yield place, below
        elif mark in ("[", "{"):
            if mark == "{" and opened:
                yield place, below
            opened.append(_Open(place, mark == "["))
            place = (*place, 0) if mark == "[" else place
        elif mark in ("]", "}"):
            opened.pop()
        elif mark == "," and opened and opened[-1].is_list:
            opened[-1].items += 1
            place = (*opened[-1].path, opened[-1].items)
        if not opened:
            return
        below += token[0].count("\n")


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(name.strip().strip("\"'") for name in re.findall(_NAME, dotted))
