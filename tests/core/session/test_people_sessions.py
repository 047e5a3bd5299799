"""Sessions of several people at one keyboard, and with graded feedback: recorded, replayed, learned again."""

from pathlib import Path

import msgspec
import pytest

from core.events import CreditGiven, KeyPressed
from core.feedback.config import CreditConfig
from core.feedback.delays import GammaDelay, PerValueDelay
from core.feedback.keys import KeyConfig
from core.feedback.people import PersonConfig
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.recorder import LineWriter
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from tests.core.sessions import TALKATIVE, simulated, small_protocol

PEOPLE = (
    PersonConfig(name="A01", good="j", bad="f", retract="u"),
    PersonConfig(name="B02", good="w", bad="q", retract="e", delay=GammaDelay(2.5, 0.4)),
    PersonConfig(name="C03", graded=("x", "c", "v", "b", "n"), retract="m", max_presses_per_episode=3),
)


def replayed(recording: Recording) -> None:
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None, str(result.difference)


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return simulated(tmp_path_factory.mktemp("crowd"), small_protocol(people=PEOPLE))


def test_a_session_of_people_says_who_pressed_and_replays_bit_for_bit(crowd: Recording) -> None:
    presses = [event for event in crowd.events if isinstance(event, KeyPressed)]
    assert crowd.header.participants == ["A01", "B02", "C03"]
    assert {press.person for press in presses} == {0, 1, 2}
    for press in presses:
        assert press.key in crowd_keys(crowd)[press.person]
    mine = [press for press in presses if press.person == 2 and press.verdict == "accepted"]
    assert 0 < len(mine) <= 3 * 3
    assert {press.value for press in mine} > {2.0} or {press.value for press in mine} & {-2.0, 2.0}
    assert set(crowd.outputs[-1].weights) >= {"human", "human-1", "human-2"}
    assert len(crowd.outputs[-1].weights["trust"]) == 3
    replayed(crowd)


def crowd_keys(recording: Recording) -> list[tuple[str, ...]]:
    return [keys.letters for keys in protocol_from(recording.header.protocol).keys_of_people]


def test_each_person_is_credited_by_their_own_delay(crowd: Recording) -> None:
    """A rule (previous) gives whole steps; B02's density shares its presses among several."""
    presses = {event.press: event for event in crowd.events if isinstance(event, KeyPressed)}
    steps = {0: 0, 1: 0}
    for given in (event for event in crowd.outputs if isinstance(event, CreditGiven)):
        person = presses[given.press].person
        if person in steps:
            steps[person] = max(steps[person], len(given.steps))
    assert steps[0] == 1
    assert steps[1] > 1


def test_a_what_if_under_the_sessions_own_rules_is_the_sessions_own_agent(crowd: Recording) -> None:
    protocol = protocol_from(crowd.header.protocol)
    steps = watched_steps(crowd, protocol)
    again = relearn(crowd, protocol, steps, root_seed=crowd.header.root_seed)
    assert again.agent.export() == crowd.outputs[-1].weights


def test_the_summary_counts_each_persons_presses_and_each_value(crowd: Recording) -> None:
    held = summarise_recording(crowd)
    assert [name for name, _ in held.presses_of_people] == ["A01", "B02", "C03"]
    assert sum(n for _, n in held.presses_of_people) == held.presses_counted
    assert sum(n for _, n in held.presses_by_value) == held.presses_counted
    assert f"A01 {held.presses_of_people[0][1]}" in held.words


def test_a_press_that_is_said_to_be_another_persons_is_refused(crowd: Recording, tmp_path: Path) -> None:
    """Sealed anew with another owner: the key says whose it is."""
    path = tmp_path / "forged.jsonl"
    writer = LineWriter(path, crowd.header)
    first = next(event for event in crowd.events if isinstance(event, KeyPressed) and event.person == 0)
    for event in crowd.events:
        writer.write(msgspec.structs.replace(event, person=1) if event is first else event)
    writer.close()
    with pytest.raises(RecordingError, match=r"its person is 1; .* follows 0"):
        replayed(read_recording(path))


def test_one_participant_is_recorded_without_a_word_of_people_or_grades(tmp_path: Path) -> None:
    content = simulated(tmp_path).path.read_bytes()
    for word in (b"people", b"graded", b"participants", b"person"):
        assert word not in content


GRADED = KeyConfig(graded=("d", "f", "g", "h", "j"), max_presses_per_episode=20)


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    protocol = small_protocol(
        keys=GRADED, trainer=msgspec.structs.replace(TALKATIVE, delay=PerValueDelay(), skip_margin=0.15)
    )
    credit = CreditConfig(delay=PerValueDelay())
    agent = msgspec.structs.replace(protocol.agent, credit=credit)
    return simulated(tmp_path_factory.mktemp("graded"), msgspec.structs.replace(protocol, agent=agent))


def test_a_graded_session_replays_bit_for_bit(graded: Recording) -> None:
    presses = [e for e in graded.events if isinstance(e, KeyPressed) and e.verdict == "accepted"]
    assert {press.value for press in presses} > {-2.0, 0.0, 2.0} or len({p.value for p in presses}) >= 3
    assert 0.0 in {press.value for press in presses}
    replayed(graded)
    held = summarise_recording(graded)
    assert dict(held.presses_by_value)[0.0] == sum(press.value == 0.0 for press in presses)


def test_a_density_for_every_value_teaches_otherwise_than_one_for_all(graded: Recording) -> None:
    own = protocol_from(graded.header.protocol)
    learned = []
    for delay in (PerValueDelay(), GammaDelay()):
        agent = msgspec.structs.replace(
            own.agent, credit=msgspec.structs.replace(own.agent.credit, delay=delay)
        )
        protocol = msgspec.structs.replace(own, agent=agent)
        steps = watched_steps(graded, protocol)
        learned.append(relearn(graded, protocol, steps, root_seed=graded.header.root_seed))
    assert learned[0].agent.export() == graded.outputs[-1].weights
    assert learned[0].credits != learned[1].credits
    assert learned[0].agent.export()["human"] != learned[1].agent.export()["human"]
