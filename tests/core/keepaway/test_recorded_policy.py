"""What keepers had learned by the end of a recorded session."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.events import EpisodeEnded, SessionEnded, UnseenPlayed
from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.domain import Keepaway
from core.keepaway.plugin import KEEPAWAY
from core.keepaway.policy_file import PolicyFileError
from core.keepaway.recorded_policy import N_TILINGS, recorded_policy
from core.learners.sarsa_learner import SarsaLearner
from core.recording.recorder import Recorder
from core.recording.schema import to_plain
from core.session.protocol import Protocol
from tests.core.recording.test_recording import HEADER


def learned() -> SarsaLearner:
    coder = keepaway_tiles(KEEPAWAY.domain)
    learner = SarsaLearner(KEEPAWAY.learner, coder, n_learners=3, n_actions=3, reward_is_time=True)
    rng = np.random.default_rng(4)
    learner.sarsa.weights[:, :, 100:140] = rng.normal(size=(3, 3, 40))
    return learner


ENDED = EpisodeEnded(
    episode=0,
    time_ns=1,
    inputs=0,
    performance=7.0,
    steps=9,
    ended="termination",
    agreed=0,
    agreed_worst=0,
    trust=0.0,
    digest="00",
)
UNSEEN = UnseenPlayed(
    first_episode=1,
    time_ns=2,
    inputs=0,
    policies=[1, 2],
    performances=[5.0, 6.0],
    steps=[3, 4],
    agreed=[0, 0],
    agreed_worst=[0, 0],
    trust=0.0,
    weights=[0.0, 0.0],
    digest="00",
)


def session(path: Path, *events, protocol: Protocol = KEEPAWAY) -> Path:
    with Recorder(path, msgspec.structs.replace(HEADER, protocol=to_plain(protocol))) as recorder:
        for event in events:
            recorder.record(event)
    return path


def last_word(**weights: list[float]) -> SessionEnded:
    return SessionEnded(time_ns=3, inputs=0, reason="finished", weights=weights, digest="00")


def test_the_weights_of_the_last_word_come_back(tmp_path: Path):
    learner = learned()
    path = session(tmp_path / "s.jsonl", ENDED, UNSEEN, last_word(**learner.export()))
    policy = recorded_policy(path)
    assert np.array_equal(policy.weights, learner.sarsa.weights)
    header = policy.header
    assert (header.episodes, header.duration_s, header.root_seed) == (3, 6.0, 3)
    assert header.hours == pytest.approx(18 / 3600)
    assert header.task == KEEPAWAY.domain


def test_sessions_have_the_tilings_that_are_taken_for_granted_here():
    assert Keepaway(KEEPAWAY.domain).coder.n_tilings == N_TILINGS


def test_a_session_without_a_last_word_is_refused(tmp_path: Path):
    with pytest.raises(PolicyFileError, match="cut off before its last word"):
        recorded_policy(session(tmp_path / "s.jsonl", ENDED))


def test_a_session_of_another_game_is_refused(tmp_path: Path):
    with pytest.raises(PolicyFileError, match="a session of tetris"):
        recorded_policy(session(tmp_path / "s.jsonl", ENDED, protocol=Protocol()))


def test_a_last_word_without_weights_is_refused(tmp_path: Path):
    with pytest.raises(PolicyFileError, match=r"holds no weights of Sarsa \('sarsa-shape'\)"):
        recorded_policy(session(tmp_path / "s.jsonl", last_word()))


def test_a_file_that_is_no_recording_is_refused(tmp_path: Path):
    (tmp_path / "s.jsonl").write_text("{}\n")
    with pytest.raises(PolicyFileError, match=r"s\.jsonl:1"):
        recorded_policy(tmp_path / "s.jsonl")
