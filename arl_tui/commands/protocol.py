"""`arl protocol`: every setting with what it means, as a file to start from; and what a file will do."""

import json
import textwrap
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

from arl_tui.command_line import say
from arl_tui.commands.play import read_protocol
from core.configuration.catalogue import TAG, Kind, Setting, Struct, settings_of, table_docs, tag_of
from core.feedback.config import TrainerConfig
from core.session.effects import MODES, idle, uses_of
from core.session.protocol import DEFAULTS, Protocol

WIDE = 100
"""Columns of the printed file."""


def print_protocol(game: str | None, path: Path | None) -> None:
    """Print a protocol (a game's default, or a file's) with every setting and what it means, as TOML."""
    say("\n".join(protocol_lines(read_protocol(path, game))))


def protocol_lines(protocol: Protocol) -> Iterator[str]:
    """Yield a protocol as TOML that reads back as the same one: each key below its meaning, range and use.

    A setting without effect in this protocol, and one that has no value, is there as a comment.
    """
    yield from _comment(
        f"A protocol of {protocol.game}: every setting with its default or value. What is left out of a file "
        f"has "
        'the default. A key without a line "Has an effect ..." has one in every session. '
        "`arl protocol --check FILE` says what a file will do."
    )
    yield from _table_lines(protocol, "", Unused(protocol))


class Unused:
    """Which settings have no effect in any session of a protocol, whatever their value."""

    def __init__(self, protocol: Protocol) -> None:
        self._protocol = protocol
        self._changed = {".".join(map(str, each.path)) for each in idle(protocol, DEFAULTS[protocol.game])}

    def commented(self, path: str) -> bool:
        """Return whether a setting is printed as a comment: at its default, and without effect."""
        return path not in self._changed and not any(
            all(use.when(self._protocol, mode) for use in uses_of(path)) for mode in MODES
        )


def _table_lines(table: msgspec.Struct, heading: str, unused: Unused) -> Iterator[str]:
    settings = settings_of(type(table))
    inner = {key: value for key in settings if isinstance(value := getattr(table, key), msgspec.Struct)}
    if tag_of(table):
        yield f'{TAG} = "{tag_of(table)}"'
    old: frozenset[str] = getattr(table, "OLD", frozenset())
    for key, setting in settings.items():
        value = getattr(table, key)
        hidden = (key in old and value == setting.default) or (setting.kind.base == "table" and value is None)
        if key not in inner and setting.kind.base != "tables" and not hidden:
            path = f"{heading}.{key}" if heading else key
            yield ""
            yield from _setting_lines(setting, getattr(table, key), path, unused)
    for key, setting in settings.items():
        if setting.kind.base == "tables":
            yield from _tables_lines(setting, getattr(table, key), heading)
    for key, value in inner.items():
        path = f"{heading}.{key}" if heading else key
        yield ""
        yield ""
        yield from _comment(settings[key].doc or table_docs(type(value)))
        yield from _comment(_types_in_words(settings[key].kind, tag_of(value)))
        for use in _uses_in_words(path):
            yield from _comment(use)
        yield f"[{path}]"
        yield from _table_lines(value, path, unused)


def _setting_lines(setting: Setting, value: object, path: str, unused: Unused) -> Iterator[str]:
    yield from _comment(setting.doc)
    yield from _comment(_values_in_words(setting.kind))
    own = [use for use in uses_of(path) if path in use.settings]
    for use in own:
        yield from _comment(f"Has an effect {use.where}.")
    if value is None:
        yield f"# {setting.key} = ..."
    else:
        plain = msgspec.to_builtins(value)
        yield f"{'# ' if unused.commented(path) else ''}{setting.key} = {toml_value(plain)}"


def _tables_lines(setting: Setting, value: Sequence[msgspec.Struct], heading: str) -> Iterator[str]:
    yield ""
    yield from _comment(setting.doc)
    (struct,) = (setting.kind.structs or {}).values()
    keys = "as in [trainer]" if struct is TrainerConfig else ", ".join(settings_of(struct))
    where = f"; [[{setting.key}]] stands at the end of a file" if not heading else ""
    yield from _comment(f"Each is a table with the keys {keys}{where}.")
    if value:
        # Inline, because a key above the first table may not be a list of tables below it.
        yield f"{setting.key} = {toml_value(msgspec.to_builtins(value))}"
    else:
        yield f"# {setting.key} = []"


def _types_in_words(kind: Kind, tag: str) -> str:
    """Return which other types a table can be of, each with its keys."""
    others = [_type_in_words(name, struct) for name, struct in (kind.structs or {}).items() if name != tag]
    return f"Other types: {'; '.join(others)}." if tag and others else ""


def _type_in_words(tag: str, struct: Struct) -> str:
    keys = ", ".join(settings_of(struct))
    return f"{tag} ({keys})" if keys else tag


def _values_in_words(kind: Kind) -> str:
    text = str(kind)
    return f"{text[0].upper()}{text[1:]}{', or left out' if kind.optional else ''}."


def _uses_in_words(path: str) -> Iterator[str]:
    for use in uses_of(path):
        if path in use.settings:
            yield f"Has an effect {use.where}."


def _comment(text: str) -> Iterator[str]:
    for line in textwrap.wrap(text, WIDE - 2, break_long_words=False, break_on_hyphens=False):
        yield f"# {line}"


def toml_lines(table: Mapping[str, Any], heading: str = "") -> Iterator[str]:
    """Yield a table as TOML: plain fields first, tables after them; None is left out (TOML has none).

    Args:
        table: strings, numbers, booleans, None, lists of these, and tables of all that.
        heading: dotted name of the table; empty for the outermost.
    """
    for name, value in table.items():
        if value is not None and not isinstance(value, Mapping):
            yield f"{name} = {toml_value(value)}"
    for name, value in table.items():
        if isinstance(value, Mapping):
            inner = f"{heading}.{name}" if heading else name
            yield f"\n[{inner}]"
            yield from toml_lines(value, inner)


def toml_value(value: object) -> str:
    """Return a value as it is written in TOML, on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        # TOML's basic strings escape as JSON's do, and the delete character, too.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        inner = (f"{name} = {toml_value(item)}" for name, item in value.items() if item is not None)
        return "{ " + ", ".join(inner) + " }"
    assert isinstance(value, Sequence), f"a protocol holds no {type(value).__name__}"
    return "[" + ", ".join(toml_value(item) for item in value) + "]"
