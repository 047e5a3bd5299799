"""What the documentation says is so: commands and names exist, and pages are linked. Its blocks of code are
the matter of `tests/test_documented_blocks.py`."""

import importlib
import re
import shlex
from pathlib import Path

import click
import pytest

from arl_tui.cli import main
from tests.documented import BLOCKS, DOCS, FENCE, PAGES, REPOSITORY

# --- commands exist -----------------------------------------------------------------------------------------


def command_lines() -> list[tuple[str, str]]:
    """Return every line that begins with arl, of blocks and of quoted code, with where it stands."""
    found = [
        (block.where, line.split(" #")[0].strip())
        for block in BLOCKS
        if block.language == "sh"
        for line in block.text.replace("\\\n", " ").splitlines()
    ]
    for page in PAGES:
        text = FENCE.sub("", page.read_text(encoding="utf-8"))
        if "results" not in page.parts:
            found += [(page.name, quoted.replace("\n", " ")) for quoted in re.findall(r"`(arl [^`]*)`", text)]
    lines = [(where, line.split("&&")[-1].strip()) for where, line in found]
    return sorted({(where, re.sub(r"^\S*/arl ", "arl ", line)) for where, line in lines if "arl " in line})


COMMANDS = [(where, line) for where, line in command_lines() if line.startswith("arl ")]


def test_there_are_commands_to_check():
    assert len(COMMANDS) >= 40


@pytest.mark.parametrize(("where", "line"), COMMANDS)
def test_a_command_and_its_options_exist(where: str, line: str):
    words = [word for word in shlex.split(re.split(r"[>|]", line)[0])[1:] if word != "..."]
    command: click.Command = main
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        name = words.pop(0)
        if name.isupper() or name in ("*", "study|check"):  # a placeholder
            return
        commands = command.list_commands(click.Context(command))
        for one in name.split("|"):
            assert one in commands, f"{where}: {line}: no command {one}"
        found = command.get_command(click.Context(command), name.split("|")[0])
        assert found is not None
        command = found
    known = {
        option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)
    }
    known |= {"--help", "--version"}
    asked = {word.split("=")[0] for word in words if re.match(r"--[a-z]", word)}
    assert asked <= known, f"{where}: {line}"


# --- names, links, indexes ----------------------------------------------------------------------------------


def glossary_names() -> list[str]:
    rows = [
        line
        for line in (DOCS / "glossary.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("| ")
    ]
    return [name for row in rows for name in re.findall(r"`((?:core|studies|arl_tui)\.[\w.]+)`", row)]


def resolve(name: str) -> object:
    """Return what a dotted name stands for; fields of records count."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for part in parts[length:]:
            if part in getattr(found, "__annotations__", {}) and not hasattr(found, part):
                found = found.__annotations__[part]
            else:
                found = getattr(found, part)
        return found
    raise ModuleNotFoundError(name)


def test_the_glossary_has_a_name_in_every_row():
    text = (DOCS / "glossary.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ") and "| name in" not in line]
    assert len(rows) >= 60
    assert [row for row in rows if not re.search(r"`(core|studies|arl_tui)\.", row)] == []


@pytest.mark.parametrize("name", sorted(set(glossary_names())))
def test_a_name_of_the_glossary_exists(name: str):
    assert resolve(name) is not None


@pytest.mark.parametrize("name", ["architecture.md", "extending.md"])
def test_files_and_names_that_a_page_for_developers_gives_exist(name: str):
    text = (DOCS / name).read_text(encoding="utf-8")
    files = set(re.findall(r"`((?:core|studies|arl_tui|tests|examples)/[\w./]+)`", text))
    missing = [file for file in files if "NAME" not in file and not (REPOSITORY / file).exists()]
    assert sorted(missing) == ["core/combination/trust/recent.py"] * (name == "extending.md")
    for dotted in set(re.findall(r"\b((?:core|studies|arl_tui)(?:\.\w+)+)\b", text)):
        assert resolve(dotted) is not None, dotted


def test_the_rooms_of_the_architecture_are_the_folders_there_are():
    rooms = (DOCS / "architecture.md").read_text(encoding="utf-8").split("```")[1]
    folders = {
        path.parent.name
        for top in ("core", "studies", "arl_tui")
        for path in (REPOSITORY / top).glob("*/__init__.py")
    }
    assert sorted(folder for folder in folders if f"{folder}/" not in rooms) == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_links_to_files_lead_somewhere(page: Path):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    links = re.findall(r"\]\(([^)\s]+)\)", text)
    for link in links:
        if re.match(r"[a-z]+:", link) or link.startswith("#"):
            continue
        target = (page.parent / link.split("#")[0]).resolve()
        assert target.exists(), f"{page.name}: {link}"


def test_every_page_is_reached_from_an_index():
    linked = "".join(
        page.read_text(encoding="utf-8") for page in PAGES if page.name in ("index.md", "README.md")
    )
    missing = [
        str(page.relative_to(DOCS))
        for page in PAGES[1:]
        if page.name not in linked and page.name != "index.md"
    ]
    assert missing == []


@pytest.mark.parametrize("page", sorted((DOCS / "decisions").glob("*.md")), ids=lambda page: page.stem)
def test_a_decision_begins_with_the_choice(page: Path):
    if page.name == "index.md":
        return
    _title, rest = page.read_text(encoding="utf-8").split("\n", 1)
    assert rest.lstrip().startswith("**Choice")


@pytest.mark.parametrize("page", sorted((DOCS / "results").glob("*.md")), ids=lambda page: page.stem)
def test_a_result_begins_with_its_answer_in_three_sentences(page: Path):
    if page.name == "index.md":
        return
    _title, rest = page.read_text(encoding="utf-8").split("\n", 1)
    first = rest.lstrip().split("\n\n")[0]
    assert first.startswith("**In short.** ")
    assert (
        len(re.findall(r"[.:!?](?=\s|$)", re.sub(r"\d\.\d|e\.g\.|Eq\.|Eqs\.|Fig\.|Figs\.", "", first))) >= 4
    )


@pytest.mark.parametrize("name", ["fig5", "fig6", "fig7", "credit"])
def test_the_answer_of_a_page_is_that_of_its_claims(name: str):
    from studies.experiments.page import in_short

    text = (DOCS / "results" / f"{name}.md").read_text(encoding="utf-8")
    table = text.split("| held | ratio |", 1)[1].split("\n\n", 1)[0].splitlines()[2:]
    claims = [tuple(cell.strip() for cell in row.strip("|").split(" | ")) for row in table]
    assert all(len(claim) == 3 for claim in claims)
    assert in_short([(words, held, ratio) for words, held, ratio in claims]) in text


def test_the_readme_is_one_screen_to_the_first_success():
    text = FENCE.sub("", (REPOSITORY / "README.md").read_text(encoding="utf-8"))
    words = re.sub(r"\(([^)]*)\)|[|`*#\[\]>-]", " ", text).split()
    assert len(words) <= 900
    for found in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text):
        assert (REPOSITORY / found).stat().st_size < 2_000_000, found
