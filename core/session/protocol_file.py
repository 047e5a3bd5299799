"""A protocol file as text: its encoding, its syntax, and the lines that messages name."""

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from core.configuration.messages import printable
from core.configuration.reading import Problem
from core.configuration.toml_places import line_of, places

LARGEST_BYTES = 1_000_000
"""A complete protocol has 4,000."""
LONGEST_QUOTED = 60
"""Characters of a line that a message repeats."""
HELP = "`arl protocol` prints every setting with its range."


class ProtocolError(ValueError):
    """A protocol file cannot be used; the message names file, line, place and reason."""


def read_toml(path: Path, *, what: str = "a protocol", advice: str = HELP) -> tuple[str, dict[str, Any]]:
    """Return the text of a TOML file and what it says.

    Args:
        path: of the file.
        what: the file is to be, for messages.
        advice: where to read about its keys.

    Raises:
        ProtocolError: the file is not UTF-8, not TOML, or too large.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        content = file.read(LARGEST_BYTES + 1)
    name = printable(str(path))
    if len(content) > LARGEST_BYTES:
        raise ProtocolError(f"{name}: {what} has at most {LARGEST_BYTES} bytes, this file has more")
    text = _decoded(name, content)
    try:
        return text, tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason, _, place = str(error).partition(" (at line ")
        number = re.match(r"\d+", place)
        line = f"{number[0]}: " if number else " "
        there = text.split("\n")[int(number[0]) - 1].strip()[:LONGEST_QUOTED] if number else ""
        found = f", in the line {printable(there)!r}" if there else ""
        raise ProtocolError(f"{name}:{line}not a TOML file: {printable(reason)}{found}. {advice}") from error
    except RecursionError as error:
        raise ProtocolError(f"{name}: not {what}: lists or tables lie too deep in each other") from error


def _decoded(name: str, content: bytes) -> str:
    """Return the text of UTF-8 bytes, without a byte-order mark."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        found = "it is UTF-16"
    else:
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            byte = f"0x{content[error.start]:02x}"
            found = f"the byte {byte} in line {line} is none of it, as in Latin-1 or Windows-1252"
    raise ProtocolError(
        f"{name}: not a UTF-8 text: {found}. Save it as UTF-8 in your editor, or write a new file with "
        "`iconv -f LATIN1 -t UTF-8 OLD > NEW` (for UTF-16: -f UTF-16)"
    )


def located(path: Path, text: str, problems: Sequence[Problem], *, advice: str = HELP) -> str:
    """Return the problems with file and line, one a line, and where to read about the settings.

    Args:
        path: of the file.
        text: of the file.
        problems: what is wrong with it.
        advice: last line; where to read about the settings.
    """
    found = places(text)
    name = printable(str(path))
    lines = []
    for problem in sorted(problems, key=lambda each: line_of(each.path, found) or 0):
        line = line_of(problem.path, found)
        lines.append(f"{name}:{line}: {problem}" if line else f"{name}: {problem}")
    return "\n".join([*lines, *([advice] if advice else [])])
