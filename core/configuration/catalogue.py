"""Every setting of a configuration, read off its structs: key, values, range, default, description.

Error messages, `arl protocol` and docs/protocol.md all go by this, so none of them has to be kept up by hand.
"""

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal

import msgspec
from msgspec import inspect as types

from core.configuration.fields import ALLOWED, CHOICES, RANGE, Range
from core.configuration.open_table import TAG, OpenTable

__all__ = [
    "TAG",
    "Kind",
    "Setting",
    "Struct",
    "field_docs",
    "settings_of",
    "table_docs",
    "tables_of",
    "tag_of",
]

Struct = type[msgspec.Struct]


@dataclass(frozen=True, slots=True)
class Kind:
    """What values a setting takes."""

    base: Literal[
        "whole number", "number", "text", "true or false", "choice", "list", "table", "tables", "names"
    ]
    range: Range = field(default_factory=Range)
    """Of numbers."""
    choices: tuple[str, ...] = ()
    """Of a choice."""
    allowed: str = ""
    """Of a text: which ones there are, in words."""
    pattern: str = ""
    """Of a text: a regular expression that it matches; `allowed` says the same in words."""
    optional: bool = False
    """The setting can be left out even where it has no default value."""
    items: tuple["Kind", ...] = ()
    """Of a list: the kind of each item; of one with any number of items a single kind."""
    any_length: bool = False
    """Of a list: it has any number of items."""
    structs: Mapping[str, Struct] | None = None
    """Of a table, or of tables: the struct of each type; under "" that of a table without types. ("names": a
    table with keys of one's own, which are not checked here.)"""

    def __str__(self) -> str:
        """Return in words which values there are."""
        match self.base:
            case "choice":
                text = "one of " + ", ".join(f'"{choice}"' for choice in self.choices)
            case "whole number" | "number":
                text = f"a {self.base} {self.range}".strip()
            case "text":
                text = f"a text: {self.allowed}" if self.allowed else "a text"
            case "list" if self.any_length:
                text = f"a list, each item {self.items[0]}"
            case "list":
                text = f"a list of {len(self.items)}, each {self.items[0]}"
            case "table" | "tables":
                text = "a table" if self.base == "table" else "a list of tables"
            case "names":
                text = "a table"
            case _:
                text = self.base
        return text


@dataclass(frozen=True, slots=True)
class Setting:
    """One key of a table."""

    key: str
    kind: Kind
    default: object
    required: bool
    """It must be given: there is no default."""
    struct: Struct
    """The table."""
    field: str
    """Name of the attribute."""

    @property
    def doc(self) -> str:
        """What it is, and where its default comes from; one line.

        It is read from the source when it is asked for: a session needs none of them, and reading all takes
        as long as loading the program.
        """
        for base in self.struct.__mro__:
            if issubclass(base, msgspec.Struct) and base is not msgspec.Struct:
                docs = field_docs(base)
                if self.field in docs:
                    return docs[self.field]
        return ""


@cache
def settings_of(struct: Struct) -> dict[str, Setting]:
    """Return the settings of a table by their keys, in order; its `TAG` is not among them."""
    info = types.type_info(struct)
    assert isinstance(info, types.StructType)
    return {
        field.encode_name: Setting(
            field.encode_name, _kind(field.type), field.default, field.required, struct, field.name
        )
        for field in info.fields
    }


def tag_of(struct: Struct | msgspec.Struct) -> str:
    """Return the type that a table's `TAG` names; "" for a table that has none."""
    return str(struct.__struct_config__.tag or "")


def tables_of(struct: Struct, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Kind]]:
    """Yield every table below a struct, whatever its type, with the path to it, in the order of a file."""
    for setting in settings_of(struct).values():
        if setting.kind.structs is not None:
            below = (*path, setting.key)
            yield below, setting.kind
            for inner in setting.kind.structs.values():
                yield from tables_of(inner, below)


def table_docs(struct: Struct) -> str:
    """Return what a table is, in one paragraph."""
    paragraphs = inspect.cleandoc(struct.__doc__ or "").split("\n\n")
    return " ".join(paragraphs[0].split())


@cache
def field_docs(struct: Struct) -> dict[str, str]:
    """Return the string literal below each field of a class, on one line."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(struct))).body[0]
    assert isinstance(tree, ast.ClassDef)
    found = {}
    for each, below in zip(tree.body, tree.body[1:], strict=False):
        if (
            isinstance(each, ast.AnnAssign)
            and isinstance(each.target, ast.Name)
            and isinstance(below, ast.Expr)
            and isinstance(below.value, ast.Constant)
            and isinstance(below.value.value, str)
        ):
            found[each.target.id] = " ".join(below.value.value.split())
    return found


def _kind(kind: types.Type, extra: Mapping[str, Any] | None = None) -> Kind:
    """Return the kind of a field's type; `extra` is what its annotation says
    (`core.configuration.fields`).
    """
    extra = extra or {}
    match kind:
        case types.Metadata():
            return _kind(kind.type, kind.extra)
        case types.BoolType():
            return Kind("true or false")
        case types.IntType() | types.FloatType():
            base: Literal["whole number", "number"]
            base = "whole number" if isinstance(kind, types.IntType) else "number"
            own = Range(ge=kind.ge, gt=kind.gt, le=kind.le, lt=kind.lt)
            return Kind(base, extra.get(RANGE, own))
        case types.StrType() if CHOICES in extra:
            return Kind("choice", choices=extra[CHOICES])
        case types.StrType():
            return Kind("text", allowed=extra.get(ALLOWED, ""), pattern=kind.pattern or "")
        case types.LiteralType():
            return Kind("choice", choices=tuple(str(value) for value in kind.values))
        case types.StructType():
            return Kind("table", structs={tag_of(kind.cls): kind.cls})
        case types.CustomType() if issubclass(kind.cls, OpenTable):
            return Kind("table", structs=kind.cls.structs())
        case types.UnionType():
            return _of_union([part for part in kind.types if not isinstance(part, types.NoneType)], kind)
        case types.DictType():
            return Kind("names")
        case types.TupleType():
            return Kind("list", items=tuple(_kind(item) for item in kind.item_types))
        case types.VarTupleType():
            item = _kind(kind.item_type)
            if item.structs is not None:
                return Kind("tables", structs=item.structs)
            return Kind("list", items=(item,), any_length=True)
        case _:
            raise TypeError(f"a setting cannot be of the type {kind}")


def _of_union(parts: list[types.Type], union: types.UnionType) -> Kind:
    optional = len(parts) < len(union.types)
    kinds = [_kind(part) for part in parts]
    if len(kinds) == 1:
        one = kinds[0]
        return replace(one, optional=optional)
    structs: dict[str, Struct] = {}
    for each in kinds:
        assert each.base == "table", "only tables have types"
        structs |= each.structs or {}
    return Kind("table", optional=optional, structs=structs)
