"""OpenSesame's data files: every variable in every row, milliseconds, `NA` where not yet set.

`response_time_ITEM` and `response_ITEM` belong to one response item, `response_time` to whichever came last.
A time-out has the response "None" and, as its time, how long the item waited. Variables keep their values, so
a logger that runs without a new response repeats the old one: `count_ITEM` tells.
"""

from collections.abc import Callable, Sequence

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import Columns, shown
from studies.reaction_time.tables.numbers import is_missing, number_of
from studies.reaction_time.tables.plan import (
    Plan,
    Source,
    Trial,
    is_practice,
    is_right,
    participant_column,
    rt_column,
    scores,
)

_MARKS = ("opensesame_version", "opensesame_codename", "subject_parity", "subject_nr", "experiment_path")
_PREFIX = "response_time_"


class OpenSesame:
    """See the module."""

    name = "opensesame"
    title = "OpenSesame"

    def marks(self, source: Source) -> str | None:
        """Return the columns that only OpenSesame writes."""
        header = source.header
        found = [name for name in _MARKS if name in header]
        times = any(name == "response_time" or name.startswith(_PREFIX) for name in header)
        own = "subject_nr" in found and (len(found) > 1 or any(name.startswith("count_") for name in header))
        return ", ".join(map(shown, found)) if times and (own or "opensesame_version" in found) else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take the rows with a new response of the item that recorded the most."""
        table, columns = source.table, source.columns
        rt = rt_column(table, columns, _candidates(table), self.title)
        ending = rt.removeprefix("response_time")
        correct = f"correct{ending}" if f"correct{ending}" in table.header else "correct"
        scored, notes = scores(table, correct)
        return Plan(
            table=table,
            recognised=f"OpenSesame, by {marks}",
            rt=rt,
            unit=columns.unit or "ms",
            participant=participant_column(table, columns, ("subject_nr", "participant", "subject")),
            judge=_judge(table, rt, ending, correct if scored else "", columns),
            notes=notes,
        )


def _candidates(table: Table) -> dict[str, int]:
    """Return the items' columns of times; `response_time` where there is none."""
    items = [name for name in table.header if name.startswith(_PREFIX)]
    names = [n for n in items if any(not is_missing(value) for value in table.values(n))] or ["response_time"]
    return {name: _n_times(table, name) for name in names}


def _n_times(table: Table, name: str) -> int:
    """Count the rows with a new response of this item: with another count, else another time."""
    ending = name.removeprefix("response_time")
    get, tell = (
        table.getter(name),
        table.getter(f"count{ending}" if f"count{ending}" in table.header else name),
    )
    n, last = 0, None
    for _, cells in table.lines:
        n += not is_missing(get(cells)) and tell(cells) != last
        last = tell(cells)
    return n


def _judge(
    table: Table, rt: str, ending: str, correct: str, columns: Columns
) -> Callable[[Sequence[str]], Trial | str]:
    answer = f"response{ending}" if f"response{ending}" in table.header else "response"
    response, has_response = table.getter(answer), answer in table.header
    time, right = table.getter(rt), table.getter(correct)
    count, who = table.getter(f"count{ending}" if ending else ""), table.getter("subject_nr")
    blocks = [table.getter(name) for name in table.header if name.lower() in ("practice", "block", "phase")]
    flag = table.getter("practice")
    before: dict[str, str] = {}

    def judge(cells: Sequence[str]) -> Trial | str:
        again = before.get(who(cells)) == count(cells) != ""
        before[who(cells)] = count(cells)
        if is_missing(time(cells)):
            return f"no value in {shown(rt)} yet (the item had not run)"
        if again:
            return "the response of the row before once more (logged without a new one)"
        practice = bool(is_right(flag(cells))) or any(is_practice(get(cells)) for get in blocks)
        if has_response and is_missing(response(cells)):
            waited = number_of(time(cells), f"{table.path}: column {shown(rt)}", columns)
            return Trial(
                rt="", outcome="no response", practice=practice, waited_s=waited / 1000.0 if waited else None
            )
        wrong = bool(correct) and is_right(right(cells)) is False
        return Trial(rt=time(cells), outcome="wrong" if wrong else "response", practice=practice)

    return judge
