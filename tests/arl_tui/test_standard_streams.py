"""Closed input and outputs: nothing fails, and nothing that is printed ends up in a file."""

import os
import subprocess
import sys
import time
import warnings
from pathlib import Path

import pexpect
import pytest

from arl_tui.command_line import NO_FILE
from arl_tui.viewer.workers import Workers

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="shells of Windows close no streams")

CLOSED = ("<&-", ">&-", "2>&-", "<&- >&- 2>&-")
WRITE_AND_PRINT = """
import os, sys
from arl_tui.standard_streams import stand_in_for_closed_ones, why_not_drawable
stand_in_for_closed_ones()
file = open(sys.argv[1], "w")
assert file.fileno() > 2
os.system("echo printed; echo printed >&2; cat")
print("printed")
print("printed", file=sys.stderr)
file.write(why_not_drawable())
"""


def in_shell(arguments: list[str], closed: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {closed}', "sh", sys.executable, *arguments],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        stdin=subprocess.DEVNULL,
    )


@pytest.mark.parametrize("closed", CLOSED)
def test_what_is_printed_does_not_end_up_in_a_file(closed: str, tmp_path: Path) -> None:
    done = in_shell(["-c", WRITE_AND_PRINT, str(tmp_path / "file")], closed)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "file").read_text() == "needs a terminal to draw in and a keyboard"


@pytest.mark.parametrize("closed", ["<&-", "<&- >&- 2>&-"])
def test_a_command_that_needs_a_terminal_says_so(closed: str) -> None:
    done = in_shell(["-m", "arl_tui.cli", "play", "tetris"], closed)
    assert done.returncode == 1
    assert done.stderr in ("", "Error: arl play needs a terminal to draw in and a keyboard; try `arl demo`\n")
    assert done.stderr or "2>&-" in closed


def test_an_error_output_that_goes_elsewhere_is_named_on_the_screen(tmp_path: Path) -> None:
    line = f"exec {sys.executable} -m arl_tui.cli play tetris 2>/dev/null"
    child = pexpect.spawn("sh", ["-c", line], cwd=str(tmp_path), env=os.environ | {"TERM": "xterm"})
    child.expect(pexpect.EOF, timeout=60)
    child.close()
    assert child.exitstatus == 1
    assert b"arl play draws on the error output, which goes elsewhere here: leave out `2>`" in child.before


def test_a_folder_that_is_gone_is_told_in_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    line = f"cd gone && rmdir ../gone && exec {sys.executable} -m arl_tui.cli demo --recordings r"
    done = subprocess.run(
        ["sh", "-c", line], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60,
        stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert done.returncode == 1
    assert "Error: the folder in which this command was started is not there any more" in done.stderr
    assert "Traceback" not in done.stderr


def _noisy(recording: Path, out: Path) -> str:
    os.write(1, b"printed by a library\n")
    warnings.warn_explicit("starts stay slow", UserWarning, NO_FILE, 1)
    return f"{recording.name}, {out.name}"


def test_what_the_viewers_other_process_prints_does_not_stand_on_the_screen(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with Workers(Path("a.jsonl")) as workers:
        working = workers._work(_noisy)
        while not working.done:
            time.sleep(0.01)
        assert working.words == "a.jsonl, 1.thoughts"
    assert workers.said == "printed by a library\nNote: starts stay slow"
    assert capfd.readouterr() == ("", "")
