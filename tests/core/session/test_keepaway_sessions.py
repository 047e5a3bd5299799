"""Sessions of Keepaway: played, recorded, replayed, cut off, and learned from again under other rules."""

import itertools

import msgspec
import numpy as np
import pytest

from core.combination.config import (
    AgentConfig,
    Constant,
    ControlSharing,
    EnvironmentOnly,
    Exponential,
    Linear,
)
from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    KeyPressed,
    SessionEnded,
    StepTaken,
    StopAsked,
    UnseenPlayed,
)
from core.feedback.config import CreditConfig
from core.feedback.delays import CurrentStep, GammaDelay
from core.keepaway.decisions import DecisionPlay
from core.keepaway.pitch import CYCLE_NS, NO_PLAYER, KeepawayConfig
from core.keepaway.plugin import KEEPAWAY
from core.learners.human_config import RidgeModel, TileModel
from core.learners.sarsa import decide, end_episode, new_sarsa
from core.numerics.clock import ManualClock
from core.numerics.streams import stream, stream_seed
from core.numerics.tile_coding import find_windows
from core.recording.reader import RecordingError, read_recording
from core.recording.schema import to_plain
from core.registry import game_of
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol, protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from tests.core.sessions import simulated

EXACT = KeepawayConfig(exact_state=True)
SHORT = SessionConfig(episodes=3, unseen_between=2, watched_steps=60, unseen_steps=60)
SCHEMES = {"linear": Linear(), "exponential": Exponential(), "control sharing": ControlSharing()}


def keepaway(*, press_probability: float = 0.9, scheme=None, **changes) -> Protocol:
    """A session of seconds with a participant who presses often."""
    settings = {
        "domain": EXACT,
        "session": SHORT,
        "screen": ScreenConfig(),
        "agent": msgspec.structs.replace(KEEPAWAY.agent, scheme=scheme or Exponential()),
        "trainer": msgspec.structs.replace(KEEPAWAY.trainer, press_probability=press_probability),
    }
    return msgspec.structs.replace(KEEPAWAY, **settings | changes)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return simulated(tmp_path_factory.mktemp("keepaway"), keepaway())


def of(kind, recording) -> list:
    return [event for event in recording.events if isinstance(event, kind)]


@pytest.mark.parametrize("scheme", SCHEMES.values(), ids=SCHEMES)
def test_a_session_is_replayed_bit_for_bit(tmp_path, scheme):
    recording = simulated(tmp_path, keepaway(scheme=scheme))
    again = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    result = replay_exactly(recording, again)
    assert result.difference is None
    assert result.outputs == len(recording.outputs) > 10
    assert of(CreditGiven, recording)


def test_another_seed_is_not_the_same_session(recording):
    other = build_session(keepaway(), recording.header.root_seed + 1)
    assert replay_exactly(recording, other).difference is not None


def test_steps_are_decisions_and_stay_on_screen_until_the_next_one(recording):
    shown = {frame.step: frame.flushed_ns for frame in of(FrameShown, recording) if frame.step >= 0}
    steps = of(StepTaken, recording)
    for step, following in itertools.pairwise(steps):
        if step.episode != following.episode:
            continue
        cycles = following.detail["cycle"] - step.detail["cycle"]
        assert shown[following.step] - shown[step.step] == cycles * CYCLE_NS
        assert step.reward == pytest.approx(cycles * 0.1)
        assert (
            cycles == 1 or step.detail["target"] >= 0 or following.detail["keeper"] != step.detail["keeper"]
        )
    assert {step.detail["keeper"] for step in steps} == {0, 1, 2}
    assert any(step.detail["target"] >= 0 for step in steps)
    assert any(step.detail["target"] == NO_PLAYER for step in steps)


def test_no_step_is_on_screen_before_the_first_decision_nor_after_the_end(recording):
    frames = [frame.step for frame in of(FrameShown, recording)]
    for started in of(EpisodeStarted, recording):
        first = next(step for step in of(StepTaken, recording) if step.episode == started.episode)
        assert frames[frames.index(first.step) - 1] == -1
    assert frames[-1] == -1


def test_the_performance_of_an_episode_is_its_duration_in_seconds(recording):
    for ended in of(EpisodeEnded, recording):
        first, *_, last = [step for step in of(StepTaken, recording) if step.episode == ended.episode]
        kicked_off_s = first.detail["cycle"] * 0.1
        assert ended.performance == pytest.approx(last.detail["cycle"] * 0.1 + last.reward)
        assert ended.performance > kicked_off_s > 0


def test_at_most_two_presses_count_in_an_episode(recording):
    counted = {}
    episode = -1
    for event in recording.events:
        if isinstance(event, EpisodeStarted):
            episode = event.episode
        elif isinstance(event, KeyPressed) and event.verdict == "accepted":
            counted[episode] = counted.get(episode, 0) + 1
    assert max(counted.values()) == 2


def test_every_accepted_press_is_accounted_for(recording):
    given = of(CreditGiven, recording)
    accepted = [press for press in of(KeyPressed, recording) if press.verdict == "accepted"]
    assert [credit.press for credit in given] == [press.press for press in accepted]
    for credit in given:
        assert sum(credit.shares) + credit.before_first + credit.in_gaps == pytest.approx(1.0)
    assert any(len(credit.steps) > 1 for credit in given)


def test_slow_motion_stretches_the_time_and_leaves_the_game(tmp_path):
    silent = keepaway(press_probability=0.0)
    slow = msgspec.structs.replace(silent, screen=ScreenConfig(speed=0.5))
    (tmp_path / "slow").mkdir()
    one, other = simulated(tmp_path, silent), simulated(tmp_path / "slow", slow)
    pairs = list(zip(of(StepTaken, one), of(StepTaken, other), strict=True))
    assert all(a.detail == b.detail and a.reward == b.reward for a, b in pairs)
    start, slow_start = of(FrameShown, one)[0].flushed_ns, of(FrameShown, other)[0].flushed_ns
    first, slow_first = of(FrameShown, one)[1].flushed_ns, of(FrameShown, other)[1].flushed_ns
    assert slow_first - slow_start == 2 * (first - start) > 0
    assert [e.performance for e in of(EpisodeEnded, one)] == [e.performance for e in of(EpisodeEnded, other)]


def test_without_a_person_it_is_plain_sarsa(tmp_path):
    protocol = keepaway(press_probability=0.0, session=msgspec.structs.replace(SHORT, watched_steps=10_000))
    recording = simulated(tmp_path, protocol, root_seed=8)
    game = game_of(protocol)
    coder = game.domain(protocol).coder
    sarsa = new_sarsa(protocol.learner, coder, 3, 3)
    durations = []
    for episode in (0, 3, 6):
        for number in range(episode - 2, episode) if episode else ():
            durations_of_unseen(sarsa, coder, number)
        durations.append(durations_of_unseen(sarsa, coder, episode))
    assert [ended.performance for ended in of(EpisodeEnded, recording)] == pytest.approx(durations)


def durations_of_unseen(sarsa, coder, episode: int) -> float:
    """Play an episode of root seed 8 with keepers that learn alone; return its duration in seconds."""
    play = DecisionPlay(EXACT, stream_seed(8, "episode", episode))
    rng = stream(8, "explore", episode)
    play.begin()
    windows = np.zeros(13, np.int64)
    while play.keeper != NO_PLAYER:
        find_windows(coder, play.variables, windows)
        play.decide(decide(sarsa, play.keeper, windows, play.cycle, rng))
    end_episode(sarsa, play.cycle)
    return play.cycle * 0.1


def test_a_killed_session_is_replayed_up_to_there(recording, tmp_path):
    lines = recording.path.read_bytes().splitlines(keepends=True)
    for kept in (len(lines) // 3, len(lines) // 2, len(lines) - 2):
        path = tmp_path / f"{kept}.jsonl"
        path.write_bytes(b"".join(lines[:kept]) + lines[kept][:20])
        cut = read_recording(path, allow_truncated=True)
        assert not cut.complete
        assert replay_exactly(cut, build_session(keepaway(), cut.header.root_seed)).difference is None
        with pytest.raises(RecordingError):
            read_recording(path, allow_truncated=False)


class Leaves:
    """A participant who sees each step and ends the session at one of them."""

    def __init__(self, at: int, reason: str) -> None:
        self.at, self.reason, self.inputs = at, reason, 0

    def during(self, step: int):
        self.inputs += 1
        shown = [FrameShown(frame=self.inputs, step=step, flushed_ns=self.inputs * 100_000_000)]
        return (
            [*shown, StopAsked(time_ns=self.inputs * 100_000_000, reason=self.reason)]
            if step == self.at
            else shown
        )


@pytest.mark.parametrize("reason", ["participant", "worker-died"])
def test_a_stopped_session_truncates_the_episode_and_learns_nothing_of_its_last_options(reason):
    session = build_session(keepaway(), 5)
    *_, ended, last = session.run(Leaves(2, reason), ManualClock())
    assert isinstance(ended, EpisodeEnded)
    assert (ended.ended, ended.steps) == ("truncation", 3)
    assert isinstance(last, SessionEnded)
    assert last.reason == reason


def test_learning_again_by_the_same_rules_gives_the_same_agent(recording):
    protocol = keepaway()
    steps = watched_steps(recording, protocol)
    again = relearn(recording, protocol, steps, root_seed=recording.header.root_seed)
    assert again.agent.digest() == recording.outputs[-1].digest
    assert again.trust == [ended.trust for ended in of(EpisodeEnded, recording)]
    assert again.credits == of(CreditGiven, recording)


def test_another_credit_rule_learns_something_else_from_the_same_presses(recording):
    agent = msgspec.structs.replace(keepaway().agent, credit=CreditConfig(delay=CurrentStep()))
    protocol = keepaway(agent=agent)
    steps = watched_steps(recording, protocol)
    other = relearn(recording, protocol, steps, root_seed=recording.header.root_seed)
    assert all(len(given.steps) <= 1 for given in other.credits)
    assert [given.press for given in other.credits] == [given.press for given in of(CreditGiven, recording)]
    assert other.agent.digest() != recording.outputs[-1].digest


def test_evaluating_teaches_nothing(recording):
    protocol = keepaway()
    game = game_of(protocol)
    steps = watched_steps(recording, protocol)
    agent = relearn(recording, protocol, steps, root_seed=recording.header.root_seed).agent
    before = agent.digest()
    played = game.evaluate(protocol, agent, [1, 2, 3], max_steps=200)
    assert agent.digest() == before
    assert played == game.evaluate(protocol, agent, [1, 2, 3], max_steps=200)
    assert len({episode.performance for episode in played}) == 3


def test_the_human_is_trusted_after_an_episode_in_which_both_could_be_compared(recording):
    assert next(started.weight for started in of(EpisodeStarted, recording)) == 0.0
    assert 0.0 < of(EpisodeEnded, recording)[-1].trust <= 1.0
    assert of(EpisodeStarted, recording)[-1].form == 1  # the exponential scheme
    assert all(len(played.policies) == 2 for played in of(UnseenPlayed, recording))
    # Every episode is a policy of its own.
    assert [started.policy for started in of(EpisodeStarted, recording)] == [0, 3, 6]


def test_a_person_who_is_obeyed_changes_what_is_done(tmp_path):
    (tmp_path / "alone").mkdir()
    # One model for all keepers: what is said of one guides the keeper who decides last.
    listens = msgspec.structs.replace(
        KEEPAWAY.agent, scheme=Constant(w_h=50.0), human_model=TileModel(shared=True)
    )
    obeyed = simulated(tmp_path, keepaway(agent=listens))
    alone = simulated(tmp_path / "alone", keepaway(scheme=EnvironmentOnly()))
    of_both = [[(s.detail["cycle"], s.action) for s in of(StepTaken, r)] for r in (obeyed, alone)]
    assert of_both[0] != of_both[1]
    followed = [s.action == s.human_action for s in of(StepTaken, obeyed)[-10:]]
    assert sum(followed) >= 9  # one in a hundred explores


# --- protocols ----------------------------------------------------------------------------------------------


def test_a_protocol_of_keepaway_says_only_what_differs_from_its_own_defaults(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(
        'name = "pilot"\n[domain]\ntype = "keepaway"\nn_keepers = 4\n[learner]\ntrace_decay = 0.5\n'
    )
    protocol = load_protocol(path)
    assert protocol.game == "keepaway"
    assert protocol.domain == KeepawayConfig(n_keepers=4)
    assert protocol.learner.trace_decay == 0.5
    assert protocol.keys.max_presses_per_episode == 2
    assert protocol.agent.credit.delay == GammaDelay()
    assert protocol.agent.human_model == TileModel()
    path.write_text('name = "pilot"\n')
    assert load_protocol(path, game="keepaway").domain == KeepawayConfig()
    assert load_protocol(path).game == "tetris"


def test_a_protocol_comes_back_from_a_recordings_header():
    for protocol in (keepaway(), KEEPAWAY, Protocol()):
        assert protocol_from(to_plain(protocol)) == protocol


def test_a_recording_from_before_there_was_a_second_game_is_one_of_tetris():
    plain = to_plain(Protocol())
    for table in ("domain", "learner"):
        del plain[table]["type"]
    assert protocol_from(plain) == Protocol()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[domain]\ntype = "chess"\n', r'\[domain\] type = "chess": expected one of "tetris", "keepaway"'),
        ('[domain]\ntype = "keepaway"\nplayers = 3\n', r"\[domain\] players = 3: there is no such key"),
        ('[domain]\ntype = "keepaway"\n[learner]\ntype = "cross-entropy"\n', "one of the learners sarsa"),
        ('[learner]\ntype = "sarsa"\n', "one of the learners cross-entropy"),
        ('[domain]\ntype = "keepaway"\n[agent.human_model]\ntype = "ridge"\n', "of type tiles"),
        (
            '[domain]\ntype = "keepaway"\n[agent.bootstrap.trust]\nmeasured = "window"\n',
            "changes at every step",
        ),
        (
            '[domain]\ntype = "keepaway"\n[agent.bootstrap.trust]\ntype = "side-by-side"\n',
            "has one learner",
        ),
        (
            "[screen]\nspeed = 9.0\n",
            r"\[screen\] speed = 9\.0: expected a number 0\.05 to 5 simulated seconds",
        ),
    ],
)
def test_what_does_not_go_together_is_refused(tmp_path, text, message):
    path = tmp_path / "study.toml"
    path.write_text(text)
    with pytest.raises(ProtocolError, match=rf"study\.toml:\d+: .*{message}"):
        load_protocol(path)


def test_a_human_model_of_another_kind_is_refused_in_python_too():
    with pytest.raises(ValueError, match="of type tiles"):
        keepaway(agent=AgentConfig(human_model=RidgeModel()))


def test_the_header_names_what_is_done_otherwise_than_in_the_paper():
    text = " ".join(keepaway(screen=ScreenConfig(speed=0.5)).departures())
    for part in ("our own", "one model per keeper", "0.5 times", "exact state", "mean 0.75 s", "one policy"):
        assert part in text
    assert "Keepaway" not in " ".join(Protocol().departures())
