"""Reading a configuration from plain types: whatever cannot be used is named with its place.

The structs that are read say all there is to know (`core.configuration.catalogue`). What they check
themselves when they are made, such as two settings that exclude each other, is found last, and named in the
same way.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

import msgspec

from core.configuration.catalogue import TAG, Kind, Struct, settings_of, tables_of, tag_of
from core.configuration.fields import plain
from core.configuration.messages import Path, nearest, quoted, shown, shown_key, shown_path
from core.configuration.open_table import decode_open_table

DEEPEST = 20
"""Levels of tables within tables; a configuration has five."""
Config = TypeVar("Config", bound=msgspec.Struct)


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong with a configuration."""

    path: Path
    """Keys from the outermost table to the setting."""
    reason: str
    """What was expected, what to do."""
    value: object = None
    """What came; None where the reason says it."""

    def __str__(self) -> str:
        """Return place, value and reason: "[session] episodes = 0: expected ..."."""
        place = shown_path(self.path)
        if self.value is not None:
            place += f" = {shown(self.value)}"
        return f"{place}: {self.reason}" if place else self.reason


class ConfigurationError(msgspec.ValidationError):
    """A configuration cannot be used; the message names every place and reason, one a line."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        super().__init__("\n".join(str(problem) for problem in problems))
        self.problems = tuple(problems)


def read(given: Mapping[str, Any], default: Config, *, to_run: bool) -> Config:
    """Return the configuration that plain types describe; what is not given is as in `default`.

    A table of another type than the default's stands for itself: what is not given is as in that type. A type
    alone, written as a text, stands for the table of that type with its defaults.

    Args:
        given: tables by key, as in TOML or JSON.
        default: of the same kind.
        to_run: values that nobody means (`core.configuration.fields`, usual) are refused, too: nothing has
            been run yet.

    Raises:
        ConfigurationError: with every place and reason.
    """
    given = with_tables(given, type(default))
    found = list(_wrong_in_table(given, type(default), default, (), to_run, Places(type(default))))
    if found:
        raise ConfigurationError(found)
    try:
        complete = filled(given, msgspec.to_builtins(default))
        return msgspec.convert(complete, type(default), dec_hook=decode_open_table)
    except (msgspec.ValidationError, ValueError) as error:
        raise ConfigurationError([_from_struct(str(error), given)]) from error


def read_whole(given: Mapping[str, Any], struct: type[Config]) -> Config:
    """Return the configuration that plain types describe, where nothing stands for what is left out but the
    struct's own.

    Args:
        given: tables by key, as in TOML.
        struct: what is read.

    Raises:
        ConfigurationError: with every place and reason.
    """
    given = with_tables(given, struct)
    found = list(_wrong_in_table(given, struct, None, (), True, Places(struct)))
    if found:
        raise ConfigurationError(found)
    try:
        return msgspec.convert(given, struct)
    except (msgspec.ValidationError, ValueError) as error:
        raise ConfigurationError([_from_struct(str(error), given)]) from error


def with_tables(given: Mapping[str, Any], struct: Struct, depth: int = 0) -> dict[str, Any]:
    """Return `given` with a table in the place of each text that names a table's type."""
    if depth > DEEPEST:
        raise ConfigurationError([Problem((), f"tables lie more than {DEEPEST} deep in each other")])
    settings = settings_of(struct)
    found: dict[str, Any] = {}
    for key, value in given.items():
        kind = settings[key].kind if key in settings else None
        found[key] = value
        if kind is None or kind.structs is None:
            continue
        if kind.base == "tables" and isinstance(value, list | tuple):
            found[key] = [_with_tables_of(item, kind.structs, depth) for item in value]
        elif kind.base == "table":
            if isinstance(value, str) and "" not in kind.structs:
                value = {TAG: value}
            if isinstance(value, Mapping):
                tag = value.get(TAG)
                known = isinstance(tag, str) and tag in kind.structs
                # Where it names no type, keys of all types: which one it is will be checked later.
                for inner in [kind.structs[str(tag)]] if known else kind.structs.values():
                    value = with_tables(value, inner, depth + 1)
            found[key] = value
    return found


def _with_tables_of(value: object, structs: Mapping[str, Struct], depth: int) -> object:
    if isinstance(value, Mapping):
        # Keys of all types: which type it is will be checked later.
        for inner in structs.values():
            value = with_tables(value, inner, depth + 1)
    return value


def filled(given: Mapping[str, Any], default: Mapping[str, Any]) -> dict[str, Any]:
    """Return `given` with the default's fields where it has none, table by table."""
    found = {key: value for key, value in default.items() if key not in given}
    for key, value in given.items():
        below = default.get(key)
        if isinstance(value, Mapping) and isinstance(below, Mapping) and _same_type(value, below):
            found[key] = filled(value, below)
        else:
            found[key] = value
    return found


def _same_type(value: Mapping[str, Any], default: Mapping[str, Any]) -> bool:
    kind = default.get(TAG)
    return bool(value.get(TAG, kind) == kind)


class Places:
    """Where keys belong: for messages about those that stand in the wrong table."""

    def __init__(self, struct: Struct) -> None:
        self._struct = struct

    @cached_property
    def _places(self) -> dict[str, list[str]]:
        """Tables by key; all types of all tables are looked at only where a message needs them."""
        found: dict[str, list[str]] = {key: ["the top of the file"] for key in settings_of(self._struct)}
        for path, kind in tables_of(self._struct):
            name = f"[{'.'.join(path)}]"
            for tag, inner in (kind.structs or {}).items():
                for key in settings_of(inner):
                    found.setdefault(key, []).append(f'{name} of type "{tag}"' if tag else name)
        return found

    def of(self, key: str) -> str:
        """Return the tables that have a key, in words; "" where none has."""
        places = list(dict.fromkeys(self._places.get(key, [])))
        return " or ".join([", ".join(places[:-1]), places[-1]] if len(places) > 1 else places)

    def nearest(self, key: str) -> str | None:
        """Return the key of any table that is most like `key`."""
        return nearest(key, list(self._places))


def _wrong_in_table(
    given: Mapping[str, Any],
    struct: Struct,
    default: msgspec.Struct | None,
    path: Path,
    to_run: bool,
    places: Places,
    types: Mapping[str, Struct] | None = None,
) -> Iterator[Problem]:
    """Yield what is wrong with a table of a known struct; `types` are all types of the table."""
    settings = settings_of(struct)
    for key, value in given.items():
        if key == TAG and tag_of(struct):
            continue
        here = (*path, key)
        if key not in settings:
            siblings = {tag: other for tag, other in (types or {}).items() if other is not struct}
            yield Problem(here, _unknown(key, struct, siblings, places), value)
            continue
        kind = settings[key].kind
        if kind.base == "names":
            if not isinstance(value, Mapping):
                yield Problem(here, f"expected a table, [{shown_key(here)}]", value)
            continue
        below = getattr(default, key, None) if default is not None else settings[key].default
        if value is None and kind.optional:
            continue
        if kind.base == "table":
            yield from _wrong_in_typed_table(value, kind, below, here, to_run, places)
        elif kind.base == "tables":
            yield from _wrong_in_tables(value, kind, here, to_run, places)
        else:
            reason = wrong(value, kind, to_run=to_run)
            if reason:
                yield Problem(here, reason, value)
    if default is None:
        for key, setting in settings.items():
            if setting.required and key not in given:
                yield Problem(path, f"the key `{key}` is missing: {setting.doc or setting.kind}")


def _wrong_in_typed_table(
    value: object, kind: Kind, default: object, path: Path, to_run: bool, places: Places
) -> Iterator[Problem]:
    structs = kind.structs or {}
    typed = "" not in structs
    if not isinstance(value, Mapping):
        tags = [tag for tag in structs if tag]
        reason = f"expected a table, [{shown_key(path)}]" + (f", or one of {quoted(tags)}" if tags else "")
        yield Problem(path, reason, value)
        return
    below = default if isinstance(default, msgspec.Struct) else None
    tag = value.get(TAG, tag_of(below) if below is not None else "") if typed else ""
    if not isinstance(tag, str) or tag not in structs:
        tags = [name for name in structs if name]
        near = nearest(str(tag), tags)
        yield Problem(
            (*path, TAG),
            f"expected one of {quoted(tags)}" + (f'; did you mean "{near}"?' if near else ""),
            tag,
        )
        return
    struct = structs[tag]
    same = below if type(below) is struct else None
    yield from _wrong_in_table(value, struct, same, path, to_run, places, structs)


def _wrong_in_tables(
    value: object, kind: Kind, path: Path, to_run: bool, places: Places
) -> Iterator[Problem]:
    structs = kind.structs or {}
    if not isinstance(value, list | tuple):
        yield Problem(path, f"expected a list of tables, each under [[{shown_key(path)}]]", value)
        return
    for number, item in enumerate(value):
        here = (*path, number)
        if "" not in structs:
            yield from _wrong_in_typed_table(item, kind, None, here, to_run, places)
        elif isinstance(item, Mapping):
            yield from _wrong_in_table(item, structs[""], None, here, to_run, places)
        else:
            yield Problem(here, "expected a table", item)


def wrong(value: object, kind: Kind, *, to_run: bool) -> str:
    """Return what is wrong with the value of a setting that is no table; "" where nothing is."""
    match kind.base:
        case "true or false":
            return "" if isinstance(value, bool) else "expected true or false"
        case "text":
            if not isinstance(value, str):
                return f"expected {kind}, in quotes"
            return "" if re.search(kind.pattern, value) else f"expected {kind}"
        case "choice":
            if isinstance(value, str) and value in kind.choices:
                return ""
            near = nearest(value, kind.choices) if isinstance(value, str) else None
            return f"expected {kind}" + (f'; did you mean "{near}"?' if near else "")
        case "list":
            return _wrong_list(value, kind, to_run)
        case _:
            return _wrong_number(value, kind, to_run)


def _wrong_list(value: object, kind: Kind, to_run: bool) -> str:
    if not isinstance(value, list | tuple) or not (kind.any_length or len(value) == len(kind.items)):
        return f"expected {kind}"
    items = kind.items * len(value) if kind.any_length else kind.items
    reasons = [wrong(item, each, to_run=to_run) for item, each in zip(value, items, strict=True)]
    return next((f"the item {shown(value[i])}: {r}" for i, r in enumerate(reasons) if r), "")


def _wrong_number(value: object, kind: Kind, to_run: bool) -> str:
    if not to_run:
        kind = replace(kind, range=replace(kind.range, usual=None))  # messages name the range that holds here
    whole = kind.base == "whole number"
    if isinstance(value, str):
        return f"expected {kind}, without quotes"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"expected {kind}"
    if isinstance(value, float) and not math.isfinite(value):
        return f"expected {kind}: infinity and NaN are none"
    if whole and isinstance(value, float):
        return f"expected {kind}, without a decimal point"
    if not kind.range.holds(value):
        return f"expected {kind}"
    if to_run and not kind.range.is_usual(value):
        unit = f" {kind.range.unit}" if kind.range.unit else ""
        slip = kind.range.unit == "seconds" and kind.range.is_usual(value / 1000)
        hint = f"; in milliseconds it would be {plain(value / 1000)}" if slip else ""
        return f"{plain(value)}{unit} is a value that nobody means: expected {kind}{hint}"
    return ""


def _unknown(key: str, struct: Struct, siblings: Mapping[str, Struct], places: Places) -> str:
    """Return that a table has no such key, and which may be meant."""
    tag = tag_of(struct)
    own = [*([TAG] if tag else []), *settings_of(struct)]
    table = f'a table of type "{tag}"' if tag else "this table"
    text = f"there is no such key in {table}"
    others = {name: list(settings_of(other)) for name, other in siblings.items()}
    with_key = [name for name, keys in others.items() if key in keys]
    if with_key:
        types = f"type {quoted(with_key)}" if len(with_key) == 1 else f"the types {quoted(with_key)}"
        return f'{text}; `{key}` belongs to {types}: set {TAG} = "{with_key[0]}"'
    near = nearest(key, own)
    if near:
        return f"{text}; did you mean `{near}`?"
    elsewhere = places.of(key)
    if elsewhere:
        return f"{text}; `{key}` belongs to {elsewhere}"
    near = nearest(key, [name for keys in others.values() for name in keys])
    if near:
        of_types = [name for name, keys in others.items() if near in keys]
        return f"{text}; did you mean `{near}`, which belongs to type {quoted(of_types)}?"
    near = places.nearest(key)
    if near:
        return f"{text}; did you mean `{near}`, which belongs to {places.of(near)}?"
    return f"{text}; it has " + (", ".join(own) if own else "no keys")


def _from_struct(text: str, given: Mapping[str, Any]) -> Problem:
    """Return what a struct refused when it was made, with the place as tables are written in a file."""
    reason, _, where = text.partition(" - at `$")
    path: Path = tuple(
        int(part[1:-1]) if part.startswith("[") else part.strip(".`")
        for part in re.findall(r"\.\w+|\[\d+\]", where)
    )
    named = re.search(r"\[([a-z_.]+)\] ([a-z_0-9]+)", reason)
    if named is not None:
        return Problem((*named[1].split("."), named[2]), reason)
    table: Any = given
    for part in path:
        table = table[part] if isinstance(part, int) else table.get(part, {})
    keys = [
        word for word in re.findall(r"[a-z_0-9]+", reason) if isinstance(table, Mapping) and word in table
    ]
    value = table[keys[0]] if keys else None
    return Problem((*path, keys[0]) if keys else path, reason, None if isinstance(value, Mapping) else value)
