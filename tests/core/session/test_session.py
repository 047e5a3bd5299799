"""A session: what happens in which order, and what it depends on."""

import pytest

from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    KeyPressed,
    PressRetracted,
    SessionEnded,
    StepTaken,
    StopAsked,
    UnseenPlayed,
)
from core.numerics.clock import ManualClock
from core.session.protocol import SessionConfig
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol
from core.session.session import build_session
from core.tetris.config import TetrisConfig
from tests.core.sessions import simulated, small_protocol


class Script:
    """A participant who does at each step what the script says."""

    def __init__(self, at: dict[int, list]) -> None:
        self.at = at
        self.frames = 0

    def during(self, step: int):
        shown = []
        if step >= 0:
            shown.append(FrameShown(frame=self.frames, step=step, flushed_ns=1_000_000_000 * step))
            self.frames += 1
        return shown + self.at.pop(step, [])


def run(script: Script, *, root_seed: int = 3, **changes) -> list:
    return list(build_session(small_protocol(**changes), root_seed).run(script, ManualClock()))


def press(number: int, time_s: float, value: float) -> KeyPressed:
    return KeyPressed(
        press=number,
        time_ns=round(time_s * 1e9),
        key="j",
        value=value,
        frame=0,
        step=0,
        verdict="accepted",
    )


def kinds(outputs: list) -> list[str]:
    return [type(output).__name__ for output in outputs if not isinstance(output, StepTaken)]


def test_watched_episodes_alternate_with_unseen_ones():
    assert kinds(run(Script({}))) == [
        "EpisodeStarted",
        "EpisodeEnded",
        "UnseenPlayed",
        "EpisodeStarted",
        "EpisodeEnded",
        "UnseenPlayed",
        "EpisodeStarted",
        "EpisodeEnded",
        "SessionEnded",
    ]


def test_episodes_and_steps_are_numbered_through_the_session():
    outputs = run(Script({}))
    steps = [output.step for output in outputs if isinstance(output, StepTaken)]
    assert steps == list(range(len(steps)))
    assert [o.episode for o in outputs if isinstance(o, EpisodeStarted)] == [0, 21, 42]
    assert [o.first_episode for o in outputs if isinstance(o, UnseenPlayed)] == [1, 22]


def test_a_session_follows_from_protocol_and_seed():
    assert run(Script({}), root_seed=3) == run(Script({}), root_seed=3)
    assert run(Script({}), root_seed=3) != run(Script({}), root_seed=4)


def test_a_press_changes_what_the_agent_knows_from_the_next_step_on():
    silent, heard = run(Script({})), run(Script({2: [press(0, 2.5, -1.0)]}))
    given = next(output for output in heard if isinstance(output, CreditGiven))
    # Previous-step credit: the press during step 2 speaks of step 1.
    assert (given.press, given.steps, given.shares) == (0, [1], [1.0])
    at = heard.index(given)
    assert [o.human_action for o in heard[:at] if isinstance(o, StepTaken)] == [-1, -1, -1]
    assert heard[at + 1].human_action >= 0
    assert silent[:at] == heard[:at]


def test_a_retracted_press_leaves_the_agent_as_if_it_had_never_been_made():
    silent = run(Script({}))
    taken_back = run(
        Script({2: [press(0, 2.5, 1.0), PressRetracted(press=0, time_ns=1, reason="participant")]})
    )
    assert next(o for o in taken_back if isinstance(o, SessionEnded)).weights == silent[-1].weights


def test_stopping_truncates_the_episode_and_ends_the_session():
    outputs = run(Script({1: [StopAsked(time_ns=5, reason="participant")]}))
    assert kinds(outputs) == ["EpisodeStarted", "EpisodeEnded", "SessionEnded"]
    ended = outputs[-2]
    assert (ended.ended, ended.steps) == ("truncation", 2)
    assert outputs[-1].reason == "participant"


def test_a_watched_episode_stops_at_its_limit():
    outputs = run(
        Script({}), session=SessionConfig(episodes=1, unseen_between=0, watched_steps=4, unseen_steps=1)
    )
    ended = next(output for output in outputs if isinstance(output, EpisodeEnded))
    assert (ended.steps, ended.ended) == (4, "truncation")


def test_only_placements_that_primitives_can_reach_are_shown():
    assert small_protocol().domain == TetrisConfig(placements="reachable")


def test_outputs_count_the_inputs_that_were_taken_in_before(tmp_path):
    inputs = 0
    for event in simulated(tmp_path).events:
        if hasattr(event, "inputs"):
            assert event.inputs <= inputs
        elif not isinstance(event, CreditGiven):
            inputs += 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[session]\nepisodes = 0\n", r":2: \[session\] episodes = 0: expected a whole number 1 to 10000"),
        ("[session]\nepisods = 3\n", r":2: \[session\] episods = 3: .*did you mean `episodes`"),
        ("[keys]\ngood = 3\n", r":2: \[keys\] good = 3: expected a text: one lower-case letter"),
        ("[session\n", ":1: not a TOML file"),
        ("[session]\nepisodes = “3”\n", r":2: not a TOML file: Invalid value, in the line 'episodes = “3”'"),
        ('[agent.scheme]\ntype = "liner"\n', r':2: \[agent.scheme\] type = "liner": .*did you mean "linear"'),
    ],
)
def test_a_wrong_protocol_is_refused_with_file_place_and_reason(tmp_path, text, message):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(ProtocolError, match=rf"study\.toml{message}"):
        load_protocol(path)


def test_a_protocol_file_says_only_what_differs_from_the_defaults(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text('name = "pilot"\n[agent.credit.delay]\ntype = "gamma"\nscale_s = 0.2\n')
    protocol = load_protocol(path)
    assert protocol.name == "pilot"
    assert protocol.agent.credit.delay.scale_s == 0.2
    assert protocol.session == load_protocol(None).session
