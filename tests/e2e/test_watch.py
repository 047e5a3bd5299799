"""`arl watch` in a pseudo-terminal."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.terminal import Terminal

pytestmark = pytest.mark.jit


def test_it_plays_answers_keys_and_ends_cleanly(tmp_path: Path) -> None:
    options = ("--policy", "hold", "--vision", "exact", "--seed", "3", "--speed", "4", "--detail", "ascii")
    with Terminal("watch", "keepaway", *options, cwd=tmp_path) as terminal:
        terminal.wait_for("has the ball -")
        assert "always hold" in terminal.text
        assert all(name in terminal.text for name in ("K1", "K2", "K3", "T1", "T2"))
        terminal.press("p")
        terminal.wait_for("PAUSED")
        terminal.press("n")
        terminal.wait_for("Episode 2")
        terminal.press("-")
        terminal.wait_for("x2")
        terminal.press("d")
        terminal.wait_for("┌─ Episode 2")
        terminal.press("p")
        terminal.wait_for("Finished 1")
        terminal.press("q")
        assert terminal.wait_for_exit() == 0
        assert "1 episode: mean" in terminal.text


def test_a_window_that_is_too_small_says_so_and_comes_back(tmp_path: Path) -> None:
    options = ("--policy", "hold", "--vision", "exact", "--seed", "3", "--detail", "ascii")
    with Terminal("watch", "keepaway", *options, cwd=tmp_path) as terminal:
        terminal.wait_for("has the ball -")
        terminal.resize(60, 20)
        terminal.wait_for("This window is too small")
        terminal.resize(120, 40)
        terminal.wait_for("has the ball -")
        terminal.press("q")
        assert terminal.wait_for_exit() == 0


@pytest.mark.thorough
def test_it_leaves_after_the_episodes_asked_for(tmp_path: Path) -> None:
    options = ("--policy", "random", "--vision", "exact", "--seed", "3", "--speed", "20", "--episodes", "1")
    with Terminal("watch", "keepaway", *options, cwd=tmp_path) as terminal:
        assert terminal.wait_for_exit() == 0
        assert "1 episode: mean" in terminal.text


def test_a_policy_that_is_neither_known_nor_a_file_is_named(tmp_path: Path) -> None:
    with Terminal("watch", "--policy", "best", cwd=tmp_path) as terminal:
        assert terminal.wait_for_exit() == 2
        assert "'best' is neither one of hand, random" in terminal.text


def test_without_a_terminal_it_says_so(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "arl_tui.cli", "watch"],
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        check=False,
    )
    assert done.returncode == 1
    assert "needs a terminal" in done.stderr
