"""A simulated participant plays on the real screens, and leaves what a live session leaves."""

from pathlib import Path

import pytest

from arl_tui.study.presenter import BlockCall
from arl_tui.study.simulated import ToDraw
from core.events import FrameShown, KeyPressed, ScreenCleared, SessionEnded, WrongPressAsked
from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from studies.lab.config import Block

pytestmark = pytest.mark.filterwarnings("error")


@pytest.mark.jit
@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_a_drawn_session_is_recorded_as_a_live_one_and_replays_exactly(game: str, tmp_path: Path) -> None:
    from arl_tui.study.drawn_session import draw_session

    protocol = protocol_from(
        {
            "domain": {"type": game},
            "session": {"episodes": 2, "watched_steps": 8, "unseen_between": 0},
            "trainer": {"press_probability": 0.7},
            "keys": {"wrong_press_rate": 0.5},
        },
        to_run=True,
    )
    outcome = draw_session(protocol, 3, tmp_path, participant="SIM1", source={}, study={"condition": "a"})
    assert outcome.recording is not None
    assert outcome.tally.good + outcome.tally.bad > 0
    recording = read_recording(outcome.recording)
    assert recording.header.origin == "simulated"
    assert recording.header.clock == "simulated"
    assert recording.header.study == {"condition": "a"}
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert presses
    assert all(press.source == "simulated" for press in presses)
    # Pictures, count-downs and requests for wrong presses are those of a session on a screen.
    frames = [event for event in recording.events if isinstance(event, FrameShown)]
    assert len(frames) > len({frame.step for frame in frames}) > 2
    assert any(isinstance(e, ScreenCleared) and e.reason == "count-down" for e in recording.events)
    asked = sum(isinstance(event, WrongPressAsked) for event in recording.events)
    answered = sum(press.asked_wrong for press in presses if press.verdict == "accepted")
    assert asked > 0
    assert answered in (asked, asked - 1)  # the last may have come too late
    assert isinstance(recording.events[-1], SessionEnded)
    assert replay_exactly(recording, build_session(protocol, 3)).difference is None


def _call(condition: str, step: str) -> BlockCall:
    return BlockCall(
        step=Block(),
        condition=condition,
        code="SIM1",
        folder=Path(),
        seed=1,
        resume=None,
        facts={"step": step},
    )


def test_each_block_of_each_condition_is_drawn_once() -> None:
    calls = [_call("a", "1"), _call("b", "2"), _call("a", "1"), _call("b", "1")]
    assert [ToDraw("once").wants(call) for call in calls[:1]] == [True]
    once = ToDraw("once")
    assert [once.wants(call) for call in calls] == [True, True, False, True]
    assert all(ToDraw("all").wants(call) for call in calls)
    assert not any(ToDraw("none").wants(call) for call in calls)
