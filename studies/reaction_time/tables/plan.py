"""What a preset decides about a table, and the one loop that reads by it and counts what it leaves out."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, Protocol

from core.system.foreign_text import printable
from studies.reaction_time.exclusion import Row
from studies.reaction_time.tables.cells import Table, parse
from studies.reaction_time.tables.conditions import unused_conditions
from studies.reaction_time.tables.contract import PARTICIPANT, SECONDS, Columns, ReadError, Reading, shown
from studies.reaction_time.tables.likely import likely_participants, no_column
from studies.reaction_time.tables.numbers import is_missing, number_of
from studies.reaction_time.tables.text import Text, read_text
from studies.reaction_time.tables.units import check_magnitudes

TrialOutcome = Literal["response", "wrong", "no response", "too early", "withheld"]
"""What a trial ended in. `withheld`: no response was asked for (a no-go or catch trial)."""
_STATUS: dict[TrialOutcome, str] = {
    "wrong": "wrong key",
    "no response": "time-out",
    "too early": "anticipation",
}
_WORDS: dict[TrialOutcome, str] = {
    "wrong": "wrong answers",
    "no response": "without a response",
    "too early": "too early",
    "withheld": "with no response asked for",
}
_SAME_TIME_S = 5e-4


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One row of a table that is a trial."""

    rt: str
    """The cell with the reaction time."""
    outcome: TrialOutcome = "response"
    practice: bool = False
    waited_s: float | None = None
    """How long a trial without a response waited; None where the file does not say."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    """How one file is read."""

    table: Table
    recognised: str
    """Which program's file, and by which marks, in words."""
    rt: str
    unit: str
    participant: str | None
    """The column of participants; None takes them from the file's name."""
    judge: Callable[[Sequence[str]], Trial | str]
    """Returns the trial in a row's cells, or why the row is none."""
    notes: tuple[str, ...] = ()
    responses: str = "responses"
    """What rows with a time are called in the counts; "rows" where nothing tells that they are responses."""
    early_below_zero: bool = False
    """Negative times are responses before the stimulus (BIDS) rather than faults."""


@dataclass(frozen=True)
class Source:
    """A file that is recognised and read; its text is read once."""

    path: Path
    columns: Columns

    @cached_property
    def text(self) -> Text:
        """The file's text."""
        return read_text(self.path, self.columns.encoding)

    @cached_property
    def table(self) -> Table:
        """The file as a delimited table; ReadError where it is none."""
        return parse(self.path, self.text.content)

    @property
    def header(self) -> list[str]:
        """The table's header; empty where the file is no table."""
        try:
            return self.table.header
        except ReadError:
            return []


class Preset(Protocol):
    """How one program's files are recognised and read."""

    name: str
    """What `--from` calls it."""
    title: str

    def marks(self, source: Source) -> str | None:
        """Return by what the file is recognised, in words; None if it is not this program's."""

    def plan(self, source: Source, marks: str) -> Plan:
        """Return how to read it; raise ReadError where that cannot be told without a person's word."""


@dataclass
class _Counts:
    taken: Counter[str] = field(default_factory=Counter)
    left_out: Counter[str] = field(default_factory=Counter)


def read_by(plan: Plan, columns: Columns, notes: Sequence[str] = ()) -> Reading:
    """Read a table by a plan.

    Raises:
        ReadError: a column, unit or value cannot be understood, or no row is left.
    """
    table, path = plan.table, plan.table.path
    for name in (*columns.keep, *columns.by):
        if name not in table.header:
            raise no_column(table, name, "--keep COLUMN=VALUE, --by COLUMN")
    tests = [(table.getter(name), _allowed(values)) for name, values in columns.keep.items()]
    counts = _Counts(left_out=Counter(table.left_out))
    rows, lines = [], []
    for number, cells in table.lines:
        if any(get(cells) not in allowed for get, allowed in tests):
            counts.left_out["not kept by " + " and ".join(map(shown, columns.keep))] += 1
            continue
        trial = plan.judge(cells)
        if isinstance(trial, str):
            counts.left_out[trial] += 1
            continue
        row = _row(plan, columns, number, cells, trial)
        counts.taken[_taken_words(plan, columns, row, trial)] += 1
        rows.append(row)
        lines.append((number, cells))
    if not rows:
        raise ReadError(_nothing_left(plan, columns, counts.left_out))
    if not columns.trust_magnitudes:
        check_magnitudes(path, plan.rt, rows, SECONDS[plan.unit])
    return Reading(
        path=path,
        recognised=plan.recognised,
        mapping=_mapping(plan),
        rows=rows,
        taken=counts.taken,
        left_out=counts.left_out,
        conditions=unused_conditions(
            table.header,
            lines,
            {plan.rt, *columns.keep, *columns.by, plan.participant or ""},
            plan.participant,
            program=plan.responses == "responses",
        ),
        notes=(*notes, *table.notes, *plan.notes, *_one_person(table, columns, plan.participant)),
    )


def _allowed(values: Sequence[str]) -> frozenset[str]:
    return frozenset(value.strip() for value in values)


def _taken_words(plan: Plan, columns: Columns, row: Row, trial: Trial) -> str:
    words = plan.responses if trial.outcome == "response" else _WORDS[trial.outcome]
    if row.status == "time-out" and trial.outcome == "response":
        words = "without a response" if trial.rt in columns.missing else "at the time-out"
    return f"{words} (practice)" if trial.practice else words


def _row(plan: Plan, columns: Columns, number: int, cells: Sequence[str], trial: Trial) -> Row:
    table = plan.table
    where = f"{table.path}:{number}: column {shown(plan.rt)}"
    coded = trial.rt in columns.missing
    rt = (
        None if coded or trial.outcome in ("no response", "withheld") else number_of(trial.rt, where, columns)
    )
    rt_s = None if rt is None else rt * SECONDS[plan.unit]
    waited_s = columns.waited_s if trial.waited_s is None else trial.waited_s
    status = "time-out" if coded else _STATUS.get(trial.outcome, "ok")
    if rt_s is not None and columns.waited_s is not None and abs(rt_s - columns.waited_s) < _SAME_TIME_S:
        rt_s, status = None, "time-out"
    elif rt_s is not None and rt_s < 0.0 and plan.early_below_zero:
        status = "anticipation"
    return Row(
        participant=_participant(plan, number, cells, columns),
        source=f"{printable(table.path.name)}:{number}",
        rt_s=rt_s,
        status=status,
        practice=trial.practice,
        response_asked=trial.outcome != "withheld",
        waited_s=waited_s,
    )


def _participant(plan: Plan, number: int, cells: Sequence[str], columns: Columns) -> str:
    code = participant_of(plan.table.path)
    if plan.participant is not None:
        code = plan.table.getter(plan.participant)(cells)
        if is_missing(code):
            raise ReadError(
                f"{plan.table.path}:{number}: no participant in column {shown(plan.participant)}, but"
                f" {shown(code)}; leave such rows out by the values of another column, or complete them"
            )
    conditions = (plan.table.getter(name)(cells) or "(none)" for name in columns.by)
    return printable(" ".join([code, *conditions]), longest=None)


def _mapping(plan: Plan) -> str:
    who = f"column {shown(plan.participant)}" if plan.participant is not None else "the file's name"
    return f"times from column {shown(plan.rt)} in {plan.unit}, participants from {who}"


def _nothing_left(plan: Plan, columns: Columns, left_out: Mapping[str, int]) -> str:
    if not plan.table.lines and not left_out:
        return f"{plan.table.path}: no row left to read: there is a header and nothing else"
    why = ", ".join(f"{n} {reason}" for reason, n in left_out.items())
    there = "; ".join(
        f"{shown(name)} holds "
        f"{', '.join(shown(value) for value, _ in plan.table.values(name).most_common(4))}"
        for name in columns.keep
    )
    return f"{plan.table.path}: no row left to read ({why})" + (f"; {there}" if there else "")


def _one_person(table: Table, columns: Columns, participant: str | None) -> tuple[str, ...]:
    """Return a note where all rows are taken as one person's although a column may tell people apart."""
    likely = likely_participants(table) if participant is None and columns.participant is not None else []
    if not likely:
        return ()
    return (
        (
            f"no column {shown(columns.participant or '')}: all rows are taken as those of "
            f"{shown(participant_of(table.path))}, from the file's name. Does {shown(likely[0])} tell them "
            "apart? --column participant=NAME"
        ),
    )


# --- what several presets need ------------------------------------------------------------------------------


def participant_of(path: Path) -> str:
    """Return sub-XX of a BIDS file name, else the name without its endings."""
    name = path.name
    if name.startswith("sub-"):
        return name.split("_")[0].split(".")[0]
    return name.split(".")[0]


def participant_column(table: Table, columns: Columns, candidates: Sequence[str]) -> str | None:
    """Return the column of participants: the named one, else the first candidate with values.

    Raises:
        ReadError: the named column is not there.
    """
    if columns.participant is None:
        return None
    if columns.participant != PARTICIPANT or PARTICIPANT in table.header:
        if columns.participant not in table.header:
            raise no_column(table, columns.participant, "--column participant=NAME")
        return columns.participant
    for name in candidates:
        if name in table.header and not all(is_missing(value) for value in table.values(name)):
            return name
    return None


def rt_column(table: Table, columns: Columns, candidates: Mapping[str, int], program: str) -> str:
    """Return the column of times: the one that was named, else the candidate with by far the most times.

    Args:
        table: the table.
        columns: the mapping with the name, if any.
        candidates: column to the number of trials with a time in it.
        program: for the message.

    Raises:
        ReadError: the named column is not there, or there are no or several candidates.
    """
    if columns.rt:
        if columns.rt not in table.header:
            raise no_column(table, columns.rt, "--column rt=NAME")
        return columns.rt
    ranked = sorted(candidates.items(), key=lambda pair: -pair[1])
    if not ranked or ranked[0][1] == 0:
        raise ReadError(f"{table.path}: {program}'s file holds no time of a response in any column")
    rivals = [f"{shown(name)} ({n} times)" for name, n in ranked if 2 * n >= ranked[0][1]]
    if len(rivals) > 1:
        more = ", ..." if len(rivals) > 5 else ""
        raise ReadError(
            f"{table.path}: {program} recorded responses of several kinds, {', '.join(rivals[:5])}{more}:"
            " which are the reactions? --column rt=NAME"
        )
    return ranked[0][0]


def is_right(text: str) -> bool | None:
    """Return whether an answer was right by a cell such as 1, true, 0.0; None where it does not say."""
    lower = text.strip().lower()
    if lower in ("1", "1.0", "true", "yes", "correct"):
        return True
    return False if lower in ("0", "0.0", "false", "no", "incorrect", "wrong") else None


def scores(table: Table, column: str) -> tuple[bool, tuple[str, ...]]:
    """Return whether a column tells right answers from wrong ones, and a note where it says all are wrong."""
    verdicts = {is_right(value) for value in table.values(column)}
    if True in verdicts:
        return True, ()
    if False in verdicts:
        return False, (
            (
                f"the column {shown(column)} calls no answer right: no right answer was defined, so it is not"
                " used"
            ),
        )
    return False, ()


def is_practice(text: str) -> bool:
    """Return whether a block's or a screen's name says practice."""
    lower = text.strip().lower()
    return lower.startswith(("prac", "train", "\u00fcbung", "uebung")) or "practice" in lower
