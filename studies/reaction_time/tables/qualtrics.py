"""Qualtrics' timing questions: a row per person, four columns per question, seconds.

A timing question Q1 writes `Q1_First Click`, `Q1_Last Click`, `Q1_Page Submit` and `Q1_Click Count`. The
second row holds the questions' texts and the third import identifiers. A page without a click has First Click
0.
"""

import re
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from studies.reaction_time.tables.cells import Line, Table
from studies.reaction_time.tables.contract import Columns, ReadError, shown
from studies.reaction_time.tables.numbers import is_missing
from studies.reaction_time.tables.plan import Plan, Source, Trial, participant_column

KINDS = ("First Click", "Last Click", "Page Submit")
_ENDING = re.compile(rf"(?P<question>.*?)[_ -](?P<kind>{'|'.join(KINDS)})(?P<loop>[._]?\d*)$")
_OWN = (
    "ResponseId",
    "ResponseID",
    "StartDate",
    "RecordedDate",
    "DistributionChannel",
    "Progress",
    "Finished",
)
_PEOPLE = ("ResponseId", "ResponseID", "Response ID")


class Qualtrics:
    """See the module."""

    name = "qualtrics"
    title = "Qualtrics"

    def marks(self, source: Source) -> str | None:
        """Return the columns that only Qualtrics writes."""
        found = [name for name in _OWN if name in source.header]
        kinds = [name for name in source.header if _ENDING.match(name)]
        return ", ".join(map(shown, [*found[:2], kinds[0]])) if found and kinds else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take each person's time at each timing question."""
        columns = source.columns
        kind, names = _questions(source.table, columns)
        table = _long(source.table, names, columns)
        return Plan(
            table=table,
            recognised=f"Qualtrics, by {marks}",
            rt="time",
            unit=columns.unit or "s",
            participant=participant_column(table, columns, _PEOPLE),
            judge=_judge(table, kind),
            notes=(
                (
                    f"the times are {shown(kind)} of {len(names)} timing questions; --column rt='Page Submit'"
                    " or 'Last Click' takes another of their times, --column rt=NAME one column alone"
                ),
            ),
        )


def _questions(table: Table, columns: Columns) -> tuple[str, list[str]]:
    """Return which time of the questions counts, and the columns that hold it."""
    if columns.rt in table.header:
        found = _ENDING.match(columns.rt)
        return (found["kind"] if found else columns.rt), [columns.rt]
    kind = columns.rt or KINDS[0]
    names = [name for name in table.header if (found := _ENDING.match(name)) and found["kind"] == kind]
    if not names:
        raise ReadError(
            f"{table.path}: no timing question has a column {shown(kind)}; --column rt= one of "
            f"{', '.join(KINDS)}"
        )
    return kind, names


def _long(table: Table, names: Sequence[str], columns: Columns) -> Table:
    """Return a row for each person and question."""
    others = [
        name
        for name in table.header
        if not _ENDING.match(name)
        and (name in (*_OWN, "Status", *columns.keep, *columns.by, columns.participant))
    ]
    left_out = Counter(table.left_out)
    lines: list[Line] = []
    gets = [table.getter(name) for name in others]
    times = [(name, table.getter(name)) for name in names]
    for at, (number, cells) in enumerate(table.lines):
        if at < 2 and _is_header(table.path, number, cells, table):
            left_out["Qualtrics' further header rows"] += 1
            continue
        for name, time in times:
            question = _ENDING.match(name)
            label = question["question"] + question["loop"] if question else name
            lines.append((number, [*(get(cells) for get in gets), label, time(cells)]))
    return Table(table.path, [*others, "question", "time"], lines, left_out, list(table.notes))


def _is_header(path: Path, number: int, cells: Sequence[str], table: Table) -> bool:
    """Return whether a row is the one of texts or the one of import identifiers."""
    if any('"ImportId"' in cell for cell in cells):
        return True
    dates = [
        table.getter(name)(cells) for name in ("StartDate", "RecordedDate", "EndDate") if name in table.header
    ]
    if dates:
        return not any(re.search(r"\d", text) for text in dates)
    finished = [table.getter(name)(cells) for name in ("Finished", "Progress") if name in table.header]
    return any(text.lower() in ("finished", "progress") for text in finished)


def _judge(table: Table, kind: str) -> Callable[[Sequence[str]], Trial | str]:
    time, status, channel = (table.getter(name) for name in ("time", "Status", "DistributionChannel"))

    def judge(cells: Sequence[str]) -> Trial | str:
        if status(cells).lower() in ("survey preview", "spam", "8") or channel(cells).lower() == "preview":
            return "previews and spam (Status)"
        if status(cells) == "1" and channel(cells) == "":
            return "previews and spam (Status)"
        if is_missing(time(cells)):
            return "questions that were not shown"
        if time(cells) in ("0", "0.0", "0.000") and kind != "Page Submit":
            return Trial(rt="", outcome="no response")
        return Trial(rt=time(cells))

    return judge
