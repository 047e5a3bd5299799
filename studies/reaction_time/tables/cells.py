r"""The cells of a delimited table, however it was exported: by a statistics package, a spreadsheet, or `cat`.

Line numbers are those of the file. Lines end with \n, \r\n or \r; other characters that Unicode calls
separators (U+2028, U+0085, form feeds) are part of a cell.
"""

import csv
import io
import itertools
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from studies.reaction_time.tables.contract import ReadError, shown

Line = tuple[int, list[str]]
"""Number of the line in the file (of the first one, where a row has several) and its cells."""
_PREAMBLE = 30
"""A header stands within so many rows."""
_SAMPLE = 200
MOST_CELLS = 10_000_000
"""Cells of one table, each row counting for three more: below 1 GB of memory."""
_MEMO = 50_000
"""Different cells of which one copy is kept: codes, conditions and answers come again and again."""


@dataclass(frozen=True, slots=True)
class Table:
    """A header and rows, each with as many cells as the header."""

    path: Path
    header: list[str]
    """Names, stripped; a column without a name is called "(column N)", N from 1."""
    lines: list[Line]
    left_out: Counter[str] = field(default_factory=Counter)
    """Reason to the number of rows that hold no trial: headers that come again, a row cut off in writing."""
    notes: list[str] = field(default_factory=list)

    def getter(self, name: str) -> Callable[[Sequence[str]], str]:
        """Return a function from a row to this column's cell, stripped; to "" without such a column."""
        if name not in self.header:
            return lambda _cells: ""
        at = self.header.index(name)
        return lambda cells: cells[at].strip()

    def values(self, name: str) -> Counter[str]:
        """Return the column's different values, stripped, and how often each stands there."""
        get = self.getter(name)
        return Counter(get(cells) for _, cells in self.lines)


def parse(path: Path, text: str, *, skip: int = 0) -> Table:
    """Return the table that a text holds.

    Args:
        path: for messages.
        text: the whole file.
        skip: lines before the table that are known not to belong to it.

    Raises:
        ReadError: no header, two columns of one name with different cells, a row with another number of
            cells, or quotation marks that never close; with the line.
    """
    text, delimiter = _separator_line(text)
    delimiter = delimiter or _delimiter(text)
    rows = _rows(path, text, delimiter)[skip:]
    if not rows:
        raise ReadError(f"{path}: empty; expected a header line with column names")
    at = _header_at(rows)
    notes = []
    if at:
        before = "; ".join(shown(" ".join(cell for cell in cells if cell)) for _, cells in rows[:at][:2])
        notes.append(f"{_count(at, 'line')} before the header (line {rows[at][0]}): {before}")
    header = [name.strip().lstrip("\ufeff") for name in rows[at][1]]
    header = [name or f"(column {number})" for number, name in enumerate(header, start=1)]
    table = Table(path, header, rows[at + 1 :], notes=notes)
    whole = text.endswith(("\n", "\r"))
    return _without_doubles(_checked(table, whole=whole, delimiter=delimiter))


def _count(n: int, word: str) -> str:
    return f"{n} {word}{'' if n == 1 else 's'}"


def _separator_line(text: str) -> tuple[str, str | None]:
    """Take Excel's first line `sep=;` for what it is; its line still counts."""
    found = re.match(r'"?sep=(.)"?[ \t]*(\r\n|\n|\r)', text, re.IGNORECASE)
    return (found[2] + text[found.end() :], found[1]) if found else (text, None)


def _delimiter(text: str) -> str:
    """Return what separates cells: in the first line, or below it if a title stands there."""
    lines = list(itertools.islice(io.StringIO(text[:100_000], newline=""), _PREAMBLE))
    at = next((at for at, line in enumerate(lines) if any(sign in line for sign in "\t;,")), None)
    if at is None:
        return ","
    first = max("\t;,", key=lines[at].count)  # ties go to the tab, then the semicolon
    below = lines[at + 1 : -1] or lines[at + 1 :]
    usual = {
        sign: Counter(line.count(sign) for line in below).most_common(1)[0][0] for sign in "\t;," if below
    }
    if below and not usual[first]:
        return max("\t;,", key=lambda sign: usual[sign]) if any(usual.values()) else first
    return first


def _rows(path: Path, text: str, delimiter: str) -> list[Line]:
    reader = csv.reader(
        io.StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=delimiter != "\t"
    )
    rows: list[Line] = []
    begin, last, size = 1, 1, 0
    memo: dict[str, str] = {}
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                known = memo.get if len(memo) >= _MEMO else memo.setdefault
                rows.append((begin, [known(cell, cell) for cell in cells]))
                size += len(cells) + 3
                if size > MOST_CELLS:
                    raise ReadError(
                        f"{path}:{begin}: more than {MOST_CELLS / 1e6:g} million cells up to this line; write"
                        " the columns that are needed to a smaller table, or split it by participants"
                        " (several files may be named)"
                    )
            last, begin = begin, reader.line_num + 1
    except csv.Error as error:
        raise ReadError(
            f"{path}:{begin}: {error}. Is a quotation mark opened in this line and never closed?"
        ) from error
    if rows and rows[-1][0] == last and reader.line_num > last and _never_closed(text, last):
        raise ReadError(
            f"{path}:{last}: a quotation mark is opened in this line and never closed: all of the file behind"
            " it would be one cell. Close it, or was the file cut off?"
        )
    return rows


def _never_closed(text: str, line: int) -> bool:
    lines = itertools.islice(io.StringIO(text, newline=""), line - 1, None)
    return sum(part.count('"') for part in lines) % 2 == 1


def _header_at(rows: Sequence[Line]) -> int:
    """Return which row is the header: the first, unless most rows are as wide as a later one."""
    widths = [_width(cells) for _, cells in rows[: _SAMPLE + _PREAMBLE]]
    usual, n = Counter(widths[1:] or widths).most_common(1)[0]
    if (abs(widths[0] - usual) <= 1 and widths[0] > 1) or n < 3 or n < 0.6 * len(widths[1:]):
        return 0
    for at, (_, cells) in enumerate(rows[:_PREAMBLE]):
        if widths[at] == usual:
            words = [cell.strip() for cell in cells[: widths[at]]]
            return at if not any(_is_number(word) for word in words) else 0
    return 0


def _width(cells: Sequence[str]) -> int:
    return max((at for at, cell in enumerate(cells, start=1) if cell.strip()), default=0)


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _checked(table: Table, *, whole: bool, delimiter: str) -> Table:
    """Return the table without headers that come again and without a last row that was cut off."""
    n = len(table.header)
    header = [name for name in table.header if not name.startswith("(column ")]
    lines: list[Line] = []
    again: list[int] = []
    notes = list(table.notes)
    left_out = Counter(table.left_out)
    for at, (number, cells) in enumerate(table.lines):
        names = [name for cell in cells if (name := cell.strip().lstrip("\ufeff"))]
        if len(names) > 1 and len(names) == len(header) and set(names) == set(header):
            if names != header:
                raise ReadError(
                    f"{table.path}:{number}: the header comes again with its columns in another order: these"
                    " are joined files of different layout. Give the files one by one"
                )
            again.append(number)
            continue
        cells = cells[:n] if not any(cells[n:]) else cells
        if len(cells) < n and at == len(table.lines) - 1 and not whole:
            left_out["cut off in writing"] += 1
            notes.append(
                f"the last line ({number}) was cut off in writing: {shown(delimiter.join(cells))} is left out"
            )
            continue
        if len(cells) != n:
            raise ReadError(
                f"{table.path}:{number}: {len(cells)} cells in a row, {n} columns in the header; it begins "
                f"{shown(delimiter.join(cells))}. Is a separator inside a cell without quotation marks?"
            )
        lines.append((number, cells))
    if again:
        left_out["the header again"] += len(again)
        where = ", ".join(map(str, again[:3])) + (", ..." if len(again) > 3 else "")
        notes.append(f"the header comes again in line {where}: joined files, read as one table")
    return Table(table.path, table.header, lines, left_out, notes)


def _without_doubles(table: Table) -> Table:
    """Return the table without columns that are there twice with the same cells."""
    doubles = [name for name, n in Counter(table.header).items() if n > 1]
    keep = list(range(len(table.header)))
    for name in doubles:
        at = [i for i, other in enumerate(table.header) if other == name]
        if any(cells[i] != cells[at[0]] for _, cells in table.lines for i in at[1:]) or not table.lines:
            raise ReadError(
                f"{table.path}: two columns have the same name, {shown(name)} (columns {at[0] + 1} and"
                f" {at[1] + 1}), and different cells; rename one"
            )
        keep = [i for i in keep if i not in at[1:]]
        table.notes.append(
            f"the column {shown(name)} is there {len(at)} times with the same cells: taken once"
        )
    if not doubles:
        return table
    lines = [(number, [cells[i] for i in keep]) for number, cells in table.lines]
    return Table(table.path, [table.header[i] for i in keep], lines, table.left_out, table.notes)
