"""Columns of exported tables, and the codebook that describes them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

Kind = Literal["text", "integer", "number", "boolean"]
Cell = str | int | float | bool | None
Row = dict[str, Cell]
FORMAT_OF_CODEBOOK = "arl-codebook"


@dataclass(frozen=True, slots=True)
class Column:
    """One column of a table."""

    name: str
    """Ends in the unit where there is one: `_s`, `_ns`, `_hz`."""
    kind: Kind
    meaning: str
    """In plain sentences; says when a cell is empty."""
    unit: str = ""
    levels: Mapping[str, str] = field(default_factory=dict)
    """Every value that a text may have, with its meaning; empty where there is no such list."""


@dataclass(frozen=True, slots=True)
class Table:
    """One table."""

    name: str
    row: str
    """What one row is."""
    columns: tuple[Column, ...]
    names: tuple[str, ...] = field(init=False, repr=False, compare=False)
    """Of the columns, in order. Made once: tuples made for every row pile up in Python's free lists."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(column.name for column in self.columns))

    def checked(self, row: Row) -> Row:
        """Return a row with its columns in order.

        Raises:
            ValueError: it has other columns than the table.
        """
        if row.keys() != set(self.names):
            other = sorted(row.keys() ^ set(self.names))
            raise ValueError(f"a row of {self.name} has the table's columns, not these: {', '.join(other)}")
        return {name: row[name] for name in self.names}


def codebook(tables: Sequence[Table], *, ending: str = "csv") -> dict[str, Any]:
    """Return the codebook in plain JSON types, as a Frictionless data package: every column, unit and level.

    Args:
        tables: in order.
        ending: of the tables' files.
    """
    kinds = {"text": "string", "integer": "integer", "number": "number", "boolean": "boolean"}
    return {
        "profile": "tabular-data-package",
        "name": FORMAT_OF_CODEBOOK,
        "resources": [
            {
                "name": table.name,
                "path": f"{table.name}.{ending}",
                "description": f"One row: {table.row}",
                "schema": {
                    "fields": [
                        {"name": column.name, "type": kinds[column.kind], "description": column.meaning}
                        | ({"unit": column.unit} if column.unit else {})
                        | (
                            {"trueValues": ["TRUE"], "falseValues": ["FALSE"]}
                            if column.kind == "boolean"
                            else {}
                        )
                        | (
                            {"constraints": {"enum": list(column.levels)}, "levels": dict(column.levels)}
                            if column.levels
                            else {}
                        )
                        for column in table.columns
                    ],
                    "missingValues": [""],
                },
            }
            for table in tables
        ],
    }


def codebook_page(tables: Sequence[Table]) -> str:
    """Return the codebook as a page of Markdown."""
    return "\n".join(_page_lines(tables)) + "\n"


def _page_lines(tables: Sequence[Table]) -> Iterator[str]:
    yield "# Codebook of the tidy tables"
    yield ""
    yield "Made by `arl export codebook`: do not edit. `arl export tidy` writes these tables and this page."
    yield ""
    yield (
        "An empty cell means: there is no such value; the column says when. TRUE and FALSE are truth values. "
        "Times in"
    )
    yield (
        "`_s` are seconds since the session began, to the nanosecond. Numbers of games and of steps in a "
        "game are as people"
    )
    yield (
        "count, from 1. Columns whose names end in `_index` hold the numbers of the recording, from 0, and "
        "join tables."
    )
    for table in tables:
        yield ""
        yield f"## {table.name}"
        yield ""
        yield f"One row: {table.row}"
        yield ""
        yield "| column | type | unit | meaning |"
        yield "|---|---|---|---|"
        for column in table.columns:
            levels = "; ".join(
                f"`{level}`: {text}" if text else f"`{level}`" for level, text in column.levels.items()
            )
            meaning = f"{column.meaning} Levels: {levels}." if levels else column.meaning
            yield f"| `{column.name}` | {column.kind} | {column.unit} | {meaning} |"
