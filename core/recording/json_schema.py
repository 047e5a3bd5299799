"""The JSON Schema of one line of a recording, made from the structs that the program itself reads and writes.

It says what a line may hold. That the chain is whole, and in which order lines come, no schema can say:
`recordings/README.md` does.
"""

from collections.abc import Mapping
from inspect import cleandoc
from typing import Any

import msgspec

from core.configuration.catalogue import field_docs
from core.events import (
    FocusLost,
    FocusRegained,
    Input,
    KeyPressed,
    Output,
    QuestionAnswered,
    QuestionPosed,
    TimeGap,
)
from core.recording import version_1
from core.recording.chain import CHAIN_DIGITS
from core.recording.schema import VERSION, End, Header

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_LATER = (TimeGap, FocusLost, FocusRegained, QuestionAnswered, QuestionPosed)
"""Events that version 1 does not have."""
_LATER_FIELDS: dict[type[msgspec.Struct], tuple[str, ...]] = {KeyPressed: ("read_as", "layout")}
_CHAIN = {
    "type": "string",
    "pattern": f"^[0-9a-f]{{{CHAIN_DIGITS}}}$",
    "description": f"First {CHAIN_DIGITS} hex digits of the SHA-256 over all lines so far, each without its chain.",  # noqa: E501
}


def records_of(version: int) -> tuple[type[msgspec.Struct], ...]:
    """Return the structs of the lines of a version of the format, header and end line included.

    Raises:
        ValueError: there is no such version.
    """
    if not 1 <= version <= VERSION:
        raise ValueError(f"there are versions 1 to {VERSION} of the format, not {version}")
    today: tuple[type[msgspec.Struct], ...] = (Header, *Input.__args__, *Output.__args__, End)
    if version == VERSION:
        return today
    before = {_tag(record): record for record in version_1.Changed.__args__}
    return tuple(before.get(_tag(record), record) for record in today if record not in _LATER)


def schema_of(version: int = VERSION) -> dict[str, Any]:
    """Return the JSON Schema of one line of a recording of this version.

    Raises:
        ValueError: there is no such version.
    """
    records = records_of(version)
    _, components = msgspec.json.schema_components(records)
    definitions = {_tag(record): _definition(record, components, version) for record in records}
    return {
        "$schema": DIALECT,
        "title": f"One line of an arl-recording, version {version}",
        "description": "A recording is UTF-8 text, one JSON object per line: a header, events, an end line. "
        "A field that is not required has its default where it is not there.",
        "oneOf": [{"$ref": f"#/$defs/{name}"} for name in definitions],
        "$defs": definitions,
    }


def _definition(record: type[msgspec.Struct], components: Mapping[str, Any], version: int) -> dict[str, Any]:
    found = dict(components[record.__name__])
    docs = field_docs(record)
    properties = {
        name: {**below, "description": docs[name]} if name in docs else dict(below)
        for name, below in found["properties"].items()
        if version > 1 or name not in _LATER_FIELDS.get(record, ())
    }
    if record is Header:
        properties["version"] = {**properties["version"], "const": version}
        found["required"] = [*found["required"], "format", "version"]
    if "description" in found:
        # Python 3.13 takes the indent away, 3.11 does not.
        found["description"] = cleandoc(found["description"])
    found["title"] = _tag(record)
    found["properties"] = {**properties, "chain": _CHAIN}
    found["required"] = [*found["required"], "chain"]
    found["additionalProperties"] = False
    return found


def _tag(record: type[msgspec.Struct]) -> str:
    return str(record.__struct_config__.tag)
