"""What may not be imported where: asked of a fresh interpreter, because this one has imported everything."""

import pkgutil
import subprocess
import sys

import click
import pytest

import arl_tui
import core
import studies
from arl_tui.cli import main
from tests.arl_tui.command_tree import members

SCREEN_PROCESS = "numba", "scipy.stats", "matplotlib"
HEADLESS = "textual", "rich", "click"


def loaded_after(statement: str) -> set[str]:
    """Return the names of the modules that are loaded after `statement` in a new interpreter."""
    script = f"{statement}\nimport sys\nprint(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def modules_of(package: object) -> list[str]:
    path, name = package.__path__, package.__name__  # type: ignore[attr-defined]
    return [name, *(module.name for module in pkgutil.walk_packages(path, f"{name}."))]


@pytest.mark.parametrize("package", [core, studies], ids=["core", "studies"])
def test_headless_packages_load_nothing_of_the_terminal(package: object) -> None:
    loaded = loaded_after("import " + ", ".join(modules_of(package)))
    assert not loaded & set(HEADLESS)


def test_the_screens_process_never_loads_the_compiler_or_the_statistics() -> None:
    loaded = loaded_after("import " + ", ".join(modules_of(arl_tui)))
    assert not loaded & set(SCREEN_PROCESS)


def commands(group: click.Group, path: tuple[str, ...] = ()) -> list[list[str]]:
    """Return the words of every command and group, the empty list first."""
    found = [list(path)]
    for name, command in members(group):
        words = (*path, name)
        found += commands(command, words) if isinstance(command, click.Group) else [list(words)]
    return found


def test_no_commands_help_loads_the_screen_or_arrays() -> None:
    asked = commands(main)
    assert ["import", "tamer-log"] in asked
    assert ["warm-up"] in asked
    loaded = loaded_after(
        "from click.testing import CliRunner\nfrom arl_tui.cli import main\n"
        f"for words in {asked!r}:\n    assert CliRunner().invoke(main, [*words, '--help']).exit_code == 0, "
        f"words"
    )
    assert not loaded & {
        "textual",
        "rich",
        "numpy",
        "scipy",
        "numba",
        "matplotlib",
        "msgspec",
        "multiprocessing",
    }


UNTIL_THE_FIRST_PAGE = """
from pathlib import Path

from arl_tui.commands.check_protocol import tell_start
from arl_tui.commands.credit import settle_credit
from arl_tui.commands.play import read_protocol
import arl_tui.app.session_setup, arl_tui.session_app, arl_tui.worker

for game in ("tetris", "keepaway"):
    protocol, source = settle_credit(read_protocol(None, game), None, Path("none"), "P01")
    tell_start(protocol, source, Path("none"), "P01")
"""
"""What `arl play` does before its first page is on screen: what is printed before says which code is
compiled, and starts no compiler to find out."""


def test_the_first_picture_waits_for_no_arrays() -> None:
    loaded = loaded_after(UNTIL_THE_FIRST_PAGE)
    assert "arl_tui.commands.check_protocol" in loaded
    assert not loaded & {"numpy", "scipy", "numba", "matplotlib", "textual_plot"}
