"""What-if replay: what changes with the rules, and what must not."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from core.combination.config import AgentConfig, BootstrapConfig, FixedWeight
from core.events import EpisodeEnded, EpisodeStarted, SessionEnded
from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep
from core.feedback.samples import CreditConfig
from core.recording.importers.tamer_log import import_tamer_log, tamer_protocol
from core.recording.reader import Recording, RecordingError, read_recording
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.what_if import relearn, replay_human_model, watched_steps
from tests.core.recording.test_tamer_log import PARAMETERS, row, terminal
from tests.core.sessions import simulated


def own_protocol(recording: Recording) -> Protocol:
    return protocol_from(recording.header.protocol)


def with_delay(protocol: Protocol, delay) -> Protocol:
    credit = msgspec.structs.replace(protocol.agent.credit, delay=delay)
    return msgspec.structs.replace(protocol, agent=msgspec.structs.replace(protocol.agent, credit=credit))


def learned(recording: Recording, protocol: Protocol):
    steps = watched_steps(recording, protocol)
    return relearn(recording, protocol, steps, root_seed=recording.header.root_seed)


def test_under_its_own_rules_a_session_is_learned_again_as_it_was(tmp_path):
    recording = simulated(tmp_path)
    again = learned(recording, own_protocol(recording))
    ended = next(output for output in recording.outputs if isinstance(output, SessionEnded))
    assert again.agent.export() == ended.weights
    assert again.agent.digest() == ended.digest
    assert again.trust == [o.trust for o in recording.outputs if isinstance(o, EpisodeEnded)]


def test_another_credit_rule_teaches_something_else_from_the_same_presses(tmp_path):
    recording = simulated(tmp_path)
    weights = {
        type(delay).__name__: learned(
            recording, with_delay(own_protocol(recording), delay)
        ).agent.human.weights
        for delay in (PreviousStep(), CurrentStep(), GammaDelay())
    }
    assert not np.array_equal(weights["PreviousStep"], weights["CurrentStep"])
    assert not np.array_equal(weights["PreviousStep"], weights["GammaDelay"])


def test_every_accepted_press_is_credited_in_full_under_every_rule(tmp_path):
    recording = simulated(tmp_path)
    accepted = [e.press for e in recording.inputs if getattr(e, "verdict", "") == "accepted"]
    for delay in (PreviousStep(), CurrentStep(), GammaDelay()):
        credits = learned(recording, with_delay(own_protocol(recording), delay)).credits
        assert [given.press for given in credits] == accepted
        for given in credits:
            total = sum(given.shares) + given.before_first + given.in_gaps + given.too_late
            assert total == pytest.approx(1.0)


def test_a_human_model_alone_hears_what_the_agent_hears(tmp_path):
    recording = simulated(tmp_path)
    protocol = own_protocol(recording)
    replayed = replay_human_model(
        recording, protocol, watched_steps(recording, protocol), count=lambda press: True
    )
    again = learned(recording, protocol)
    assert np.array_equal(replayed.human.weights, again.agent.human.weights)
    assert replayed.credits == again.credits


def test_presses_that_do_not_count_teach_nothing(tmp_path):
    recording = simulated(tmp_path)
    protocol = own_protocol(recording)
    replayed = replay_human_model(
        recording, protocol, watched_steps(recording, protocol), count=lambda press: False
    )
    assert replayed.credits == []
    assert not replayed.human.knows_something


def test_a_fixed_trust_stays_fixed(tmp_path):
    recording = simulated(tmp_path)
    agent = AgentConfig(bootstrap=BootstrapConfig(trust=FixedWeight(w_h=0.7)))
    protocol = msgspec.structs.replace(own_protocol(recording), agent=agent)
    assert set(learned(recording, protocol).trust) <= {0.0, 0.7}


def imported(tmp_path) -> Recording:
    log = tmp_path / "p.log"
    flat = {(0, column): 1 for column in range(2)}
    rows = [
        row("1.0", piece=1),
        row("3.0", piece=1, cells=flat, presses="[{1.0 @ 2.0}]"),
        row("5.0", piece=1, cells=flat | {(1, 0): 1}, presses="[{-1.0 @ 3.5}, {-1.0 @ 4.0}]"),
        terminal("7.0", presses="[{-1.0 @ 6.0}]"),
    ]
    log.write_text("\n".join([PARAMETERS, *rows, "finished"]))
    import_tamer_log(log, tmp_path / "p.jsonl")
    return read_recording(tmp_path / "p.jsonl")


def test_an_imported_step_is_seen_as_the_change_between_the_boards(tmp_path):
    recording = imported(tmp_path)
    protocol = msgspec.structs.replace(
        tamer_protocol(),
        domain=msgspec.structs.replace(tamer_protocol().domain, feedback_features="bertsekas-21"),
    )
    steps = watched_steps(recording, protocol)
    # Two cells on an empty floor: heights 1 1 0..., one edge of 1, maximum 1.
    assert steps[0].taken.tolist() == [1, 1, *[0] * 8, 0, 1, *[0] * 7, 1, 0]
    assert len(steps[0].choices.ruled_out) == 9  # O on ten columns
    assert np.isnan(steps[2].taken).all()  # what the last placement led to is not in the log


def test_a_press_on_a_step_of_unknown_outcome_is_credited_but_not_learned_from(tmp_path):
    recording = imported(tmp_path)
    protocol = with_delay(tamer_protocol(), CurrentStep())
    protocol = msgspec.structs.replace(
        protocol,
        agent=msgspec.structs.replace(protocol.agent, credit=CreditConfig(delay=CurrentStep())),
    )
    replayed = replay_human_model(
        recording, protocol, watched_steps(recording, protocol), count=lambda press: True
    )
    assert [given.steps for given in replayed.credits] == [[0], [1], [1], [2]]
    assert replayed.human.model.state_bytes()[:8] == (3).to_bytes(8, "little")  # as many samples


def test_a_game_that_cannot_have_begun_is_refused(tmp_path):
    recording = simulated(tmp_path)
    events = [
        msgspec.structs.replace(event, episode_seed=10**300) if isinstance(event, EpisodeStarted) else event
        for event in recording.events
    ]
    forged = replace(recording, events=tuple(events))
    with pytest.raises(RecordingError, match="no game can begin as recorded"):
        watched_steps(forged, own_protocol(recording))
