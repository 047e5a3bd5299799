"""The tables of `arl replay` as text and as a file."""

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from core.system.foreign_text import in_table
from core.system.whole_file import whole_file

if TYPE_CHECKING:
    from studies.statistics import Interval
    from studies.what_if import WhatIfRow

TRUST_SHOWN = 6
"""Values of trust in the table: evenly spaced over the watched games, the last one among them."""
NONE = "-"
PER_VALUE = "per-value:"
"""Begins the text of a credit rule with a density for each value."""


def table(rows: "Iterable[WhatIfRow]", units: str = "lines", width: int | None = None) -> Iterable[str]:
    """Yield the lines of two tables, and what has to be said about them.

    Two, because one is wider than most terminals. Where these are still too wide, rows have numbers. A list
    before the tables says what they stand for.

    Args:
        rows: of the tables.
        units: what is counted per game.
        width: of the terminal in columns; None where lines may be as long as they need to be.
    """
    rows, tables_of_delays = _with_short_names(rows)
    names = [(row.credit, row.rule) for row in rows]
    lines = list(_tables(rows, ("credit", "scheme"), names, units))
    if width is not None and max(map(len, lines)) > width:
        numbers = [(str(number),) for number in range(1, len(rows) + 1)]
        yield from _aligned(
            ("row", "credit", "scheme"),
            [(*number, *name) for number, name in zip(numbers, names, strict=True)],
            words=3,
        )
        yield ""
        lines = list(_tables(rows, ("row",), numbers, units))
    yield from lines
    yield from _remarks(rows)
    yield from tables_of_delays


def _tables(
    rows: "Sequence[WhatIfRow]", head: tuple[str, ...], names: Sequence[tuple[str, ...]], units: str
) -> Iterable[str]:
    """Yield both tables; each row begins with its names, one under each word of `head`."""
    first, words = rows[0], len(head)
    yield (
        f"How each agent plays its next episode: number {first.episode}, after {first.watched} watched games"
    )
    yield from _aligned(
        (*head, f"{units} per game", "minus the first row", "weight in use"),
        [(*name, _score(row), _difference(row), _weight(row)) for name, row in zip(names, rows, strict=True)],
        words=words,
    )
    yield ""
    yield "What the presses taught, and what the rule of trust made of it"
    yield from _aligned(
        (*head, "log-loss", "of the rate", "model is", "on steps", "trust over the watched games"),
        [(*name, *_taught(row)) for name, row in zip(names, rows, strict=True)],
        words=words,
        last_to_the_left=True,
    )


def _with_short_names(rows: "Iterable[WhatIfRow]") -> "tuple[list[WhatIfRow], list[str]]":
    """Return the rows with short names for rules that have a density per value, and what these stand for."""
    rows = list(rows)
    long = list(dict.fromkeys(row.credit for row in rows if row.credit.startswith(PER_VALUE)))
    names = {rule: f"per-value {n}" if len(long) > 1 else "per-value" for n, rule in enumerate(long, 1)}
    short = [replace(row, credit=names.get(row.credit, row.credit)) for row in rows]
    return short, [f"{name}: {rule.removeprefix(PER_VALUE)}." for rule, name in names.items()]


def _taught(row: "WhatIfRow") -> tuple[str, ...]:
    """Return the figures of the second table."""
    return (
        _number(row.held_out.log_loss),
        _number(row.held_out.of_the_rate),
        _verdict(row),
        NONE if math.isnan(row.credited) else f"{row.credited:.0%}",
        " ".join(f"{value:.2f}" for value in _evenly(row.trust)) or NONE,
    )


def _aligned(
    head: Sequence[str], rows: Sequence[Sequence[str]], *, words: int, last_to_the_left: bool = False
) -> Iterable[str]:
    """Yield lines in columns as wide as they need: `words` columns to the left, figures to the right."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in (head, *rows):
        cells = [
            f"{cell:<{width}}"
            if place < words or (last_to_the_left and place == len(head) - 1)
            else f"{cell:>{width}}"
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(cells).rstrip()


def _score(row: "WhatIfRow") -> str:
    cut = f" {row.capped:.0%} cut" if row.capped else ""
    return f"{row.lines.estimate:.1f} [{row.lines.low:.1f}, {row.lines.high:.1f}]{cut}"


def _difference(row: "WhatIfRow") -> str:
    found = row.difference
    return NONE if found is None else f"{found.estimate:+.1f} [{found.low:+.1f}, {found.high:+.1f}]"


def _weight(row: "WhatIfRow") -> str:
    if row.handover:
        return f"handover {row.handover:.2g}"
    return f"reward {row.shaping:.2g}" if row.shaping else f"{row.weight:.2g}"


def _number(value: float) -> str:
    return NONE if math.isnan(value) else f"{value:.3f}"


def _verdict(row: "WhatIfRow") -> str:
    return NONE if row.held_out.undefined else "worse" if row.held_out.worse else "better"


def _remarks(rows: "Sequence[WhatIfRow]") -> Iterable[str]:
    """Yield why figures are missing, and what the words mean."""
    undefined = {row.credit: row.held_out.undefined for row in rows if row.held_out.undefined}
    for credit, reason in undefined.items():
        yield f"No log-loss under {credit}: {reason}."
    if any(row.held_out.worse for row in rows):
        yield (
            "worse: the human model foretells the last presses worse than a constant guess, the rate of "
            "praise."
        )
    if any(math.isnan(row.credited) for row in rows):
        yield "on steps: no press counted, so none could be credited."


def _evenly(values: Sequence[float]) -> list[float]:
    if len(values) <= TRUST_SHOWN:
        return list(values)
    last = len(values) - 1
    return [values[round(last * k / (TRUST_SHOWN - 1))] for k in range(TRUST_SHOWN)]


def write_csv(
    path: Path, rows: "Iterable[WhatIfRow]", sources: Mapping[str, str], units: str = "lines"
) -> None:
    """Write the table with every figure in full precision; trust as one field, values separated by spaces.

    A figure that does not exist is an empty field.

    Args:
        path: of the new file.
        rows: of the table.
        sources: where each credit rule comes from, in words, by the rule.
        units: what is counted per game.
    """
    written = [_record(row, sources, units) for row in rows]
    with whole_file(path) as file:
        writer = csv.DictWriter(file, list(written[0]))
        writer.writeheader()
        writer.writerows(map(in_table, written))


def _record(row: "WhatIfRow", sources: Mapping[str, str], units: str) -> dict[str, object]:
    held_out = row.held_out
    return {
        "credit": row.credit,
        "scheme": row.scheme,
        "per": row.per or "",
        "episode": row.episode,
        "watched_games": row.watched,
        "weight": row.weight,
        "handover": row.handover,
        "shaping": row.shaping,
        **_interval(units, row.lines),
        "level": row.lines.level,
        **_interval("difference_to_first_row", row.difference),
        "capped": row.capped,
        "log_loss": "" if held_out.undefined else held_out.log_loss,
        "log_loss_of_the_rate": "" if held_out.undefined else held_out.of_the_rate,
        "log_loss_undefined": held_out.undefined,
        "worse_than_the_rate": "" if held_out.undefined else held_out.worse,
        "credited": "" if math.isnan(row.credited) else row.credited,
        "trust": " ".join(map(repr, row.trust)),
        "credit_source": sources[row.credit],
    }


def _interval(name: str, interval: "Interval | None") -> dict[str, object]:
    values = ("", "", "") if interval is None else (interval.estimate, interval.low, interval.high)
    return dict(zip((name, f"{name}_low", f"{name}_high"), values, strict=True))
