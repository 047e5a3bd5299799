"""DMDX's .azk files: one block for each subject, a line per item, milliseconds; a negative time is an error.

A trial without a response is written as minus the time-out. Only the file's own numbers can tell that from a
late
error: a negative time that is the largest of all and comes at least twice is taken for the time-out.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from studies.reaction_time.tables.cells import Line, Table
from studies.reaction_time.tables.contract import Columns, ReadError, shown
from studies.reaction_time.tables.plan import Plan, Source, Trial, participant_column

_HEAD = re.compile(r"^Subjects incorporated to date:?", re.MULTILINE)
_SUBJECT = re.compile(r"^Subject\s+(\d+)\s*,(.*)$")
_ID = re.compile(r"\bID\s+(\S[^,]*)")
_ITEM = re.compile(r"^\s*(\S+)\s+(-?\d+(?:\.\d+)?)(?:\s+(.*))?$")
_TITLES = re.compile(r"^\s*Item\b.*\bRT\b", re.IGNORECASE)
_SAME_MS = 1.0


class Dmdx:
    """See the module."""

    name = "dmdx"
    title = "DMDX"

    def marks(self, source: Source) -> str | None:
        """Return the lines that only DMDX writes."""
        text = source.text.content
        if _HEAD.search(text[:2000]):
            return "'Subjects incorporated to date'"
        return (
            "'Subject N, ... refresh'"
            if re.search(r"^Subject\s+\d+,.*refresh", text[:4000], re.MULTILINE)
            else None
        )

    def plan(self, source: Source, marks: str) -> Plan:
        """Take every item; what was wrong or late is told by the sign."""
        columns = source.columns
        table = _table(source.path, source.text.content)
        times = [float(value) for value in table.values("RT").elements()]
        late_ms, note = _time_out(times, columns)
        return Plan(
            table=table,
            recognised=f"DMDX, by {marks}",
            rt=columns.rt if columns.rt in table.header else "RT",
            unit=columns.unit or "ms",
            participant=participant_column(table, columns, ("Subject",)),
            judge=_judge(table, late_ms),
            notes=(note,) if note else (),
        )


def _judge(table: Table, late_ms: float | None) -> Callable[[Sequence[str]], Trial | str]:
    get = table.getter("RT")

    def judge(cells: Sequence[str]) -> Trial | str:
        time = float(get(cells))
        if late_ms is not None and time < 0 and abs(time) >= late_ms - _SAME_MS:
            return Trial(rt="", outcome="no response", waited_s=late_ms / 1000.0)
        if time < 0:
            return Trial(rt=get(cells).removeprefix("-"), outcome="wrong")
        return Trial(rt=get(cells), outcome="no response" if time == 0 else "response")

    return judge


def _time_out(times: Sequence[float], columns: Columns) -> tuple[float | None, str | None]:
    """Return the time-out in milliseconds, and a note on how it was found."""
    if columns.waited_s is not None:
        return columns.waited_s * 1000.0, None
    negative = [-time for time in times if time < 0]
    if not negative:
        return None, None
    longest = max(negative)
    n = sum(longest - time <= _SAME_MS for time in negative)
    if n < 2 or any(time > longest + _SAME_MS for time in times):
        return (
            None,
            (
                "no time-out can be told from the errors (both are negative): all are taken as wrong answers."
                " State it with --waited SECONDS"
            ),
        )
    return (
        longest,
        (
            f"{n} times are -{longest:g} ms, the longest of all: taken as time-outs of {longest / 1000:g} s."
            " --waited SECONDS states another"
        ),
    )


def _table(path: Path, text: str) -> Table:
    lines: list[Line] = []
    left_out: Counter[str] = Counter()
    notes: list[str] = []
    subject: str | None = None
    began = False
    for number, line in enumerate(re.split(r"\r\n|\n|\r", text), start=1):
        found = _SUBJECT.match(line.strip())
        if found:
            subject, began = _code(found[1], found[2]), False
        elif line.lstrip().startswith("!"):
            left_out["DMDX's messages (!)"] += 1
            if len(notes) < 3:
                notes.append(f"line {number}: {shown(line.strip())}")
        elif _TITLES.match(line):
            began = True
        elif subject is not None and began and line.strip() and not set(line.strip()) <= {"*"}:
            item = _ITEM.match(line)
            if item is None:
                raise ReadError(f"{path}:{number}: expected an item and a time, got {shown(line.strip())}")
            lines.append((number, [subject, item[1], item[2]]))
    if not lines:
        raise ReadError(f"{path}: DMDX's file holds no item with a time")
    return Table(path, ["Subject", "Item", "RT"], lines, left_out, notes)


def _code(number: str, rest: str) -> str:
    """Return the ID that was typed in where there is one, else the subject's number."""
    found = _ID.search(rest)
    return found[1].strip() if found else number
