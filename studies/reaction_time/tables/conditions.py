"""Columns that may hold conditions: a fit over several conditions describes none of them."""

import re
from collections.abc import Sequence

from core.system.foreign_text import printable
from studies.reaction_time.tables.cells import Line

MOST_VALUES = 8
"""A column with more different values than this is no condition."""
MOST_COLUMNS = 5
_SHOWN = 4
_WRITTEN_BY_PROGRAMS = re.compile(
    r"\.(keys|corr|rt|duration|started|stopped|this\w+|ran|order|t)$|\.(RESP|ACC|RT|CRESP|\w*Time|\w*Delay)$|"
    r"^(correct|response|reaction|response_time|count|time|acc|accuracy)(_|$)|"
    r"^(average_response_time|avg_rt|total)(_|$)|"
    r"^(Correct|Incorrect|Response|Response Type|Zone Type|Timed Out|Attempt|Participant"
    r" .*|corrAns|Session|rt|"
    r"trial_type|Procedure\[.*|Running\[.*|session|question)$"
)
"""What a participant did or the program noted, in the presets' files: no conditions."""


def unused_conditions(
    header: Sequence[str], lines: Sequence[Line], used: set[str], who: str | None, *, program: bool
) -> str | None:
    """Return a sentence on columns that may hold conditions; None where there are none.

    Args:
        header: names of the columns.
        lines: the rows that were taken.
        used: columns that are looked at.
        who: the column of participants, if any.
        program: the file is a known program's, whose own columns are no conditions.
    """
    people = header.index(who) if who in header else None
    found = []
    for at, name in enumerate(header):
        values = dict.fromkeys(cells[at].strip() for _, cells in lines)
        if name in used or not 2 <= len(values) <= MOST_VALUES or len(lines) < 2 * len(values):
            continue
        if program and _WRITTEN_BY_PROGRAMS.search(name):
            continue
        if people is not None and _one_value_per_person(lines, at, people):
            continue  # age group, site and the like
        shown = ", ".join(printable(value, longest=40) or "(empty)" for value in sorted(values)[:_SHOWN])
        found.append(f"{printable(name)} ({shown}{', ...' if len(values) > _SHOWN else ''})")
    if not found:
        return None
    more = f" and {len(found) - MOST_COLUMNS} more" if len(found) > MOST_COLUMNS else ""
    return (
        f"all rows are taken together whatever stands in the columns {'; '.join(found[:MOST_COLUMNS])}{more}"
    )


def _one_value_per_person(lines: Sequence[Line], at: int, people: int) -> bool:
    seen: dict[str, str] = {}
    return all(seen.setdefault(cells[people], cells[at]) == cells[at] for _, cells in lines)
