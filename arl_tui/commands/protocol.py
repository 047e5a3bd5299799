"""`arl protocol`: a complete protocol to start from."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from arl_tui.commands.play import read_protocol
from core.recording.schema import to_plain


def print_protocol(game: str | None, path: Path | None) -> None:
    """Print a protocol (the default one of a game, or a file's) with every field filled in, as TOML."""
    click.echo("\n".join(toml_lines(to_plain(read_protocol(path, game)))))


def toml_lines(table: Mapping[str, Any], heading: str = "") -> Iterator[str]:
    """Yield a table as TOML: plain fields first, tables after them; None is left out (TOML has none).

    Args:
        table: strings, numbers, booleans, None, lists of these, and tables of all that.
        heading: dotted name of the table; empty for the outermost.
    """
    for name, value in table.items():
        if value is not None and not isinstance(value, Mapping):
            yield f"{name} = {_toml_value(value)}"
    for name, value in table.items():
        if isinstance(value, Mapping):
            inner = f"{heading}.{name}" if heading else name
            yield f"\n[{inner}]"
            yield from toml_lines(value, inner)


def _toml_value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, int | float):
        return repr(value)
    assert isinstance(value, Sequence), f"a protocol holds no {type(value).__name__}"
    return "[" + ", ".join(_toml_value(item) for item in value) + "]"
