"""The window of a real terminal, whatever the environment says of it."""

import time
from pathlib import Path

import pytest

from tests.e2e.terminal import PATIENCE_S, Terminal


@pytest.mark.parametrize("exported", [{}, {"COLUMNS": "80", "LINES": "24"}, {"COLUMNS": "200"}], ids=str)
def test_the_picture_follows_the_window(exported: dict[str, str], tmp_path: Path) -> None:
    with Terminal("practice", "--seed", "3", cwd=tmp_path, exported=exported) as terminal:
        terminal.wait_for("to leave")
        terminal.press(" ")
        terminal.wait_for("q stop")
        before = place_of("q stop", terminal)
        terminal.resize(120, 40)
        # The picture stands in the middle: half of 40 columns and of 16 lines.
        after = (before[0] + 8, before[1] + 20)
        end = time.monotonic() + PATIENCE_S
        while place_of("q stop", terminal) != after and time.monotonic() < end:
            terminal.pump()
        assert place_of("q stop", terminal) == after, terminal.text
        terminal.press("q")
        assert terminal.wait_for_exit() == 0


def place_of(text: str, terminal: Terminal) -> tuple[int, int]:
    """Return line and column at which a text stands on the screen; (-1, -1) while it does not."""
    places = [(number, line.find(text)) for number, line in enumerate(terminal.text.splitlines())]
    return next((place for place in places if place[1] >= 0), (-1, -1))
