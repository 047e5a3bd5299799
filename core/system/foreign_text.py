"""Text that came from a file, made safe to show: on a terminal, on a page, in a plot, in an error message.

A terminal obeys escape sequences wherever they come from: a participant code in another person's table can
clear the screen or set the window's title. Bidirectional overrides change the order in which a line is read.
Every text that this program did not write itself goes through `printable` or `printable_lines` before a
person sees it.
"""

import unicodedata
from collections.abc import Mapping
from html import escape

LONGEST = 200
"""Characters of one foreign text that are shown; more of them hide what matters."""
LONGEST_LINE = 4000
"""Characters of one line of a message that are shown."""

_UNSAFE = frozenset({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})
"""Unicode categories that are written as escapes: controls, format characters (all bidirectional controls are
among them), surrogates, private and unassigned code points, line and paragraph separators."""
_HARMLESS = frozenset("\u00ad\u200c\u200d")
"""Format characters that scripts and emoji need; they neither move the cursor nor reorder text."""


def printable(text: str, *, longest: int | None = LONGEST) -> str:
    r"""Return a text in one line, with escapes such as `\x1b` for what would move the cursor or reorder it.

    Args:
        text: any text, whatever it holds.
        longest: characters that are kept; the rest is replaced by `...` and how many there were. None keeps
            all.

    Returns:
        Text without any character that a terminal obeys. A text of plain characters is returned as it is.
    """
    shown = text if longest is None else text[:longest]
    if not (shown.isascii() and shown.isprintable()):
        shown = "".join(_one(sign) for sign in shown)
    if longest is not None and len(text) > longest:
        return f"{shown}... ({len(text):,} characters)"
    return shown


def printable_lines(text: str, *, longest: int | None = LONGEST_LINE) -> str:
    """Return a text of several lines with each line made `printable`; only line feeds stay."""
    return "\n".join(printable(line, longest=longest) for line in text.split("\n"))


def in_table(row: Mapping[str, object]) -> dict[str, object]:
    """Return a row of a table for a file, which a terminal may show, too: its texts made `printable`."""
    return {
        name: printable(cell, longest=None) if isinstance(cell, str) else cell for name, cell in row.items()
    }


def in_html(text: str) -> str:
    """Return a text as it may stand in a page of HTML: `printable`, and without anything that a browser
    obeys.
    """
    return escape(printable(text, longest=None))


def in_plot(text: str) -> str:
    r"""Return a text as it may stand in a figure: `printable`, and with `\$` where matplotlib would set
    formulas.
    """
    return printable(text).replace("$", r"\$")


def printable_json(text: str) -> str:
    """Return JSON text that says the same, with JSON's own escapes for all that a terminal obeys."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "".join(sign if sign == "\n" or sign.isprintable() else _in_json(sign) for sign in text)


def _in_json(sign: str) -> str:
    wide = sign.encode("utf-16-be", "surrogatepass")
    return "".join(f"\\u{wide[n]:02x}{wide[n + 1]:02x}" for n in range(0, len(wide), 2))


def _one(sign: str) -> str:
    if sign in _HARMLESS or unicodedata.category(sign) not in _UNSAFE:
        return sign
    number = ord(sign)
    if number <= 0xFF:
        return f"\\x{number:02x}"
    return f"\\u{number:04x}" if number <= 0xFFFF else f"\\U{number:08x}"
