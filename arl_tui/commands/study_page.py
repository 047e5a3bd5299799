"""docs/study.md, made from the structs that are read: `arl study settings > docs/study.md`."""

from collections.abc import Iterator

import msgspec

from arl_tui.commands.protocol import toml_value
from core.configuration.catalogue import TAG, Setting, Struct, settings_of, table_docs, tables_of
from studies.lab.config import Study
from studies.lab.questions import READY, QuestionList

OPENING = """# Every setting of a study

Made from the program by `arl study settings > docs/study.md`; do not edit it. A study is a TOML file, usually
`study.toml`, with its texts in Markdown beside it. `arl study new` copies a ready one to start from; `arl study
check` says what a file will do, and what is missing. A key that a table does not have, and a value that is not
allowed, are refused with file, line and the nearest name.

The tables under `[protocol]` and `[conditions.NAME]` are those of a protocol (docs/protocol.md). A condition holds
only what differs from the base; a table of another `type` than the base's replaces it as a whole.

Each step is a table in the list `steps` of a sitting, and says by its `type` which step it is.
"""  # noqa: E501
QUESTIONS = f"""# Every setting of a questionnaire

A questionnaire is a TOML file beside the study file, or one of the ready ones: {", ".join(READY)}. Each question is a
table under `[[questions]]`.
"""  # noqa: E501


def page() -> str:
    """Return the page, Markdown."""
    return "\n".join([OPENING, *_sections(Study), QUESTIONS, *_sections(QuestionList)]) + "\n"


def _sections(struct: Struct) -> Iterator[str]:
    yield "## The top of the file\n"
    yield from _table(struct)
    seen = set()
    for path, kind in tables_of(struct):
        if path in seen:
            continue
        seen.add(path)
        name = ".".join(path)
        yield f"## {f'[{name}]' if kind.base == 'table' else f'[[{name}]]'}\n"
        for tag, inner in (kind.structs or {}).items():
            if tag:
                yield f'### {TAG} = "{tag}"\n'
            yield f"{table_docs(inner)}\n"
            yield from _table(inner)


def _table(struct: Struct) -> Iterator[str]:
    settings = [one for one in settings_of(struct).values() if one.kind.structs is None]
    if not settings:
        yield "(no keys)\n" if not settings_of(struct) else ""
        return
    yield "| key | values | default | meaning |"
    yield "|---|---|---|---|"
    for setting in settings:
        values = f"{setting.kind}{', or left out' if setting.kind.optional else ''}"
        cells = (f"`{setting.key}`", values, _default(setting), setting.doc)
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
    yield ""


def _default(setting: Setting) -> str:
    if setting.required:
        return "must be given"
    if setting.default is None or setting.default is msgspec.NODEFAULT:
        return "none"
    return f"`{toml_value(msgspec.to_builtins(setting.default))}`"
