"""What the sessions in a pseudo-terminal share."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.e2e.terminal import REPOSITORY

PROTOCOL = """
name = "short"

[session]
episodes = 2
unseen_between = 4
unseen_steps = 50
watched_steps = 7

[screen]
tick_ms = 70
count_down_s = 0
pause_between_episodes_s = 0.3

[keys]
max_presses_per_episode = 5
"""


@pytest.fixture
def protocol_file(tmp_path: Path) -> Path:
    path = tmp_path / "short.toml"
    path.write_text(PROTOCOL)
    return path


@pytest.fixture(scope="session", autouse=True)
def _compiled_before(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Compile everything once: each of a hundred sessions would begin to, and be ended before it is done."""
    environment = {
        **os.environ,
        "PYTHONPATH": str(REPOSITORY),
        "ARL_HOME": str(tmp_path_factory.mktemp("home")),
    }
    subprocess.run(
        [sys.executable, "-m", "arl_tui.cli", "warm-up"],
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=True,
    )
