"""A table of any program, by the names of its columns."""

from collections.abc import Sequence

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import BIDS, shown
from studies.reaction_time.tables.likely import no_column
from studies.reaction_time.tables.plan import Plan, Source, Trial, participant_column
from studies.reaction_time.tables.units import is_bids, unit_of


class Plain:
    """Columns are named by the caller; BIDS's names are the default."""

    name = "table"
    title = "a table"

    def marks(self, source: Source) -> str | None:
        """Return words for any table."""
        return "by its columns' names" if source.header else None

    def plan(self, source: Source, marks: str) -> Plan:
        """Return a plan in which every row is a trial."""
        table, columns = source.table, source.columns
        rt = columns.rt or BIDS.rt
        if rt not in table.header:
            raise no_column(table, rt, "--column rt=NAME")
        get = table.getter(rt)

        def judge(cells: Sequence[str]) -> Trial:
            return Trial(rt=get(cells))

        texts = [get(cells) for _, cells in table.lines]
        participant = participant_column(table, columns, ())
        return Plan(
            table=table,
            recognised=f"a table, {marks}",
            rt=rt,
            unit=columns.unit or unit_of(table.path, rt, texts),
            participant=participant,
            judge=judge,
            notes=_maybe_cut(source, table, rt),
            responses="rows",
            early_below_zero=rt == BIDS.rt and is_bids(table.path),
        )


def _maybe_cut(source: Source, table: Table, rt: str) -> tuple[str, ...]:
    """Return a note where the file ends inside a line and its last time is shorter than all others."""
    if not table.lines or source.text.content.endswith(("\n", "\r")) or table.header[-1] != rt:
        return ()
    get = table.getter(rt)
    texts = [get(cells) for _, cells in table.lines]
    others = [len(text) for text in texts[:-1] if text]
    if not others or len(texts[-1]) >= min(others):
        return ()
    return (
        (
            f"the file ends in line {table.lines[-1][0]} without an end of line, and its last time,"
            f" {shown(texts[-1])}, is shorter than all others: was it cut off in writing? Complete or remove"
            " that line"
        ),
    )
