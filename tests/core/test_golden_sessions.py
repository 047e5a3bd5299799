"""The golden sessions in recordings/reference: replayed bit for bit in every test run.

They hold the meaning of a recording fixed: if one of these fails, sessions of real people do not replay any more
either. Make a new one only where a game has to play otherwise, `python -m tests.core.test_golden_sessions NAME`, and
raise the game's REVISION: recordings name it, so that nobody wonders why theirs does not replay.
"""

import hashlib
import sys
from pathlib import Path

import msgspec
import pytest

from core import keepaway, tetris
from core.combination.config import AgentConfig, BootstrapConfig, Equation5, Exponential
from core.feedback.config import TrainerConfig
from core.feedback.samples import CreditConfig
from core.keys import KeyConfig
from core.learners.human_config import SgdModel
from core.protocol import KEEPAWAY, SessionConfig, protocol_from
from core.recording.reader import read_recording
from core.replay import replay_exactly
from core.session import build_session
from studies.demo import simulate_session, summarise
from tests.core.sessions import small_protocol

FOLDER = Path(__file__).resolve().parents[2] / "recordings" / "reference"

GOLDEN = {
    "tetris-linear-equation-4": small_protocol(),
    "tetris-aggregate-equation-5": small_protocol(
        agent=AgentConfig(
            bootstrap=BootstrapConfig(trust=Equation5()),
            credit=CreditConfig(scheme="aggregate", silence="zero-label"),
            human_model=SgdModel(step_size=0.01),
        )
    ),
    "keepaway-exponential-equation-4": msgspec.structs.replace(
        KEEPAWAY,
        agent=msgspec.structs.replace(KEEPAWAY.agent, scheme=Exponential()),
        session=SessionConfig(episodes=4, unseen_between=2, watched_steps=60, unseen_steps=60),
        keys=KeyConfig(max_presses_per_episode=5),
        trainer=TrainerConfig(press_probability=1.0, max_presses=5),
    ),
}

SEEDS = dict(zip(GOLDEN, (2011, 2012, 2019), strict=True))


@pytest.mark.parametrize("name", GOLDEN)
def test_a_golden_session_is_replayed_bit_for_bit(name):
    recording = read_recording(FOLDER / f"{name}.jsonl", allow_truncated=False)
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None
    assert result.outputs == len(recording.outputs)


REVISIONS = {"tetris": tetris.REVISION, "keepaway": keepaway.REVISION}
PLAYED = {
    ("tetris", 1): "63a4f491c6e413b3",
    ("keepaway", 1): "cf5f2b80840f263d",
    # Other kicks that stop the ball out of reach, of which this session has none.
    ("keepaway", 2): "cf5f2b80840f263d",
}
"""What each revision of a game has played: a digest of its golden sessions."""


@pytest.mark.parametrize("game", REVISIONS)
def test_a_game_that_plays_otherwise_has_another_revision(game):
    digest = hashlib.sha256()
    for name in sorted(name for name in GOLDEN if name.startswith(game)):
        for output in read_recording(FOLDER / f"{name}.jsonl").outputs:
            digest.update(msgspec.json.encode(output))
    assert digest.hexdigest()[:16] == PLAYED[game, REVISIONS[game]]


@pytest.mark.parametrize("name", GOLDEN)
def test_a_golden_session_has_something_to_replay(name):
    summary = summarise(read_recording(FOLDER / f"{name}.jsonl"))
    session = GOLDEN[name].session
    assert summary.episodes == session.episodes
    assert summary.unseen_episodes == (session.episodes - 1) * session.unseen_between
    assert summary.accepted >= 10
    assert 0 < summary.praised < summary.accepted


if __name__ == "__main__":
    for name in sys.argv[1:]:
        path = FOLDER / f"{name}.jsonl"
        path.unlink(missing_ok=True)
        simulate_session(GOLDEN[name], SEEDS[name], path, software={"made by": "the test suite"})
