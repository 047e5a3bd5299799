"""`arl watch FILE` in a pseudo-terminal: scrub, play, step, mouse."""

import re
import shutil
from pathlib import Path

import pytest

from tests.e2e.terminal import Terminal
from tests.studies.session_view.made import KEEPAWAY, TETRIS, large

pytestmark = pytest.mark.jit


def test_a_session_is_scrubbed_stepped_and_played(tmp_path: Path) -> None:
    path = shutil.copy(TETRIS, tmp_path / "session.jsonl")
    with Terminal("watch", str(path), cwd=tmp_path) as terminal:
        terminal.wait_for("paused  0:00.0 of 0:46.3")
        terminal.wait_for("exact replay: 69 outputs equal", "R alone")
        terminal.press("\x1b[C\x1b[C")  # two steps
        terminal.wait_for("step 2")
        terminal.press("\x1b[6~\x1b[6~\x1b[6~")  # three times page down: 30 hundredths of the session
        terminal.wait_for("paused  0:16.1")
        terminal.press("\x1b[5~")
        terminal.wait_for("paused  0:11.5")
        terminal.press("]")
        terminal.wait_for("Press 7 of 24", "Press 8 of 24")
        terminal.press("++ ")
        terminal.wait_for("playing")
        terminal.press(" ")
        terminal.wait_for("paused")
        # A click in the middle of the timeline: it begins at column 24 with labels of 8.
        terminal.press("\x1b[<0;56;4M\x1b[<0;56;4m")
        terminal.wait_for("0:22", "0:23", "0:24")
        terminal.press("q")
        assert terminal.wait_for_exit() == 0
        assert re.search(r"Left at 0:2\d", terminal.text)
    assert (tmp_path / "session.jsonl.index").exists()


def test_keepaway_and_a_what_if(tmp_path: Path) -> None:
    path = shutil.copy(KEEPAWAY, tmp_path / "session.jsonl")
    with Terminal(
        "watch", str(path), "--credit", "previous", "--at", "23", cwd=tmp_path, columns=120, lines=40
    ) as terminal:
        terminal.wait_for("paused  0:23.0")
        terminal.wait_for("What-if previous")
        terminal.wait_for("decisions differ")
        terminal.resize(80, 24)
        terminal.wait_for("Game 2", "Game 3")
        terminal.press("q")
        assert terminal.wait_for_exit() == 0


@pytest.mark.slow
def test_a_million_events_are_on_screen_in_seconds_and_whole_soon_after(tmp_path: Path) -> None:
    path = large(tmp_path / "large.jsonl")
    with Terminal("watch", str(path), cwd=tmp_path) as terminal:
        terminal.wait_for("reading the rest: ")
        terminal.press("\x1b[C\x1b[C")  # it can be looked through meanwhile
        terminal.wait_for("step 2")
        terminal.wait_for("/6600", patience_s=120.0)
        terminal.press("\x1b[F")
        terminal.wait_for("game 6600/6600")
        terminal.press("q")
        assert terminal.wait_for_exit() == 0


@pytest.mark.slow
def test_damage_far_behind_the_first_part_is_named(tmp_path: Path) -> None:
    path = large(tmp_path / "large.jsonl")
    content = path.read_bytes()
    at = len(content) - 100_000
    path.write_bytes(content[:at] + content[at:].replace(b'"key":"j"', b'"key":"f"', 1))
    with Terminal("watch", str(path), cwd=tmp_path) as terminal:
        terminal.wait_for("reading the rest: ")
        assert terminal.wait_for_exit() == 1
        assert "chain does not follow" in " ".join(terminal.text.split())
