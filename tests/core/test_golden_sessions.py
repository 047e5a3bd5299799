"""The golden sessions in recordings/reference: replayed bit for bit in every test run.

They hold the meaning of a recording fixed: if one of these fails, sessions of real people do not replay any more
either. Make a new one only with a new version of the format:
`python -m tests.core.test_golden_sessions`.
"""

from pathlib import Path

import pytest

from core.combination.config import AgentConfig, BootstrapConfig, Equation5
from core.feedback.samples import CreditConfig
from core.learners.human_config import SgdModel
from core.protocol import protocol_from
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
}


@pytest.mark.parametrize("name", GOLDEN)
def test_a_golden_session_is_replayed_bit_for_bit(name):
    recording = read_recording(FOLDER / f"{name}.jsonl", allow_truncated=False)
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None
    assert result.outputs == len(recording.outputs)


@pytest.mark.parametrize("name", GOLDEN)
def test_a_golden_session_has_something_to_replay(name):
    summary = summarise(read_recording(FOLDER / f"{name}.jsonl"))
    assert summary.episodes == 3
    assert summary.unseen_episodes == 40
    assert summary.accepted >= 10
    assert 0 < summary.praised < summary.accepted


if __name__ == "__main__":
    for number, (name, protocol) in enumerate(GOLDEN.items()):
        simulate_session(
            protocol, 2011 + number, FOLDER / f"{name}.jsonl", software={"made by": "the test suite"}
        )
