"""Values at each decision: they come from the exact replay, and explain what was done."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.feedback.credit import GammaDelay
from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from studies.session_view.session import open_session
from studies.session_view.thinking import own_thoughts, what_if_thoughts
from studies.session_view.thoughts import THOUGHT, Thoughts
from tests.studies.session_view.made import KEEPAWAY, TETRIS

pytestmark = pytest.mark.jit


@pytest.mark.parametrize("path", [TETRIS, KEEPAWAY], ids=["tetris", "keepaway"])
def test_the_best_value_is_what_the_agent_did(path: Path, tmp_path: Path) -> None:
    words = own_thoughts(path, tmp_path / "own")
    assert words.startswith("exact replay: ")
    thoughts = Thoughts(tmp_path / "own")
    recording = read_recording(path)
    steps = [event for event in recording.outputs if type(event).__name__ == "StepTaken"]
    assert len(thoughts) == len(steps)
    explored = 0
    for row, step in enumerate(steps):
        thought = thoughts[row]
        assert thought is not None
        assert (thought.chosen, thought.environment, thought.human) == (
            step.action,
            step.environment_action,
            step.human_action,
        )
        values = [action.f for action in thought.best]
        assert values == sorted(values, reverse=True)
        by_action = {action.action: action for action in thought.actions}
        assert {thought.chosen, thought.environment} <= by_action.keys()
        if path == TETRIS:
            assert thought.actions[0].action == thought.chosen
        # The learner of Keepaway explores: 1 % of decisions, and ties, are drawn.
        explored += by_action[thought.chosen].f < values[0]
        if thought.human_known and thought.human in by_action:
            assert by_action[thought.human].h == max(action.h for action in thought.actions)
    assert explored <= 2


def test_a_what_if_under_the_sessions_own_rules_thinks_the_same(tmp_path: Path) -> None:
    own_thoughts(TETRIS, tmp_path / "own")
    protocol = protocol_from(read_recording(TETRIS).header.protocol)
    what_if_thoughts(TETRIS, tmp_path / "same", protocol)
    assert (tmp_path / "own").read_bytes() == (tmp_path / "same").read_bytes()


def test_a_what_if_under_another_rule_decides_otherwise(tmp_path: Path) -> None:
    own_thoughts(TETRIS, tmp_path / "own")
    protocol = protocol_from(read_recording(TETRIS).header.protocol)
    credit = msgspec.structs.replace(protocol.agent.credit, delay=GammaDelay())
    other = msgspec.structs.replace(protocol, agent=msgspec.structs.replace(protocol.agent, credit=credit))
    what_if_thoughts(TETRIS, tmp_path / "other", other)
    own, differs = Thoughts(tmp_path / "own").chosen(), Thoughts(tmp_path / "other").chosen()
    assert len(own) == len(differs)
    assert 0 < int((own != differs).sum()) < len(own)
    first = np.flatnonzero(own != differs)[0]
    before = Thoughts(tmp_path / "other")[int(first)]
    assert before is not None
    assert before.human_known


def test_decisions_are_read_while_they_are_written(tmp_path: Path) -> None:
    own_thoughts(TETRIS, tmp_path / "own")
    whole = (tmp_path / "own").read_bytes()
    (tmp_path / "half").write_bytes(whole[: 10 * THOUGHT.itemsize + 7])
    half = Thoughts(tmp_path / "half")
    assert len(half) == 10
    assert half[9] == Thoughts(tmp_path / "own")[9]
    assert half[10] is None
    assert Thoughts(tmp_path / "none")[0] is None


def test_a_replay_that_differs_says_where(tmp_path: Path) -> None:
    from tests.studies.session_view.made import live_events, write

    path = write(tmp_path / "live.jsonl", live_events())
    assert own_thoughts(path, tmp_path / "own").startswith("not exact: output ")
    assert len(open_session(path).steps) == 2
