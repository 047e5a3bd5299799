"""Gorilla's data files: long format, a row per event, times in milliseconds, `END OF FILE` in the last row.

Task Builder 2 says what a row is in `Response Type`: response, timed out, too early, continue, action, info.
Task Builder 1 says it in `Zone Type` (response_keyboard, response_button_text, ...), with `Timed Out` and
`Attempt`.
"""

from collections.abc import Callable, Sequence

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import Columns, ReadError, shown
from studies.reaction_time.tables.numbers import is_missing, number_of
from studies.reaction_time.tables.plan import (
    Plan,
    Source,
    Trial,
    TrialOutcome,
    is_practice,
    is_right,
    participant_column,
    rt_column,
    scores,
)

_MARKS = ("Participant Private ID", "Event Index", "Tree Node Key", "UTC Timestamp")
_END = "END OF FILE"


class Gorilla:
    """See the module."""

    name = "gorilla"
    title = "Gorilla"

    def marks(self, source: Source) -> str | None:
        """Return the columns that only Gorilla writes."""
        found = [name for name in _MARKS if name in source.header]
        times = "Reaction Time" in source.header
        return ", ".join(map(shown, found)) if len(found) >= 2 and times else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take responses, time-outs and early responses of the one component that recorded responses."""
        table, columns = source.table, source.columns
        rt = rt_column(table, columns, {"Reaction Time": len(table.lines)}, self.title)
        types = {value.lower() for value in table.values("Response Type")}
        second = bool(types & {"response", "timed out", "too early"})
        if not second and "Zone Type" not in table.header:
            raise ReadError(
                f"{table.path}: Gorilla's file has neither a 'Response Type' with responses nor a 'Zone"
                " Type': was it edited, or is it a questionnaire's? Read it as a table: --from table"
                " --column rt=NAME --unit ms"
            )
        scored, notes = scores(_responses(table, second=second), "Correct")
        if not columns.keep:
            _refuse_several(_responses(table, second=second))
        kind = _second_builder if second else _first_builder
        return Plan(
            table=table,
            recognised=f"Gorilla, Task Builder {2 if second else 1}, by {marks}",
            rt=rt,
            unit=columns.unit or "ms",
            participant=participant_column(
                table, columns, ("Participant Private ID", "Participant Public ID")
            ),
            judge=_judge(table, rt, kind(table), scored=scored, columns=columns),
            notes=notes,
        )


def _judge(
    table: Table,
    rt: str,
    kind: Callable[[Sequence[str]], TrialOutcome | str],
    *,
    scored: bool,
    columns: Columns,
) -> Callable[[Sequence[str]], Trial | str]:
    time, right = table.getter(rt), table.getter("Correct")
    first = table.header[0]
    begin = table.getter(first)
    blocks = [table.getter(name) for name in table.header if name.split(": ")[-1].lower() == "display"]

    def judge(cells: Sequence[str]) -> Trial | str:
        if begin(cells) == _END:
            return "Gorilla's END OF FILE"
        found = kind(cells)
        practice = any(is_practice(get(cells)) for get in blocks)
        if found == "no response":
            waited = number_of(time(cells), f"{table.path}: column {shown(rt)}", columns)
            waited_s = waited / 1000.0 if waited else None
            return Trial(rt="", outcome="no response", practice=practice, waited_s=waited_s)
        if found == "response" and is_missing(time(cells)):
            return "responses without a time"
        if found == "response" and scored and is_right(right(cells)) is False:
            return Trial(rt=time(cells), outcome="wrong", practice=practice)
        if found in ("response", "too early"):
            return Trial(
                rt=time(cells), outcome="too early" if found == "too early" else "response", practice=practice
            )
        return found

    return judge


def _second_builder(table: Table) -> Callable[[Sequence[str]], TrialOutcome | str]:
    kind = table.getter("Response Type")
    known: dict[str, TrialOutcome] = {
        "response": "response",
        "timed out": "no response",
        "too early": "too early",
    }

    def judge(cells: Sequence[str]) -> TrialOutcome | str:
        text = kind(cells).lower()
        return known.get(text) or f"Response Type {shown(kind(cells))}"

    return judge


def _first_builder(table: Table) -> Callable[[Sequence[str]], TrialOutcome | str]:
    zone, late, attempt = (table.getter(name) for name in ("Zone Type", "Timed Out", "Attempt"))

    def judge(cells: Sequence[str]) -> TrialOutcome | str:
        kind = zone(cells).lower()
        if is_right(late(cells)):
            return "no response"
        if not kind.startswith("response"):
            return f"Zone Type {shown(zone(cells))}"
        if attempt(cells) not in ("", "1", "1.0"):
            return "later attempts at the same trial"
        return "response"

    return judge


def _responses(table: Table, *, second: bool) -> Table:
    """Return the table of the rows that are responses."""
    kind = table.getter("Response Type" if second else "Zone Type")
    lines = [(n, cells) for n, cells in table.lines if kind(cells).lower().startswith("response")]
    return Table(table.path, table.header, lines)


def _refuse_several(responses: Table) -> None:
    """Raise ReadError where different components (a keyboard and a slider) recorded responses."""
    for name in ("Component Name", "Zone Type", "Screen"):
        found = responses.values(name)
        if len(found) > 1:
            words = ", ".join(f"{shown(value)} ({n})" for value, n in found.most_common(5))
            raise ReadError(
                f"{responses.path}: responses stand in several values of {shown(name)}: {words}. Which are"
                f" the reactions? --keep '{name}=VALUE'"
            )
