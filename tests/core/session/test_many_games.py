"""A session of many games replays in the memory of a few: by name, `pytest -n 0 -s -m slow FILE`."""

from pathlib import Path

import pytest

from core.feedback.keys import KeyConfig
from core.recording.stored import stored_recording
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from studies.demo import simulate_session
from tests.core.sessions import small_protocol

N_GAMES = 10_000
MOST_GROWTH = 5e6
"""Bytes between a tenth of a replay and its end."""


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="memory is read from Linux's /proc")
def test_ten_thousand_games_replay_in_the_memory_of_a_thousand(tmp_path: Path) -> None:
    protocol = small_protocol(
        session=SessionConfig(episodes=N_GAMES, unseen_between=0, watched_steps=6, unseen_steps=100),
        keys=KeyConfig(max_presses_per_episode=20),
    )
    simulate_session(protocol, 5, tmp_path / "s.jsonl", software={})
    recording = stored_recording(tmp_path / "s.jsonl", from_bytes=0)
    assert recording is not None
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    told: list[tuple[int, int]] = []

    def progress(n_outputs: int) -> None:
        told.append((n_outputs + (told[-1][0] if told else 0), resident_bytes()))

    result = replay_exactly(recording, session, on_progress=progress)
    assert result.difference is None
    after_a_tenth = next(held for outputs, held in told if outputs >= result.outputs / 10)
    for outputs, held in told[:: max(1, len(told) // 10)]:
        print(f"{outputs:9,} of {result.outputs:,} outputs: {held / 1e6:.1f} MB")
    assert told[-1][1] - after_a_tenth < MOST_GROWTH
