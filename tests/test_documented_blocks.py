"""Every block of code of README and docs runs, is checked by what reads it, or is marked as output:
`tests/documented.py` explains the marks.
"""

import importlib.metadata
import json
import os
import re
import shlex
import socket
import subprocess
import sys
import textwrap
import time
import tomllib
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from arl_tui.settings import read_settings
from core import protocol_from
from studies.lab.read import load_study
from studies.lab.ready_studies import copy_ready_study
from tests.data_folder import data_root
from tests.documented import (
    BLOCKS,
    ELSEWHERE,
    MARKS,
    REPOSITORY,
    Block,
    blocks_of,
    extras_installed,
    named_tests,
    pairs,
)
from tests.e2e.terminal import PATIENCE_S, Terminal

KEYS = {"Enter": "\r", "Space": " ", "Escape": "\x1b"}
MARKS_OF = {
    "sh": {"first", "then", "with", "needs data", "in a terminal", "in the background until", *ELSEWHERE},
    "python": {"first", "then", "with", "saved as", "a piece of", *ELSEWHERE},
    "toml": {"first", "then", "saved as", "settings of", *ELSEWHERE},
    "r": {"a piece of"},
    "text": {"printed by"},
    "json": set[str](),
}
"""The languages that are known, each with the marks that mean something there."""


def environment(folder: Path) -> dict[str, str]:
    """Return what the environment of a reader says who keeps everything in one folder."""
    return {
        "ARL_HOME": str(folder),
        "HOME": str(folder),  # a key of a page is made there
        "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", str(Path.home() / ".cache")),  # of kernels
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        "PYTHONPATH": os.pathsep.join([str(REPOSITORY), str(folder)]),
        "ARL_DATA": str(data_root()),
        "REPOSITORY": str(REPOSITORY),
    }


def run(command: Sequence[str], folder: Path) -> str:
    """Run a command that must succeed; return what it prints."""
    done = subprocess.run(
        command,
        cwd=folder,
        env=os.environ | environment(folder),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command[-1]}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def in_shell(commands: str) -> list[str]:
    return ["bash", "-euo", "pipefail", "-c", commands]


# --- a page -------------------------------------------------------------------------------------------------


class Reader:
    """Works through a page in a folder, block by block."""

    def __init__(self, folder: Path, left_running: ExitStack) -> None:
        self.skipped: list[str] = []
        """Why blocks were left out."""
        self._folder = folder
        self._left_running = left_running
        self._printed = ""
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self._port = str(free.getsockname()[1])

    def read(self, block: Block) -> None:
        """Do what the page says."""
        data = block.mark("needs data")
        if data and not (data_root() / data).exists():
            self.skipped.append(f"{block.where}: no {data} at {data_root()} (ARL_DATA)")
        elif not (block.elsewhere or block.mark("a piece of")):
            self._shell(block.mark("first"))
            self._do(block)
            self._shell(block.mark("then"))

    def _shell(self, commands: str) -> str:
        return run(in_shell(commands), self._folder) if commands else ""

    def _do(self, block: Block) -> None:
        commands = block.commands.replace("FREE_PORT", self._port)
        if block.mark("saved as"):
            file = self._folder / block.mark("saved as")
            file.parent.mkdir(exist_ok=True)
            file.write_text(block.text, encoding="utf-8")
        elif block.mark("settings of") == "a package":
            install_package_of_mine(block.text, self._folder)
        elif block.mark("printed by"):
            self._compare(block)
        elif block.mark("in a terminal"):
            type_in_a_terminal(commands, pairs(block.mark("in a terminal"), " > "), self._folder)
        elif block.mark("in the background until"):
            until = block.mark("in the background until").replace("FREE_PORT", self._port)
            for line in commands.splitlines():
                self._leave_running(line, until)
        elif block.language == "sh":
            self._printed = self._shell(without_installing(commands))
        elif block.language == "python":
            self._printed = run([sys.executable, "-c", commands], self._folder)

    def _compare(self, block: Block) -> None:
        source = block.mark("printed by")
        printed = self._printed if source == "the block before" else self._shell(source)
        missing = [line for line in block.text.splitlines() if line.strip() not in printed]
        assert missing == [], f"{block.where} is not what is printed:\n{printed}"

    def _leave_running(self, line: str, until: str) -> None:
        log = self._folder / "background.log"
        with log.open("w") as output:
            program = subprocess.Popen(
                shlex.split(line),
                cwd=self._folder,
                env=os.environ | environment(self._folder),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        self._left_running.callback(program.wait)
        self._left_running.callback(program.terminate)
        end = time.monotonic() + PATIENCE_S
        while until not in log.read_text():
            assert program.poll() is None, log.read_text()
            assert time.monotonic() < end, log.read_text()
            time.sleep(0.05)


def type_in_a_terminal(commands: str, steps: Sequence[tuple[str, str]], folder: Path) -> None:
    """Type commands at a shell; wait for each text and press its keys."""
    with Terminal(cwd=folder, exported=environment(folder), program=in_shell(commands)) as terminal:
        for seen, keys in steps:
            terminal.wait_for_words(seen)
            terminal.press("".join(KEYS.get(key, key) for key in keys.split(" ")))
        assert terminal.wait_for_exit() == 0, terminal.text


def without_installing(commands: str) -> str:
    """Leave out the lines that install from the network, and see that what they name is there."""
    kept = []
    for line in commands.splitlines(keepends=True):
        if line.startswith("pip install "):
            for asked in shlex.split(line, comments=True)[2:]:
                is_installed(asked)
        else:
            kept.append(line)
    return "".join(kept)


def is_installed(asked: str) -> None:
    """See that a requirement of this program is one, and that its extras are installed here."""
    wanted = Requirement(asked)
    assert wanted.name == "arl-tui", asked
    offered = importlib.metadata.metadata("arl-tui").get_all("Provides-Extra") or []
    assert wanted.extras <= set(offered), f"{asked}: the extras are {offered}"
    for text in importlib.metadata.requires("arl-tui") or []:
        needed = Requirement(text)
        if needed.marker and any(needed.marker.evaluate({"extra": extra}) for extra in wanted.extras):
            assert needed.specifier.contains(importlib.metadata.version(needed.name)), text


def install_package_of_mine(project: str, folder: Path) -> None:
    """Install the package `our_package`, whose pyproject.toml says this, as its metadata alone."""
    content = tomllib.loads(project)
    assert list(content) == ["project"], content
    assert list(content["project"]) == ["entry-points"], content
    groups = content["project"]["entry-points"]
    ours = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
    assert set(groups) <= set(ours["project"]["entry-points"]), "nothing reads this group"
    metadata = folder / "our_package-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: our-package\nVersion: 1.0\n")
    lines = [
        line
        for group, points in groups.items()
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in points.items()))
    ]
    (metadata / "entry_points.txt").write_text("\n".join(lines) + "\n")


READ = sorted(
    {
        block.page
        for block in BLOCKS
        if (block.language in ("python", "sh") or block.marks)
        and not (block.elsewhere or block.mark("a piece of"))
    }
)


@pytest.mark.thorough
@pytest.mark.jit
@pytest.mark.parametrize("page", READ, ids=lambda page: str(page.relative_to(REPOSITORY)))
def test_the_blocks_of_a_page_run_in_order(page: Path, tmp_path: Path, compiled: None) -> None:
    with ExitStack() as left_running:
        reader = Reader(tmp_path, left_running)
        for block in BLOCKS:
            if block.page == page:
                reader.read(block)
    if reader.skipped:
        pytest.skip("; ".join(reader.skipped))


# --- what is not run ----------------------------------------------------------------------------------------


def test_every_block_names_its_language_and_has_only_marks_that_mean_something() -> None:
    assert set().union(*MARKS_OF.values()) == MARKS
    for block in BLOCKS:
        if block.language.startswith("{"):  # a directive of the site
            continue
        assert block.language in MARKS_OF, f"{block.where}: write one of {sorted(MARKS_OF)} after the fence"
        names = [name for name, _ in block.marks]
        assert set(names) <= MARKS_OF[block.language], block.where
        assert len(names) == len(set(names)), block.where
        assert all(value for _, value in block.marks), block.where


def test_what_a_mark_replaces_is_there_and_each_step_in_a_terminal_has_keys() -> None:
    for block in BLOCKS:
        assert block.commands
        assert all(keys for _, keys in pairs(block.mark("in a terminal"), " > ")), block.where


def test_marks_are_the_comments_right_before_a_block(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- of the page -->\nText.\n\n1. Item\n\n   <!-- first: a\n     b -->\n"
        "   <!-- with: 120 = 1; CODE = P1 -->\n   ```sh\n   arl --n 120 CODE\n     more\n   ```\n\n"
        "```text\nx\n```\n"
    )
    one, other = blocks_of(page)
    assert one.marks == (("first", "a b"), ("with", "120 = 1; CODE = P1"))
    assert one.commands == "arl --n 1 P1\n  more\n"
    assert (other.language, other.text, other.marks) == ("text", "x\n", ())
    with pytest.raises(AssertionError, match="no 'CODE' to replace"):
        _ = Block(REPOSITORY / "README.md", 1, "sh", "arl", (("with", "CODE = P1"),)).commands


def test_output_holds_no_commands() -> None:
    hidden = [
        b.where for b in BLOCKS if b.language == "text" and re.search(r"^(\$ |arl )", b.text, re.MULTILINE)
    ]
    assert hidden == [], "commands are blocks of `sh`"


def test_a_block_that_is_left_to_another_test_names_it_and_that_test_reads_the_page() -> None:
    left = [block for block in BLOCKS if block.elsewhere]
    assert len([block for block in left if block.mark("not run here")]) <= 1
    for block in left:
        files = named_tests(block.mark("run by") or block.mark("not run here"))
        assert files, f"{block.where}: name the test"
        for file in files:
            assert block.page.name in file.read_text(encoding="utf-8"), f"{block.where}: {file}"


def test_a_piece_of_a_file_is_in_it_word_for_word_and_a_test_runs_the_file() -> None:
    pieces = [block for block in BLOCKS if block.mark("a piece of")]
    assert len(pieces) >= 6
    for block in pieces:
        name, _, test = block.mark("a piece of").partition("; run by ")
        source = one_empty_line((REPOSITORY / name).read_text(encoding="utf-8"))
        piece = one_empty_line(textwrap.dedent(block.text)).strip("\n")
        indented = [textwrap.indent(piece, " " * depth) for depth in (0, 4, 8)]
        assert any(f"\n{text}\n" in f"\n{source}" for text in indented), f"{block.where}: {name}"
        if test == "this page":
            others = [other for other in BLOCKS if other.page == block.page and other != block]
            assert any(other.language == "sh" and Path(name).name in other.text for other in others), (
                block.where
            )
        elif test == Path(__file__).relative_to(REPOSITORY).as_posix():
            assert REPOSITORY / name in EXAMPLES, block.where
        else:
            (file,) = named_tests(test)
            assert Path(name).stem in file.read_text(encoding="utf-8"), f"{block.where}: {test}"


def test_what_a_page_says_to_install_exists() -> None:
    assert len(extras_installed()) >= 4
    for requirement in extras_installed():
        is_installed(requirement)


def one_empty_line(text: str) -> str:
    """Return a text with one empty line where it has several: methods have fewer than functions."""
    return re.sub(r"\n{3,}", "\n\n", text)


# --- settings and output ------------------------------------------------------------------------------------


def blocks_in(language: str) -> list[object]:
    return [pytest.param(block, id=block.where) for block in BLOCKS if block.language == language]


@pytest.mark.parametrize("block", blocks_in("toml"))
def test_settings_are_read_by_what_they_are_for(block: Block, tmp_path: Path) -> None:
    what = block.mark("settings of")
    if what == "a study":
        copy_ready_study("demo", tmp_path)
        study = tmp_path / "study.toml"
        study.write_text(study.read_text(encoding="utf-8") + "\n" + block.text, encoding="utf-8")
        assert load_study(study)
    elif what == "this computer":
        (tmp_path / "settings.toml").write_text(block.text, encoding="utf-8")
        assert read_settings(tmp_path / "settings.toml").changed_keys
    elif what == "a package":
        install_package_of_mine(block.text, tmp_path)
    elif not block.elsewhere:
        assert not what, f"{block.where}: of a study, this computer, or a package?"
        assert protocol_from(tomllib.loads(block.text))


@pytest.mark.parametrize("block", blocks_in("json"))
def test_json_can_be_read(block: Block) -> None:
    assert json.loads(block.text)


# --- examples -----------------------------------------------------------------------------------------------

EXAMPLES = sorted((REPOSITORY / "examples").glob("*.py"))


def test_there_are_six_examples() -> None:
    assert len(EXAMPLES) == 6


@pytest.mark.thorough
@pytest.mark.jit
@pytest.mark.parametrize("program", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(program: Path, tmp_path: Path) -> None:
    run([sys.executable, str(program)], tmp_path)
