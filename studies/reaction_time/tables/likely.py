"""Which columns a user may have meant: a few proposals from the file, never all of its names."""

import difflib
import re
from collections.abc import Sequence

from studies.reaction_time.tables.cells import Table
from studies.reaction_time.tables.contract import PARTICIPANT, ReadError, shown
from studies.reaction_time.tables.numbers import is_missing

MOST_PROPOSALS = 5
FEW_COLUMNS = 6
"""So many columns are all named."""
_TIME_WORDS = (
    r"(^|[^a-z])rts?([^a-z]|$)|\.rt$|reaction.?time|response.?time|latenc|reaktionszeit|antwortzeit|"
    r"temps.?de.?r|tiempo.?de.?r|tempo.?di.?r|delay|(^|[^a-z])(lag|rtime)([^a-z]|$)|^rt|rt$"
)
_PERSON_WORDS = (
    r"(^|[^a-z])(participant|subject|subj|sub|vp|proband|versuchsperson|teilnehmer|ppn|pid|prolific|person)"
)
_MOMENT_WORDS = r"time|stamp|clock|unix|onset|zeit|date"
_LOOKED_AT = 200


def no_column(table: Table, name: str, option: str) -> ReadError:
    """Return the error for a column that the table lacks, with the likely ones of this file.

    Args:
        table: the table.
        name: the column that was asked for.
        option: how one is named, e.g. "--column rt=NAME".
    """
    names = [column for column in table.header if not column.startswith("(column ")]
    kinds = {"rt=": likely_times, "time=": likely_moments, "participant=": likely_participants}
    likely = next((find(table) for kind, find in kinds.items() if kind in option), [])
    likely = (_close(name, names) + [column for column in likely if column not in _close(name, names)])[
        :MOST_PROPOSALS
    ]
    words = f"{table.path}: no column {shown(name)}"
    if len(names) <= FEW_COLUMNS:
        words += f"; the columns are {', '.join(map(shown, names))}"
    else:
        words += f" among {len(names)} columns"
    if likely:
        words += f"; likely {'is' if len(likely) == 1 else 'are'} {', '.join(map(shown, likely))}"
    elif names and all(re.fullmatch(r"-?[\d.,]+", column) for column in names[1:] or names):
        words += "; the first line holds numbers: is the header missing?"
    elif len(names) > FEW_COLUMNS:
        words += f"; the first are {', '.join(map(shown, names[:MOST_PROPOSALS]))}"
    return ReadError(f"{words}. Name yours: {option}.")


def likely_times(table: Table) -> list[str]:
    """Return the columns that may hold reaction times, the likeliest first: by name and by their numbers."""
    named = [name for name in table.header if re.search(_TIME_WORDS, name.lower())]
    return sorted(named, key=lambda name: -_numeric_fraction(table, name))[:MOST_PROPOSALS]


def likely_moments(table: Table) -> list[str]:
    """Return the columns that may say when something happened, the likeliest first."""
    named = [name for name in table.header if re.search(_MOMENT_WORDS, name.lower())]
    return sorted(named, key=lambda name: -_numeric_fraction(table, name))[:MOST_PROPOSALS]


def likely_participants(table: Table) -> list[str]:
    """Return the columns that may hold the participants' codes, the first in the file first."""
    return [
        name
        for name in table.header
        if name != PARTICIPANT and re.search(_PERSON_WORDS, name.lower()) and len(table.values(name)) > 1
    ][:MOST_PROPOSALS]


def _close(name: str, names: Sequence[str]) -> list[str]:
    lower = {other.lower().strip(): other for other in names}
    found = difflib.get_close_matches(name.lower().strip(), lower, n=3, cutoff=0.75)
    return [lower[other] for other in found]


def _numeric_fraction(table: Table, name: str) -> float:
    get = table.getter(name)
    texts = [get(cells) for _, cells in table.lines[:_LOOKED_AT]]
    there = [text for text in texts if not is_missing(text)]
    return sum(bool(re.fullmatch(r"-?[\d.,\u00a0' ]+(e-?\d+)?", text, re.IGNORECASE)) for text in there) / (
        len(texts) or 1
    )
