"""Questions of the agent in sessions: posed, answered, learned from, replayed, and known to what-ifs."""

import itertools
from pathlib import Path
from typing import ClassVar

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.combination.config import AgentConfig, AskingConfig
from core.events import (
    CreditGiven,
    EpisodeStarted,
    FrameShown,
    KeyPressed,
    QuestionAnswered,
    QuestionPosed,
    ScreenCleared,
    SessionEnded,
    StepTaken,
)
from core.feedback.delays import PreviousStep, UniformDelay
from core.feedback.samples import CreditConfig
from core.feedback.trainers import SimulatedTrainer
from core.recording.anonymise import Anonymising, anonymised
from core.recording.reader import Recording, RecordingError, read_recording
from core.recording.schema import to_plain
from core.session.inputs import check_inputs
from core.session.plan import expected_minutes, expected_questions, plan
from core.session.protocol import DEFAULTS, Protocol, ScreenConfig, SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, replay_human_model, watched_steps
from tests.core.sessions import simulated, small_protocol

ASKING = AskingConfig(per_episode=3, share=0.5, minimum_decisions=3, memory=50)


def asking_protocol(asking: AskingConfig = ASKING, **changes) -> Protocol:
    return small_protocol(agent=AgentConfig(asking=asking), **changes)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return simulated(tmp_path_factory.mktemp("asked"), asking_protocol())


def questions_of(recording: Recording) -> list[QuestionPosed]:
    return [event for event in recording.events if isinstance(event, QuestionPosed)]


def answers_of(recording: Recording) -> list[QuestionAnswered]:
    return [event for event in recording.events if isinstance(event, QuestionAnswered)]


def exact(recording: Recording) -> None:
    protocol = protocol_from(recording.header.protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert result.difference is None, str(result.difference)


def test_questions_are_numbered_answered_once_and_within_the_budget(recording: Recording) -> None:
    posed, answered = questions_of(recording), answers_of(recording)
    assert len(posed) > 2
    assert [each.question for each in posed] == list(range(len(posed)))
    assert [each.question for each in answered] == [each.question for each in posed]
    for episode in {each.episode for each in posed}:
        assert sum(each.episode == episode for each in posed) <= ASKING.per_episode
    for question, answer in zip(posed, answered, strict=True):
        assert 2 <= len(question.options) == len(set(question.options)) <= 3
        assert answer.chosen in (-1, *question.options)
        assert 0 < answer.time_ns - answer.shown_ns <= ASKING.limit_s * 1e9
        assert answer.shown_ns - question.time_ns == pytest.approx(ASKING.settle_s * 1e9)


def test_the_decision_asked_about_is_the_next_step(recording: Recording) -> None:
    outputs = [event for event in recording.outputs if not isinstance(event, CreditGiven)]
    for posed, following in itertools.pairwise(outputs):
        if isinstance(posed, QuestionPosed):
            assert isinstance(following, StepTaken)
            assert following.step == posed.step
            if following.action in posed.options:
                assert posed.details[posed.options.index(following.action)] == following.detail


def test_an_answer_is_that_of_the_key_and_carries_its_time(recording: Recording) -> None:
    presses = {event.press: event for event in recording.events if isinstance(event, KeyPressed)}
    for question, answer in zip(questions_of(recording), answers_of(recording), strict=True):
        if answer.answer == "time-limit":
            assert answer.press == -1
            continue
        press = presses[answer.press]
        assert (press.time_ns, press.verdict) == (answer.time_ns, "other")
        place = ASKING.keys.index(press.key) if press.key in ASKING.keys else -1
        assert answer.chosen == (-1 if place < 0 else question.options[place])


def test_a_session_with_questions_replays_and_is_relearned_exactly(recording: Recording) -> None:
    exact(recording)
    protocol = protocol_from(recording.header.protocol)
    steps = watched_steps(recording, protocol)
    relearned = relearn(recording, protocol, steps, root_seed=recording.header.root_seed)
    (ended,) = (event for event in recording.events if isinstance(event, SessionEnded))
    assert relearned.agent.digest() == ended.digest
    alone = replay_human_model(recording, protocol, steps, count=lambda press: True)
    np.testing.assert_array_equal(alone.human.weights, relearned.agent.human.weights)


def test_an_anonymised_copy_replays_exactly(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "copy.jsonl"
    path.write_bytes(anonymised(recording, Anonymising(bytes(32))))
    copy = read_recording(path)
    assert answers_of(copy) == answers_of(recording) != []
    exact(copy)


def test_a_what_if_without_presses_still_learns_from_the_answers(recording: Recording) -> None:
    protocol = protocol_from(recording.header.protocol)
    steps = watched_steps(recording, protocol)
    alone = replay_human_model(recording, protocol, steps, count=lambda press: False)
    assert not alone.credits
    assert alone.human.knows_something == any(each.chosen >= 0 for each in answers_of(recording))


@pytest.mark.parametrize("delay", [UniformDelay(0.2, 8.0), PreviousStep()])
def test_no_press_is_credited_across_a_question(tmp_path: Path, delay) -> None:
    agent = AgentConfig(asking=ASKING, credit=CreditConfig(delay=delay))
    recording = simulated(tmp_path, small_protocol(agent=agent))
    shown_ns: dict[int, int] = {}
    covered_ns: list[int] = []
    presses: dict[int, KeyPressed] = {}
    checked = 0
    for event in recording.events:
        match event:
            case FrameShown(step=step, flushed_ns=time_ns) if step >= 0:
                shown_ns.setdefault(step, time_ns)
            case ScreenCleared(time_ns=time_ns, reason="question"):
                covered_ns.append(time_ns)
            case KeyPressed():
                presses[event.press] = event
            case CreditGiven(press=press, steps=steps):
                pressed_ns = presses[press].time_ns
                last_ns = max((at_ns for at_ns in covered_ns if at_ns <= pressed_ns), default=0)
                assert all(shown_ns[step] >= last_ns for step in steps)
                checked += 1
    assert checked > 3
    assert covered_ns
    exact(recording)


def test_presses_under_a_question_do_not_count(
    recording: Recording,
) -> None:
    open_ = False
    for event in recording.events:
        match event:
            case ScreenCleared(reason="question"):
                open_ = True
            case QuestionAnswered():
                open_ = False
            case KeyPressed(verdict="accepted"):
                assert not open_


def test_a_learner_without_policies_asks_too(tmp_path: Path) -> None:
    default = DEFAULTS["gymnasium"]
    protocol = msgspec.structs.replace(
        default,
        session=SessionConfig(
            episodes=2, unseen_before=5, unseen_between=5, watched_steps=40, unseen_steps=50
        ),
        screen=ScreenConfig(tick_ms=200),
        agent=msgspec.structs.replace(default.agent, asking=ASKING),
    )
    recording = simulated(tmp_path, protocol)
    assert questions_of(recording)
    assert all(0 < each.disagreement <= 1 for each in questions_of(recording))
    exact(recording)


class AnyAnswers(SimulatedTrainer):
    """Answers whatever the test says, as late as it says."""

    said: ClassVar[list[tuple[int, float]]] = []

    def answer(self, step, oracle_values, options):
        place, _ = self.said[step % len(self.said)]
        return options[place] if 0 <= place < len(options) else None

    def answer_delay_s(self, step):
        return self.said[step % len(self.said)][1]


@settings(max_examples=12, deadline=None)
@given(
    said=st.lists(st.tuples(st.integers(-1, 2), st.floats(0.1, 12.0)), min_size=1, max_size=5),
    seed=st.integers(0, 20),
)
def test_any_answers_replay_exactly(said, seed, tmp_path_factory) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AnyAnswers, "said", said)
        patch.setattr("studies.demo.SimulatedTrainer", AnyAnswers)
        session = SessionConfig(
            episodes=2, unseen_before=4, unseen_between=4, watched_steps=10, unseen_steps=40
        )
        recording = simulated(
            tmp_path_factory.mktemp("any"), asking_protocol(session=session), root_seed=seed
        )
    exact(recording)
    protocol = protocol_from(recording.header.protocol)
    steps = watched_steps(recording, protocol)
    relearned = relearn(recording, protocol, steps, root_seed=seed)
    assert relearned.agent.digest() == recording.outputs[-1].digest


# --- what cannot have happened -----------------------------------------------------------------------------


def forged(recording: Recording, kind: type, **changes) -> Recording:
    """Change the first event of a kind."""
    events = list(recording.events)
    at = next(n for n, event in enumerate(events) if isinstance(event, kind))
    events[at] = msgspec.structs.replace(events[at], **changes)
    return Recording(recording.path, recording.header, tuple(events), complete=recording.complete)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"question": 7}, "is not the one that was posed last"),
        ({"chosen": 10**6}, "from the key"),
        ({"press": 10**6}, "a press that is not the last one"),
        ({"answer": "time-limit", "chosen": -1, "press": -1}, "before its limit"),
        ({"shown_ns": 0}, "before it was posed"),
    ],
)
def test_an_answer_that_does_not_follow_from_its_key_is_refused(recording, changes, reason) -> None:
    own = protocol_from(recording.header.protocol)
    check_inputs(recording, own.keys, own.agent.asking)
    with pytest.raises(RecordingError, match=reason):
        check_inputs(forged(recording, QuestionAnswered, **changes), own.keys, own.agent.asking)


def test_an_answer_without_a_question_is_refused(recording: Recording) -> None:
    own = protocol_from(recording.header.protocol)
    events = [event for event in recording.events if not isinstance(event, QuestionPosed)]
    without = Recording(recording.path, recording.header, tuple(events), complete=False)
    with pytest.raises(RecordingError, match="is not the one that was posed last"):
        check_inputs(without, own.keys, own.agent.asking)


# --- settings ----------------------------------------------------------------------------------------------


def test_settings_at_their_defaults_leave_recordings_as_they_were() -> None:
    asking = to_plain(Protocol())["agent"]["asking"]
    assert set(asking) == {"per_episode", "options", "share", "memory", "minimum_decisions"}
    other = Protocol(agent=AgentConfig(asking=AskingConfig(limit_s=3.0)))
    assert to_plain(other)["agent"]["asking"]["limit_s"] == 3.0
    assert protocol_from(to_plain(other)) == other


def test_a_plan_says_how_many_questions_and_minutes() -> None:
    quiet = small_protocol()
    asked = asking_protocol()
    assert "Asking" not in plan(quiet)
    assert "at most 3 in a game, 9 in all" in plan(asked)["Asking"]
    assert 0 < expected_questions(asked) <= 9
    assert expected_minutes(asked) > expected_minutes(quiet)


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ({"keys": ("1", "1", "2")}, "different keys"),
        ({"none_key": "A"}, "one lower-case letter"),
        ({"limit_s": 0.0}, "limit_s"),
        ({"settle_s": -1.0}, "settle_s"),
    ],
)
def test_impossible_settings_are_refused(wrong, reason) -> None:
    with pytest.raises(ValueError, match=reason):
        AskingConfig(per_episode=1, **wrong)


def test_a_key_that_means_something_else_is_refused() -> None:
    plain = to_plain(asking_protocol(AskingConfig(per_episode=1, keys=("j", "2", "3"))))
    with pytest.raises(ValueError, match=r"the key j is keys\.good"):
        protocol_from(plain, to_run=True)


def test_episodes_of_questions_belong_to_watched_games(recording: Recording) -> None:
    watched = {event.episode for event in recording.events if isinstance(event, EpisodeStarted)}
    assert {each.episode for each in questions_of(recording)} <= watched
