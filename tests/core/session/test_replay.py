"""Replay: exact, or the first difference."""

import msgspec
import pytest

from core.combination.config import (
    AgentConfig,
    BootstrapConfig,
    ControlSharing,
    Equation5,
    Exponential,
    Signed,
)
from core.events import StepTaken, UnseenPlayed
from core.feedback.credit import GammaDelay
from core.feedback.samples import CreditConfig
from core.learners.human_config import SgdModel
from core.recording.reader import Recording, RecordingError
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.sessions import simulated, small_protocol


def replayed(recording: Recording):
    protocol = protocol_from(recording.header.protocol)
    return replay_exactly(recording, build_session(protocol, recording.header.root_seed))


AGENTS = {
    "default": AgentConfig(),
    "gamma, Eq. 5, exponential": AgentConfig(
        scheme=Exponential(),
        bootstrap=BootstrapConfig(trust=Equation5()),
        credit=CreditConfig(delay=GammaDelay()),
    ),
    "aggregate, silence, SGD, signed": AgentConfig(
        bootstrap=BootstrapConfig(trust=Signed(minimum_episodes=2)),
        credit=CreditConfig(scheme="aggregate", silence="zero-label"),
        human_model=SgdModel(step_size=0.01),
    ),
    "control sharing": AgentConfig(scheme=ControlSharing()),
}


@pytest.mark.parametrize("agent", AGENTS.values(), ids=AGENTS)
def test_a_session_is_replayed_bit_for_bit(tmp_path, agent):
    recording = simulated(tmp_path, small_protocol(agent=agent))
    result = replayed(recording)
    assert result.difference is None
    assert result.outputs == len(recording.outputs)


def test_a_session_that_was_cut_off_is_replayed_up_to_there(tmp_path):
    recording = simulated(tmp_path)
    lines = recording.path.read_bytes().splitlines(keepends=True)
    for kept in range(2, len(lines), 7):
        cut = Recording(recording.path, recording.header, recording.events[:kept], complete=False)
        assert replayed(cut).difference is None


def changed(recording: Recording, number: int, **fields) -> Recording:
    at = recording.events.index(recording.outputs[number])
    events = list(recording.events)
    events[at] = msgspec.structs.replace(events[at], **fields)
    return Recording(recording.path, recording.header, tuple(events), recording.complete)


def test_the_first_difference_is_told_with_both_values(tmp_path):
    recording = simulated(tmp_path)
    number = next(n for n, output in enumerate(recording.outputs) if isinstance(output, StepTaken) and n > 5)
    action = recording.outputs[number].action
    difference = replayed(changed(recording, number, action=action + 1)).difference
    assert difference is not None
    assert (difference.number, difference.field) == (number, "action")
    assert (difference.recorded, difference.replayed) == (action + 1, action)
    assert str(number) in str(difference)


def test_another_seed_is_noticed(tmp_path):
    recording = simulated(tmp_path)
    protocol = protocol_from(recording.header.protocol)
    assert replay_exactly(recording, build_session(protocol, recording.header.root_seed + 1)).difference


def test_a_missing_press_is_noticed(tmp_path):
    recording = simulated(tmp_path)
    events = list(recording.events)
    at = next(n for n, event in enumerate(events) if getattr(event, "verdict", "") == "accepted")
    events[at] = msgspec.structs.replace(events[at], verdict="other")
    without = Recording(recording.path, recording.header, tuple(events), recording.complete)
    with pytest.raises(RecordingError, match=rf":{at + 2}: press \d+: its verdict is 'other'"):
        replayed(without)


def test_a_session_whose_agent_died_is_replayed_up_to_there(tmp_path):
    recording = simulated(tmp_path)
    # The screen closed the file, so it is complete; but the agent's last word is missing.
    shorter = Recording(recording.path, recording.header, recording.events[:-1], complete=True)
    assert replayed(shorter).difference is None


def test_an_output_too_many_is_noticed(tmp_path):
    recording = simulated(tmp_path)
    longer = Recording(
        recording.path, recording.header, (*recording.events, recording.events[-1]), complete=True
    )
    difference = replayed(longer).difference
    assert difference is not None
    assert (difference.recorded, difference.replayed) == ("SessionEnded", "NoneType")


def test_a_protocol_that_asks_for_other_unseen_episodes_is_not_played_for_hours(tmp_path):
    """Of 10,000,000 episodes one is played before the difference is told."""
    recording = simulated(tmp_path)
    protocol = msgspec.structs.replace(
        protocol_from(recording.header.protocol),
        session=SessionConfig(episodes=3, unseen_between=10_000_000, watched_steps=12, unseen_steps=100),
    )
    played = []
    session = build_session(protocol, recording.header.root_seed)
    result = replay_exactly(recording, session, on_unseen=lambda done, count: played.append(done))
    assert result.difference is not None
    assert str(result.difference).endswith("number of policies was 20 in the recording and is 10000000 now")
    assert not played
    without = tuple(event for event in recording.events if not isinstance(event, UnseenPlayed))
    result = replay_exactly(
        Recording(recording.path, recording.header, without, complete=False),
        build_session(protocol_from(recording.header.protocol), recording.header.root_seed),
    )
    assert "type was 'EpisodeStarted' in the recording and is 'UnseenPlayed' now" in str(result.difference)


def test_an_imported_recording_has_nothing_to_run_again(tmp_path):
    recording = simulated(tmp_path)
    header = msgspec.structs.replace(recording.header, origin="imported", source={"format": "tamer-log"})
    imported = Recording(recording.path, header, recording.events, complete=True)
    with pytest.raises(RecordingError, match=r"imported from tamer-log.*--credit"):
        replayed(imported)
