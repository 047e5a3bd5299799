"""What looks wrong about a set of reaction times without making it unusable: said, never repaired."""

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from studies.reaction_time.read import Columns, cells_of
from studies.reaction_time.sample import Sample

MOST_VALUES = 8
"""A column with more different values than this is no condition."""
FEWEST_TRIALS = 10
"""Two samples of fewer trials may agree by chance (times are often whole milliseconds)."""
_SHOWN = 4


def unused_conditions(path: Path, columns: Columns) -> str | None:
    """Return a sentence on columns that may hold conditions and are not looked at; None where there are none.

    Args:
        path: of a table that has been read with `columns`.
        columns: the mapping.
    """
    header, lines = cells_of(path)
    used = {columns.rt, columns.participant, *columns.keep, *columns.by}
    people = header.index(columns.participant) if columns.participant in header else None
    found = []
    for at, name in enumerate(header):
        values = dict.fromkeys(cells[at].strip() for _, cells in lines if at < len(cells))
        if name in used or not 2 <= len(values) <= MOST_VALUES or len(lines) < 2 * len(values):
            continue
        if people is not None and _one_value_per_person(lines, at, people):
            continue  # age group, site and the like
        shown = ", ".join(value or "(empty)" for value in list(values)[:_SHOWN])
        found.append(f"{name} ({shown}{', ...' if len(values) > _SHOWN else ''})")
    if not found:
        return None
    return f"{path.name}: all rows are taken together whatever stands in the columns {'; '.join(found)}"


def _one_value_per_person(lines: Sequence[tuple[int, list[str]]], at: int, people: int) -> bool:
    seen: dict[str, str] = {}
    return all(
        seen.setdefault(cells[people], cells[at]) == cells[at] for _, cells in lines if len(cells) > at
    )


def alike_names(names: Sequence[str]) -> Iterator[str]:
    """Yield a sentence for participants whose codes differ in case, spaces, punctuation or leading zeros only."""
    groups: dict[str, list[str]] = {}
    for name in names:
        key = re.sub(r"(?<!\d)0+(?=\d)|\.0$", "", name.lower())
        groups.setdefault(re.sub(r"[\W_]+", "", key), []).append(name)
    for group in groups.values():
        if len(group) > 1:
            yield f"the participants {' and '.join(map(repr, group))} may be one: they are fitted apart"


def copied_times(samples: Mapping[str, Sample]) -> Iterator[str]:
    """Yield a sentence for participants with the very same times, and for one whose times all come in pairs."""
    first: dict[bytes, str] = {}
    for name, sample in samples.items():
        times = sample.observed_s
        if times.size < FEWEST_TRIALS:
            continue
        other = first.setdefault(times.tobytes(), name)
        if other != name:
            yield f"{other!r} and {name!r} have the same {times.size} times: is it one participant twice?"
        if times.size % 2 == 0 and (times[::2] == times[1::2]).all():
            yield f"each of the times of {name!r} is there twice: was a file read, or stored, twice?"
