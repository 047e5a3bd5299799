"""What-ifs judge an agent at the moment that its session has reached, under every scheme."""

import dataclasses

import msgspec
import numpy as np
import pytest

from core.combination.config import SCHEMES, AgentConfig, Annealed, EnvironmentOnly
from core.combination.schedule import EpisodesSoFar
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.source import SimulatedParticipant
from core.feedback.trainers import SimulatedTrainer, TrainerConfig
from core.keepaway.plugin import KEEPAWAY
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.numerics.clock import ManualClock
from core.numerics.streams import stream_seed
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from core.recording.schema import Header, to_plain
from core.registry import game_of
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.rollout import play_unseen
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from studies.what_if import WhatIfSettings, judge, scheme_named, what_if
from tests.core.sessions import small_protocol

QUICK = WhatIfSettings(games=6, piece_cap=60)
FALLING = [kind for kind in SCHEMES.values() if "decay" in kind.__struct_fields__]
ACTORS = ("reward-shaping", "coach")
CASES = [(tag, kind()) for tag, kind in SCHEMES.items()] + [
    (kind().__struct_config__.tag, kind(per="episode")) for kind in FALLING
]


def protocol_under(tag, scheme):
    """Return a session of seconds of a game and a learner that the scheme can teach."""
    session = SessionConfig(episodes=3, unseen_between=8, watched_steps=10, unseen_steps=60)
    if tag == "q-augmentation":
        return msgspec.structs.replace(
            KEEPAWAY,
            agent=msgspec.structs.replace(KEEPAWAY.agent, scheme=scheme),
            session=msgspec.structs.replace(session, unseen_between=2, watched_steps=40),
            keys=KeyConfig(max_presses_per_episode=5),
            trainer=TrainerConfig(press_probability=1.0, max_presses=5),
        )
    changes = {"agent": AgentConfig(scheme=scheme), "session": session}
    if tag in ACTORS:
        proposed = msgspec.structs.replace(session, watched="proposed")
        changes |= {"learner": PolicyGradientConfig(), "session": proposed}
    return small_protocol(**changes)


def played(protocol, root_seed, path):
    """Play and record a session; return its own agent as it is at the end."""
    clock, session, game = ManualClock(), build_session(protocol, root_seed), game_of(protocol)
    participant = SimulatedParticipant(
        session.domain,
        game.oracle(protocol),
        SimulatedTrainer(protocol.trainer, root_seed=root_seed),
        PressGate(protocol.keys),
        clock,
        game.viewing(protocol),
    )
    header = Header(
        origin="simulated",
        created_utc="2026-11-28T00:00:00+00:00",
        clock="simulated",
        clock_resolution_ns=1,
        started_ns=0,
        participant="simulated",
        root_seed=root_seed,
        protocol=to_plain(protocol),
        software={},
    )
    writer = LineWriter(path, header)
    for output in session.run(participant, clock):
        for event in (output, *participant.watch(output)):
            writer.write(event)
    writer.close()
    return session.agent


@pytest.mark.parametrize(("tag", "scheme"), CASES, ids=lambda value: value if isinstance(value, str) else "")
def test_a_what_if_under_the_sessions_own_rules_judges_the_sessions_own_agent(tag, scheme, tmp_path):
    protocol = protocol_under(tag, scheme)
    own = played(protocol, 4, tmp_path / "s.jsonl")
    recording = read_recording(tmp_path / "s.jsonl")
    again = relearn(
        recording, protocol, watched_steps(recording, protocol), root_seed=recording.header.root_seed
    ).agent
    assert own.human.knows_something
    assert again.so_far == own.so_far
    assert again.so_far.watched == 3
    assert again.so_far.episodes == 3 + 2 * protocol.session.unseen_between
    assert again.final_policy().episode_weights == own.final_policy().episode_weights
    expected, _ = judge(own, protocol, QUICK)
    (row,) = what_if(recording.path, protocol, [protocol.agent.credit.delay], [tag], QUICK)
    assert row.lines.estimate == expected.mean()
    assert (row.episode, row.watched) == (own.so_far.episodes, 3)
    assert (row.weight, row.handover, row.shaping) == dataclasses.astuple(own.final_policy().episode_weights)[
        2:5
    ]
    # Being judged leaves an agent where it was.
    assert own.so_far == again.so_far
    np.testing.assert_array_equal(judge(own, protocol, QUICK)[0], expected)


@pytest.mark.parametrize("kind", FALLING)
def test_a_weight_that_falls_with_episodes_is_judged_after_all_of_them(kind, tmp_path):
    tag = kind().__struct_config__.tag
    by_game, by_episode = kind(), kind(per="episode")
    protocol = protocol_under(tag, by_game)
    played(protocol, 4, tmp_path / "s.jsonl")
    games, episodes = what_if(
        tmp_path / "s.jsonl", protocol, [protocol.agent.credit.delay], [tag, f"{tag}:episode"], QUICK
    )

    def used(scheme, number):
        return dataclasses.astuple(scheme.episode_weights(0.0, number))[2:5]

    assert (games.weight, games.handover, games.shaping) == used(by_game, 3)
    assert (episodes.weight, episodes.handover, episodes.shaping) == used(by_episode, games.episode)
    assert (games.rule, episodes.rule) == (f"{tag}:watched-game", f"{tag}:episode")
    assert games.episode == 3 + 2 * protocol.session.unseen_between


def test_annealed_after_many_episodes_is_the_environment_alone_decision_by_decision(tmp_path):
    annealed = protocol_under("annealed", Annealed(per="episode"))
    agents = {}
    for name, scheme in (("annealed", annealed.agent.scheme), ("alone", EnvironmentOnly())):
        agents[name] = played(annealed, 4, tmp_path / f"{name}.jsonl")
        # The same agent: only how it decides from here on differs.
        agents[name].config = msgspec.structs.replace(agents[name].config, scheme=scheme)
    domain = game_of(annealed).domain(annealed)
    differs_early = False
    for so_far, alike in ((EpisodesSoFar(1, 1), False), (EpisodesSoFar(910, 10), True)):
        actions = {}
        for name, agent in agents.items():
            agent.so_far = so_far
            actions[name] = []
            for game in range(5):
                state, policy = domain.initial(stream_seed(0, "judged", game)), agent.final_policy()
                for step in range(40):
                    if domain.terminal(state):
                        break
                    action = agent.choose(domain.choices(state), policy, step=step).action
                    actions[name].append(action)
                    state = domain.transition(state, action).next_state
        if alike:
            assert actions["annealed"] == actions["alone"]
            assert len(actions["alone"]) > 50
        else:
            differs_early = actions["annealed"] != actions["alone"]
    assert differs_early  # with its first weight, 0.98, the participant does decide


def test_an_unseen_episode_does_not_move_a_weight_that_falls_with_games():
    protocol = protocol_under("annealed", Annealed())
    session = build_session(protocol, 4)
    agent = session.agent
    for _ in range(50):
        policy = agent.begin_episode(exploring=True, watched=False)
        agent.learn_from_domain(policy, play_unseen(session.domain, agent, policy, policy.episode, 5))
    assert agent.next_episode.scheduled == 0
    agent.begin_episode(exploring=False, watched=True)
    assert (agent.next_episode.number, agent.next_episode.scheduled) == (51, 1)


def test_rows_are_compared_with_the_first_one_by_seed(tmp_path):
    protocol = protocol_under("linear", SCHEMES["linear"]())
    played(protocol, 4, tmp_path / "s.jsonl")
    delay = protocol.agent.credit.delay
    first, same, other = what_if(
        tmp_path / "s.jsonl", protocol, [delay], ["linear", "linear", "human-only"], QUICK
    )
    assert first.difference is None
    assert (same.difference.estimate, same.difference.low, same.difference.high) == (0.0, 0.0, 0.0)
    assert other.difference.estimate == pytest.approx(other.lines.estimate - first.lines.estimate)
    assert other.difference.low <= other.difference.estimate <= other.difference.high


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("linear:episode", "the weight of linear does not fall; those of annealed, action-biasing"),
        ("annealed:game", "a weight falls per watched-game or per episode, as in annealed:episode"),
        ("nope:episode", "unknown scheme 'nope': use one of linear"),
    ],
)
def test_a_schedule_that_does_not_exist_is_refused(name, reason):
    with pytest.raises(ValueError, match=reason):
        scheme_named(name, Annealed())


def test_a_sessions_own_settings_count_where_its_own_scheme_is_asked_for():
    own = Annealed(beta_0=0.5, per="episode")
    assert scheme_named("annealed", own) == own
    assert scheme_named("annealed:watched-game", own) == Annealed(beta_0=0.5)
    assert scheme_named("control-sharing", own) == SCHEMES["control-sharing"]()
    assert protocol_from(to_plain(protocol_under("annealed", own))).agent.scheme == own
