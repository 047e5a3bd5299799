"""The golden sessions in recordings/reference, of every version of the format: replayed bit for bit in every
test run.

They hold the meaning of a recording fixed: if one of these fails, sessions of real people do not replay any
more either. Make a new one only where a game has to play otherwise, `python -m
tests.core.session.test_golden_sessions NAME`, and raise the game's REVISION: recordings name it, so that
nobody wonders why theirs does not replay. Files of version 1 were written by the program of then and cannot
be made again.
"""

import hashlib
import sys
from pathlib import Path

import msgspec
import pytest

from core import keepaway, tetris
from core.combination.config import AgentConfig, Annealed, BootstrapConfig, Equation5, Exponential
from core.events import EpisodeStarted, Output, UnseenPlayed
from core.feedback.config import TrainerConfig
from core.feedback.keys import KeyConfig
from core.feedback.samples import CreditConfig
from core.keepaway.plugin import KEEPAWAY
from core.learners.human_config import SgdModel
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from core.recording.version_1 import as_far_as_recorded
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import _run_both, replay_exactly
from core.session.session import build_session
from studies.demo import simulate_session, summarise
from tests.core.sessions import small_protocol

VERSION_1 = Path(__file__).resolve().parents[3] / "recordings" / "reference"
FOLDER = VERSION_1 / "version-2"

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
    # A weight that falls with every episode: what version 1 took for granted.
    "tetris-annealed-per-episode": small_protocol(
        agent=AgentConfig(scheme=Annealed(per="episode")),
        session=SessionConfig(episodes=3, unseen_between=6, watched_steps=10, unseen_steps=100),
    ),
}

SEEDS = dict(zip(GOLDEN, (2011, 2012, 2019, 2013), strict=True))
FILES = sorted(VERSION_1.glob("*.jsonl")) + sorted(FOLDER.glob("*.jsonl"))


def test_every_golden_session_is_there_in_every_version():
    assert {path.stem for path in VERSION_1.glob("*.jsonl")} == set(GOLDEN)
    assert {path.stem for path in FOLDER.glob("*.jsonl")} == set(GOLDEN)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(VERSION_1)))
def test_a_golden_session_is_replayed_bit_for_bit(path):
    recording = read_recording(path, allow_truncated=False)
    assert recording.header.version == (2 if path.parent == FOLDER else 1)
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None
    assert result.outputs == len(recording.outputs)


@pytest.mark.parametrize("name", GOLDEN)
def test_both_versions_say_the_same_of_a_session(name):
    first, second = (read_recording(folder / f"{name}.jsonl") for folder in (VERSION_1, FOLDER))
    assert first.inputs == second.inputs
    assert first.outputs == tuple(
        as_far_as_recorded(old, new) for old, new in zip(first.outputs, second.outputs, strict=True)
    )


@pytest.mark.parametrize("name", GOLDEN)
def test_weight_and_trust_are_recorded_apart(name):
    outputs = read_recording(FOLDER / f"{name}.jsonl").outputs
    started = [output for output in outputs if isinstance(output, EpisodeStarted)]
    unseen = [output for output in outputs if isinstance(output, UnseenPlayed)]
    assert all(len(output.weights) == len(output.policies) for output in unseen)
    if isinstance(GOLDEN[name].agent.scheme, Annealed):
        assert [output.weight for output in started] == [0.0, 0.98**7, 0.98**14]  # 0: nobody had pressed
        assert [output.weights for output in unseen] == [[0.98**k for k in range(n, n + 6)] for n in (1, 8)]
        assert all(output.trust != output.weight for output in started[1:])
    else:
        # Linear and exponential combination go by trust: the weight in use is what the rule said when the
        # episode began.
        assert all(output.trust == output.weight for output in started)
        assert any(output.weight for output in started)


REVISIONS = {"tetris": tetris.REVISION, "keepaway": keepaway.REVISION}
PLAYED = {
    ("tetris", 1): "99b06d287f824f6d",
    ("keepaway", 1): "22677565934f3799",
    # Other kicks that stop the ball out of reach, of which this session has none.
    ("keepaway", 2): "22677565934f3799",
}
"""What each revision of a game has played: a digest of its golden sessions as they are recorded now."""


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


def written_again(name: str, target: Path) -> None:
    """Write a session of version 1 as it is recorded now: its inputs, and what the agent makes of them."""
    old = read_recording(VERSION_1 / f"{name}.jsonl")
    session = build_session(protocol_from(old.header.protocol), old.header.root_seed)
    writer = LineWriter(target, old.header)
    outputs = (new for _, new in _run_both(old, session))
    for event in old.events:
        writer.write(next(outputs) if isinstance(event, Output) else event)
    writer.close()


if __name__ == "__main__":
    for name in sys.argv[1:]:
        path = FOLDER / f"{name}.jsonl"
        path.unlink(missing_ok=True)
        if (VERSION_1 / f"{name}.jsonl").exists():
            written_again(name, path)
        else:
            simulate_session(GOLDEN[name], SEEDS[name], path, software={"made by": "the test suite"})
