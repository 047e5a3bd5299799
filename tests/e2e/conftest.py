"""What the sessions in a pseudo-terminal share."""

from pathlib import Path

import pytest

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
def _compiled_before(compiled: None) -> None:
    """Wait until everything is compiled."""
