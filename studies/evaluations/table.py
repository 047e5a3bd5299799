"""Read a table of evaluations: who pressed, when, what value, and how long after the event that it judges."""

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from pathlib import Path

from core.numerics.clock import LONGEST_NS, NS_PER_S
from core.recording.importers.contract import ImporterError
from studies.reaction_time.tables.cells import Table, parse
from studies.reaction_time.tables.contract import SECONDS, Columns, ReadError, shown
from studies.reaction_time.tables.likely import no_column
from studies.reaction_time.tables.numbers import is_missing, number_of
from studies.reaction_time.tables.text import read_text
from studies.reaction_time.tables.units import unit_in_name

_CODE = re.compile(r"[A-Za-z0-9_-]{1,32}")


@dataclass(frozen=True, slots=True, kw_only=True)
class EvaluationColumns:
    """Which columns hold what."""

    participant: str = "participant_id"
    time: str = "time_s"
    """Time of the press, on any clock."""
    value: str = "value"
    """What was said: > 0 good, < 0 bad, 0 neither."""
    delay: str | None = "delay_s"
    """Time from the event judged to the press; None, or a default column that is not there: not known."""
    by: tuple[str, ...] = ()
    """Columns (task, session) whose values make recordings of their own."""
    unit: str | None = None
    """Unit of both times where their columns' names do not end in one: s, ms, us or ns."""
    encoding: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """One press."""

    line: int
    time_ns: int
    value: float
    delay_ns: int | None
    """None where the table does not say."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EvaluationTable:
    """A table as read: sessions of participants, each sorted by time."""

    sessions: dict[tuple[str, ...], list[Evaluation]]
    """Participant and values of the `by` columns to evaluations in the order of their times."""
    has_delays: bool
    left_out: Counter[str]
    """Reason to the number of rows without an evaluation."""
    out_of_order: int
    """Rows whose time is before the one above them in the same session; sorted."""
    notes: tuple[str, ...]


def read_evaluations(path: Path, columns: EvaluationColumns) -> EvaluationTable:
    """Read a CSV or TSV table.

    Raises:
        ImporterError: a column is missing or has no unit, or a cell cannot be understood (file, line,
    column).
    """
    try:
        text = read_text(path, columns.encoding)
        table = parse(path, text.content)
        return _read(table, columns, text.notes)
    except ReadError as error:
        raise ImporterError(str(error)) from error


def _check_columns(table: Table, columns: EvaluationColumns) -> bool:
    """Refuse a table without a column that was named or is needed; return whether it holds delays."""
    for what, name in (
        ("participant", columns.participant),
        ("time", columns.time),
        ("value", columns.value),
    ):
        if name not in table.header:
            raise no_column(table, name, f"--column {what}=NAME")
    for name in columns.by:
        if name not in table.header:
            raise no_column(table, name, "--by COLUMN")
    has_delays = columns.delay is not None and columns.delay in table.header
    if columns.delay not in (None, EvaluationColumns().delay) and not has_delays:
        raise no_column(table, columns.delay or "", "--column delay=NAME")
    return has_delays


def _read(table: Table, columns: EvaluationColumns, notes: Sequence[str]) -> EvaluationTable:
    has_delays = _check_columns(table, columns)
    time_s, delay_s = _factor(table, columns.time, columns), 1.0
    if has_delays and columns.delay is not None:
        delay_s = _factor(table, columns.delay, columns)
    sessions: dict[tuple[str, ...], list[Evaluation]] = {}
    left_out = Counter(table.left_out)
    who, get_time, get_value = (
        table.getter(name) for name in (columns.participant, columns.time, columns.value)
    )
    get_delay = table.getter(columns.delay or "")
    conditions = [table.getter(name) for name in columns.by]
    for line, cells in table.lines:
        value = number_of(get_value(cells), f"{table.path}:{line}: column {shown(columns.value)}", Columns())
        if value is None or is_missing(get_time(cells)):
            left_out["without a value" if value is None else "without a time"] += 1
            continue
        delay = number_of(
            get_delay(cells), f"{table.path}:{line}: column {shown(columns.delay or '')}", Columns()
        )
        key = (_code(table, line, who(cells)), *(get(cells) for get in conditions))
        sessions.setdefault(key, []).append(
            Evaluation(
                line=line,
                time_ns=_nanoseconds(table, line, columns.time, get_time(cells), time_s),
                value=value,
                delay_ns=None
                if delay is None
                else _delay_ns(table, line, columns.delay or "", delay * delay_s),
            )
        )
    if not sessions:
        raise ReadError(f"{table.path}: no row holds an evaluation ({dict(left_out) or 'there are no rows'})")
    out_of_order = sum(
        b.time_ns < a.time_ns for some in sessions.values() for a, b in itertools.pairwise(some)
    )
    for some in sessions.values():
        some.sort(key=lambda one: one.time_ns)
    return EvaluationTable(
        sessions=sessions,
        has_delays=has_delays,
        left_out=left_out,
        out_of_order=out_of_order,
        notes=(*notes, *table.notes),
    )


def _factor(table: Table, name: str, columns: EvaluationColumns) -> float:
    unit = columns.unit or unit_in_name(name)
    if unit is None:
        raise ReadError(
            f"{table.path}: column {shown(name)} has no unit: state it (--unit s) or name the column {name}_s"
            f" or {name}_ms"
        )
    return SECONDS[unit]


def _code(table: Table, line: int, text: str) -> str:
    if not _CODE.fullmatch(text):
        raise ReadError(
            f"{table.path}:{line}: the participant is {shown(text)}; expected a code of up to 32 letters,"
            " digits, '-' or '_', because it names a file. Never a name"
        )
    return text


def _delay_ns(table: Table, line: int, name: str, delay_s: float) -> int:
    if not abs(delay_s) < LONGEST_NS / NS_PER_S:
        raise ReadError(
            f"{table.path}:{line}: column {shown(name)} holds a delay of {delay_s:g} s, more than a century"
        )
    return round(delay_s * NS_PER_S)


def _nanoseconds(table: Table, line: int, name: str, text: str, factor: float) -> int:
    """Return a time exactly: seconds since 1970 with microseconds do not fit into a float."""
    try:
        time = Decimal(text) * Decimal(str(factor)) * NS_PER_S
        if abs(time) < LONGEST_NS:
            return int(time.to_integral_value())
    except (InvalidOperation, ValueError):
        pass
    raise ReadError(
        f"{table.path}:{line}: column {shown(name)} holds {shown(text)}; expected a number of seconds,"
        " ms, ..."
    )
