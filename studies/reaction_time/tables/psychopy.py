"""PsychoPy's data files: one CSV per session, a row per pass of a loop, times in seconds.

A Keyboard component called `resp` writes `resp.keys` ("None" where there was no response), `resp.rt` and, if
it stores what is correct, `resp.corr`. Rows of other routines leave these cells empty. A trial that asks for
no response has "None" as its right answer. PsychoJS leaves the keys of a missed trial empty, but not what was
correct.
"""

from collections.abc import Callable, Sequence

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import Columns, ReadError, shown
from studies.reaction_time.tables.numbers import is_missing
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

_SUMMARY = ("_mean", "_raw", "_std")


class PsychoPy:
    """See the module."""

    name = "psychopy"
    title = "PsychoPy"

    def marks(self, source: Source) -> str | None:
        """Return the columns that only PsychoPy writes."""
        header = source.header
        found = [name for name in ("psychopyVersion", "expName", "frameRate") if name in header]
        loop = next((name for name in header if name.endswith(".thisN")), None)
        times = any(name.endswith(".rt") for name in header)
        summary = any(name.endswith(tuple(f".rt{end}" for end in _SUMMARY)) for name in header)
        if (found and (loop or times or summary)) or (loop and times):
            return ", ".join(shown(name) for name in [*found, *([loop] if loop else [])])
        return "summary columns such as '.rt_mean'" if summary else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Take the rows in which the component that recorded the most trials was on."""
        table, columns = source.table, source.columns
        if not any(name.endswith(".rt") for name in table.header) and not columns.rt:
            raise ReadError(
                f"{table.path}: this is PsychoPy's summary, or no component stored times: there is no column"
                " that ends in '.rt'. Take the 'trial-by-trial' CSV of the same session"
            )
        loops = [name for name in table.header if name.endswith(".thisN")]
        rt = rt_column(table, columns, _candidates(table, loops), self.title)
        component = rt.removesuffix(".rt")
        scored, notes = scores(table, f"{component}.corr")
        return Plan(
            table=table,
            recognised=f"PsychoPy, by {marks}",
            rt=rt,
            unit=columns.unit or "s",
            participant=participant_column(table, columns, ("participant", "participant_id", "PROLIFIC_PID")),
            judge=_judge(table, rt, loops, scored=scored, columns=columns),
            notes=notes,
        )


def _candidates(table: Table, loops: Sequence[str]) -> dict[str, int]:
    """Return each column of times and how many rows of loops hold one; of all rows where there is no loop."""
    inside = [table.getter(name) for name in loops]
    lines = [cells for _, cells in table.lines if not inside or any(get(cells) for get in inside)]
    names = [name for name in table.header if name.endswith(".rt")]
    return {name: sum(not is_missing(table.getter(name)(cells)) for cells in lines) for name in names}


def _judge(
    table: Table, rt: str, loops: Sequence[str], *, scored: bool, columns: Columns
) -> Callable[[Sequence[str]], Trial | str]:
    component = rt.removesuffix(".rt")
    time, keys, right = (table.getter(name) for name in (rt, f"{component}.keys", f"{component}.corr"))
    answer, started = table.getter("corrAns"), table.getter(f"{component}.started")
    in_loops = [(table.getter(name), is_practice(name)) for name in loops]
    chosen = bool(columns.keep)

    def judge(cells: Sequence[str]) -> Trial | str:
        here = [practice for get, practice in in_loops if get(cells)]
        if in_loops and not here and not chosen:
            return "outside the loops of trials (instructions, end of the session)"
        practice = any(here)
        if not is_missing(time(cells)):
            wrong = scored and is_right(right(cells)) is False
            return Trial(rt=time(cells), outcome="wrong" if wrong else "response", practice=practice)
        if keys(cells) == right(cells) == started(cells) == "":
            return f"another routine's: {shown(component)} was not on"
        if answer(cells).lower() == "none":
            return Trial(rt="", outcome="withheld", practice=practice)
        return Trial(rt="", outcome="no response", practice=practice)

    return judge
