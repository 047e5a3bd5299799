"""docs/protocol.md, made from the structs that are read: `arl protocol --markdown > docs/protocol.md`."""

import dataclasses
from collections.abc import Iterator

import msgspec

from arl_tui.command_line import say
from arl_tui.commands.protocol import toml_value
from core.configuration.catalogue import TAG, Kind, Setting, Struct, settings_of, table_docs, tables_of
from core.session.effects import uses
from core.session.protocol import DEFAULTS, Protocol

OPENING = """# Every setting of a protocol

Made from the program by `arl protocol --markdown > docs/protocol.md`; do not edit it. A protocol is a TOML
file for `arl play --protocol FILE`. What a file leaves out has the default of its game, so an empty file is a
protocol. `arl protocol tetris` and `arl protocol keepaway` print complete files to start from; `arl protocol
--check FILE` says what a file will do. A key that a table does not have, a value out of range, and a value
that nobody means (a delay of minutes) are refused with file, line and what is allowed. So is a setting that
has no effect in the protocol; one that has none in a live session is named before it starts. A table with
types is chosen by its key `type`; a type alone, as in `scheme = "annealed"` under `[agent]`, stands for the
table of that type with its defaults.

The wider range holds for headers of recordings: what was once run can always be replayed.
"""


def print_page() -> None:
    """Print the page."""
    say(page(), nl=False)


def page() -> str:
    """Return the page, Markdown."""
    return "\n".join([OPENING, *_sections(), *_uses()]) + "\n"


def _sections() -> Iterator[str]:
    yield "## The top of the file\n"
    yield from _table(Protocol, DEFAULTS["tetris"], DEFAULTS["keepaway"])
    seen = set()
    for path, kind in tables_of(Protocol):
        if path in seen:
            continue
        seen.add(path)
        heading = f"[{'.'.join(path)}]" if kind.base == "table" else f"[[{'.'.join(path)}]]"
        yield f"## {heading}\n"
        for tag, struct in (kind.structs or {}).items():
            if tag:
                yield f'### {TAG} = "{tag}"\n'
            yield f"{table_docs(struct)}\n"
            defaults = [_at(DEFAULTS[game], path) for game in ("tetris", "keepaway")]
            yield from _table(struct, *defaults)


def _at(protocol: Protocol, path: tuple[str, ...]) -> object:
    found: object = protocol
    for key in path:
        found = getattr(found, key, None)
    return found


def _table(struct: Struct, tetris: object, keepaway: object) -> Iterator[str]:
    settings = [s for s in settings_of(struct).values() if s.kind.base != "table"]
    if not settings:
        yield "(no keys)\n" if not settings_of(struct) else ""
        return
    yield "| key | values | default | meaning |"
    yield "|---|---|---|---|"
    for setting in settings:
        # Each game's own default, where its default protocol has a table of this type.
        ours = [getattr(each, setting.key) for each in (tetris, keepaway) if isinstance(each, struct)]
        cells = (
            f"`{setting.key}`",
            _values(setting.kind),
            "must be given" if setting.required else _defaults(ours or [setting.default]),
            _cell(setting),
        )
        yield f"| {' | '.join(cells)} |"
    yield ""


def _values(kind: Kind) -> str:
    text = str(kind)
    wide = dataclasses.replace(kind.range, usual=None)
    if (
        kind.base in ("number", "whole number")
        and kind.range.usual is not None
        and str(wide) != str(kind.range)
    ):
        text += f" (recordings: {wide})"
    return text.replace("|", "\\|") + (", or left out" if kind.optional else "")


def _defaults(values: list[object]) -> str:
    shown = ["none" if value is None else f"`{toml_value(msgspec.to_builtins(value))}`" for value in values]
    return shown[0] if shown[0] == shown[-1] else f"{shown[0]}; Keepaway {shown[-1]}"


def _cell(setting: Setting) -> str:
    return setting.doc.replace("|", "\\|")


def _uses() -> Iterator[str]:
    yield "## Which settings have an effect where\n"
    yield "All others have one wherever their table is used. Refused means: when the file is read.\n"
    yield "| settings | have an effect | otherwise |"
    yield "|---|---|---|"
    for use in uses():
        names = ", ".join(f"`{name}`" for name in use.settings)
        yield f"| {names} | {use.where} | {'refused' if use.refused else 'named before the start'} |"
