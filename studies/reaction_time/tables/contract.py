"""What readers of tables take and give: the column mapping, the reading, and the error.

A reading holds every row that was taken and counts every row that was not, with the reason: no reader drops a
row in silence.
"""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import msgspec

from core.system.foreign_text import printable
from studies.reaction_time.exclusion import Row

Unit = Literal["s", "ms", "us", "ns"]
SECONDS: dict[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
MISSING = frozenset(
    {"", "n/a", "na", "nan", "null", "none", ".", "-", "--", "?", "missing", "#n/a", "<na>", "#num!"}
)
"""Texts that mean: no value (compared in lower case)."""
PARTICIPANT = "participant_id"
"""BIDS's name for the column of the participant."""


class ReadError(ValueError):
    """This file cannot be used; the message says where, what came and what to do."""


class Columns(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which columns of a table hold what. A preset fills in what is left at its default."""

    rt: str = ""
    """Column of the reaction time; "" takes the preset's, or BIDS's `response_time`."""
    unit: Unit | None = None
    """Its unit; None takes it from the column's name, the sidecar or the preset."""
    participant: str | None = PARTICIPANT
    """Column of the participant; where the table lacks the default one (or None), the file name tells."""
    keep: dict[str, tuple[str, ...]] = {}
    """Rows to read: column to allowed values, e.g. {"TrialOutcome": ("SuccessfulGo",)}."""
    by: tuple[str, ...] = ()
    """Columns of conditions: each participant's rows are taken apart by their values."""
    decimal: Literal[".", ","] = "."
    """What separates decimals; never guessed, because 1,023 may be a thousand."""
    waited_s: float | None = None
    """The task's time-out in seconds: for rows without a response, and for times that are equal to it."""
    trust_magnitudes: bool = False
    """Accept medians outside `PLAUSIBLE_MEDIAN_S`, and times that look like a clock's."""
    missing: tuple[str, ...] = ()
    """Cells of times that mean: no response within the time-out, e.g. ("-1", "9999")."""
    encoding: str | None = None
    """Code page of the file; None takes UTF-8, UTF-16, and else Windows-1252, and says so."""
    of_list: Literal["first", "last"] | None = None
    """Which time counts in a cell that holds a list of times; None refuses such cells."""


BIDS = Columns(rt="response_time")
"""What BIDS defines: `response_time` in seconds (specification, task events)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What was read from one file."""

    path: Path
    recognised: str
    """Which program's file this is and by what it was recognised, in words."""
    mapping: str = ""
    """Which columns hold the times and the participants, and in which unit, in words."""
    rows: list[Row]
    """The rows taken, in the file's order."""
    taken: Counter[str] = field(default_factory=Counter)
    """What the rows taken are, e.g. {"responses": 68, "time-outs": 4}; sums to `len(rows)`."""
    left_out: Counter[str] = field(default_factory=Counter)
    """Reason to the number of rows that are not in `rows`."""
    notes: tuple[str, ...] = ()
    """What was odd about the file and how it was read nevertheless, in sentences."""
    conditions: str | None = None
    """A sentence on columns that may hold conditions and are not looked at; None where there are none."""


def shown(text: str) -> str:
    """Return a foreign text in quotation marks, safe for a terminal."""
    return f"'{printable(text, longest=60)}'"
