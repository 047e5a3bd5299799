"""No press is credited across a gap in time: by the assigner, in sessions, in replays and in what-ifs."""

from itertools import count
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.events import CreditGiven, Event, FrameShown, Input, KeyPressed, Resumed, ScreenCleared, TimeGap
from core.feedback.assigner import CreditAssigner
from core.feedback.delays import CurrentStep, Delay, GammaDelay, PreviousStep, UniformDelay
from core.feedback.samples import CreditConfig
from core.numerics.clock import NS_PER_S, ManualClock
from core.recording.reader import Recording
from core.recording.schema import Header, to_plain
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, replay_human_model, watched_steps
from tests.core.recording.test_recording import HEADER
from tests.core.sessions import small_protocol

RULES: tuple[Delay, ...] = (PreviousStep(), CurrentStep(), GammaDelay(), UniformDelay())


def shown(assigner: CreditAssigner, step: int, time_s: float) -> None:
    assigner.step_shown(step, round(time_s * NS_PER_S), np.array([float(step), 1.0]))


@pytest.mark.parametrize("scheme", ["individual", "aggregate"])
@pytest.mark.parametrize("delay", RULES)
def test_a_press_after_a_gap_says_nothing_of_steps_before_it(delay: Delay, scheme: Any) -> None:
    assigner = CreditAssigner(CreditConfig(delay=delay, scheme=scheme))
    for step in range(3):
        shown(assigner, step, float(step))
    # The program stands still at 2.5 s: a clock that sleeps with the machine moves on by 10 ms only.
    assigner.interrupted(round(2.5 * NS_PER_S))
    shown(assigner, 2, 2.51)
    given = assigner.add_press(0, round(2.6 * NS_PER_S), 1.0)
    assert set(given.steps) <= {2}
    assert sum(given.shares) + given.before_first + given.in_gaps + given.too_late == pytest.approx(1.0)
    if isinstance(delay, CurrentStep):
        assert (given.steps, given.shares) == ((2,), (1.0,))
    if isinstance(delay, PreviousStep):
        assert (given.steps, given.in_gaps) == ((), 1.0)
    if isinstance(delay, GammaDelay):
        # Only what lies between 2.51 s and the press: F(0.09 s).
        assert given.shares == pytest.approx([float(delay.cdf(np.array(0.09)))])


def test_by_hand_what_would_have_fallen_before_the_gap_falls_into_it() -> None:
    assigner = CreditAssigner(CreditConfig(delay=UniformDelay(0.0, 1.0)))
    shown(assigner, 0, 0.0)
    assigner.interrupted(round(0.5 * NS_PER_S))
    shown(assigner, 1, 0.6)
    given = assigner.add_press(0, NS_PER_S, 1.0)
    # One second back: 0.5 on step 0 before the gap, 0.1 in it, 0.4 on step 1.
    assert (given.steps, given.before_first) == ((1,), 0.0)
    assert given.shares == pytest.approx([0.4])
    assert given.in_gaps == pytest.approx(0.6)


def test_a_press_of_before_the_gap_that_comes_late_is_credited_as_ever() -> None:
    assigner = CreditAssigner(CreditConfig(delay=CurrentStep()))
    shown(assigner, 0, 0.0)
    assigner.interrupted(NS_PER_S)
    assert assigner.add_press(0, NS_PER_S // 2, 1.0).steps == (0,)


def test_a_burst_does_not_go_on_behind_a_gap() -> None:
    assigner = CreditAssigner(CreditConfig(delay=CurrentStep(), merge_within_s=1.0))
    shown(assigner, 0, 0.0)
    assigner.add_press(0, round(0.4 * NS_PER_S), 1.0)
    assigner.interrupted(round(0.5 * NS_PER_S))
    shown(assigner, 0, 0.6)
    assert assigner.add_press(1, round(0.7 * NS_PER_S), 1.0).merged_into is None


@given(
    gap_ms=st.integers(0, 3000),
    away_ms=st.integers(0, 3000),
    press_ms=st.integers(0, 2000),
    rule=st.sampled_from(RULES),
)
def test_whenever_the_gap_comes_all_mass_is_accounted_for(
    gap_ms: int, away_ms: int, press_ms: int, rule: Delay
) -> None:
    assigner = CreditAssigner(CreditConfig(delay=rule))
    before = [step for step in range(4) if step * 1000 <= gap_ms]
    for step in before:
        shown(assigner, step, float(step))
    assigner.interrupted(gap_ms * 10**6)
    back_s = (gap_ms + away_ms + 1) / 1000
    shown(assigner, 4, back_s)
    given = assigner.add_press(0, round((back_s + press_ms / 1000) * NS_PER_S), 1.0)
    assert not set(given.steps) & set(before)
    assert sum(given.shares) + given.before_first + given.in_gaps == pytest.approx(1.0)


# --- in sessions --------------------------------------------------------------------------------


class Interrupted:
    """A participant who presses at 2.4 s; the machine stood still from 2.1 s to 2.15 s, in step 2."""

    def __init__(self, clock: ManualClock, *, gap: bool = True) -> None:
        self.events: list[Event] = []
        self._clock = clock
        self._gap = gap
        self._frames = count()

    def during(self, step: int) -> list[Input]:
        def s(time_s: float) -> int:
            return round(time_s * NS_PER_S)

        inputs: list[Input] = []
        if step >= 0:
            inputs.append(FrameShown(frame=next(self._frames), step=step, flushed_ns=s(step)))
            # A step is over, and its inputs are taken in, when the next one comes.
            self._clock.advance_to_ns(s(step + 1))
        if step == 2:
            if self._gap:
                inputs += [
                    TimeGap(last_ns=s(2.1), time_ns=s(2.15), suspended_ns=s(60)),
                    ScreenCleared(time_ns=s(2.15), reason="gap"),
                ]
            frame = next(self._frames)
            inputs += [
                Resumed(time_ns=s(2.18)),
                FrameShown(frame=frame, step=2, flushed_ns=s(2.19)),
                KeyPressed(
                    press=0, time_ns=s(2.4), key="j", value=1.0, frame=frame, step=2, verdict="accepted"
                ),
            ]
        self.events += inputs
        return inputs


def with_delay(protocol: Protocol, delay: Delay) -> Protocol:
    credit = msgspec.structs.replace(protocol.agent.credit, delay=delay)
    return msgspec.structs.replace(protocol, agent=msgspec.structs.replace(protocol.agent, credit=credit))


def recorded(delay: Delay, *, gap: bool = True) -> Recording:
    protocol = with_delay(small_protocol(), delay)
    clock = ManualClock()
    participant = Interrupted(clock, gap=gap)
    for output in build_session(protocol, 3).run(participant, clock):
        participant.events.append(output)
    header: Header = msgspec.structs.replace(HEADER, protocol=to_plain(protocol), root_seed=3)
    return Recording(Path("gap.jsonl"), header, tuple(participant.events), complete=True)


def credited(recording: Recording) -> list[CreditGiven]:
    return [output for output in recording.outputs if isinstance(output, CreditGiven)]


@pytest.mark.parametrize("delay", RULES)
def test_a_session_with_a_gap_replays_exactly_and_credits_nothing_across_it(delay: Delay) -> None:
    recording = recorded(delay)
    (given,) = credited(recording)
    assert set(given.steps) <= {2}
    session = build_session(protocol_from(recording.header.protocol), 3)
    result = replay_exactly(recording, session)
    assert result.difference is None
    assert result.outputs == len(recording.outputs)


def test_without_the_gap_the_same_press_speaks_of_the_step_before() -> None:
    (given,) = credited(recorded(PreviousStep(), gap=False))
    assert given.steps == [1]


@pytest.mark.parametrize("delay", RULES)
def test_a_what_if_credits_nothing_across_a_gap_either(delay: Delay) -> None:
    recording = recorded(CurrentStep())
    protocol = with_delay(protocol_from(recording.header.protocol), delay)
    steps = watched_steps(recording, protocol)
    again = relearn(recording, protocol, steps, root_seed=3)
    heard = replay_human_model(recording, protocol, steps, count=lambda press: True)
    for (found,) in (again.credits, heard.credits):
        assert set(found.steps) <= {2}
    (own,) = credited(recorded(delay))
    assert again.credits == [own]
