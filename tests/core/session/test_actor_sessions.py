"""Sessions of Tetris over policy gradient: recorded, replayed, and played unseen as they would be watched."""

import pytest

from core.combination.config import AgentConfig, Coach, Exponential, RewardShaping
from core.events import EpisodeEnded, SessionEnded, UnseenPlayed
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.numerics.streams import stream_seed
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.rollout import play_unseen
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from core.tetris.config import TetrisConfig
from tests.core.sessions import simulated, small_protocol

LEARNER = PolicyGradientConfig(step_size=0.2)


def climbing(scheme=None, **session):
    agent = AgentConfig() if scheme is None else AgentConfig(scheme=scheme)
    settings = {"episodes": 4, "unseen_between": 30, "watched_steps": 12, "unseen_steps": 100} | session
    return small_protocol(learner=LEARNER, agent=agent, session=SessionConfig(**settings))


@pytest.mark.parametrize("watched", ["top", "proposed"])
@pytest.mark.parametrize("scheme", [None, Exponential(), RewardShaping(), Coach()], ids=str)
def test_a_session_is_replayed_bit_for_bit(tmp_path, scheme, watched):
    recording = simulated(tmp_path, climbing(scheme, watched=watched))
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    assert replay_exactly(recording, session).difference is None
    unseen = [event for event in recording.outputs if isinstance(event, UnseenPlayed)]
    assert len({policy for event in unseen for policy in event.policies}) == 90


def test_the_recordings_last_word_is_the_actor(tmp_path):
    recording = simulated(tmp_path, climbing())
    last = recording.outputs[-1]
    assert isinstance(last, SessionEnded)
    assert len(last.weights["actor"]) == 21


def test_a_what_if_with_the_same_protocol_is_the_session(tmp_path):
    protocol = climbing(watched="proposed")
    recording = simulated(tmp_path, protocol)
    again = relearn(recording, protocol, watched_steps(recording, protocol), root_seed=5)
    assert again.agent.digest() == recording.outputs[-1].digest
    assert again.trust == [event.trust for event in recording.outputs if isinstance(event, EpisodeEnded)]


@pytest.mark.parametrize(
    "scheme", [None, RewardShaping(beta_0=0.1), Coach(), Coach(environment_too=False)], ids=str
)
def test_unseen_games_in_compiled_code_are_those_played_step_by_step(scheme):
    protocol = small_protocol(
        learner=LEARNER,
        domain=TetrisConfig(rows=8, columns=6),
        agent=AgentConfig() if scheme is None else AgentConfig(scheme=scheme),
    )
    compiled, stepwise = build_session(protocol, 3), build_session(protocol, 3)
    lines = 0.0
    for episode in range(12):
        seed = stream_seed(3, "episode", episode)
        policy = compiled.agent.begin_episode(exploring=True, watched=False)
        played = compiled._player(policy, seed, 60)
        compiled.agent.learn_from_domain(policy, played)
        policy = stepwise.agent.begin_episode(exploring=True, watched=False)
        expected = play_unseen(stepwise.domain, stepwise.agent, policy, seed, 60)
        stepwise.agent.learn_from_domain(policy, expected)
        assert played == expected
        lines += played.performance
        assert compiled.agent.export() == stepwise.agent.export()
    assert lines > 0
