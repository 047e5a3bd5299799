"""Policy gradient under the eyes of a simulated person."""

import msgspec
import numpy as np
import pytest

from core.combination.config import AgentConfig, EnvironmentOnly
from core.feedback.trainers import TrainerConfig
from core.learners.policy_gradient import PolicyGradient, PolicyGradientConfig
from core.numerics.compiled import JIT_DISABLED
from core.numerics.streams import stream_seed
from core.session.protocol import Protocol, SessionConfig
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.config import TetrisConfig
from core.tetris.policy_gradient import placement_scales
from core.tetris.sessions import open_game
from studies.experiments.tetris_trial import new_trial, run_trial
from tests.core.tetris.playing import play_policy_gradient

EPISODES = 6 if JIT_DISABLED else 30
RULES = TetrisConfig(rows=12, columns=6, placements="all")


def settings(**trainer) -> Protocol:
    return Protocol(
        domain=RULES,
        session=SessionConfig(episodes=EPISODES, unseen_between=0, watched="proposed", watched_steps=60),
        trainer=TrainerConfig(**({"press_probability": 0.2} | trainer)),
        learner=PolicyGradientConfig(),
    )


def test_without_a_word_the_learner_plays_and_learns_as_alone():
    rows = run_trial(settings(press_probability=0.0), 4)
    alone = PolicyGradient(PolicyGradientConfig(), scales=placement_scales(RULES))
    for episode in range(EPISODES):
        played = play_policy_gradient(
            alone,
            np.zeros(13),
            stream_seed(4, "episode", episode),
            RULES,
            chance_seed=stream_seed(4, "softmax", episode) >> 1,
            piece_cap=60,
        )
        assert (played.lines, played.pieces) == (rows["lines"][episode], rows["pieces"][episode])


def test_a_person_without_a_say_changes_nothing_but_the_presses():
    silent = run_trial(settings(press_probability=0.0), 4)
    protocol = msgspec.structs.replace(settings(), agent=AgentConfig(scheme=EnvironmentOnly()))
    heard = run_trial(protocol, 4)
    assert heard["lines"].tolist() == silent["lines"].tolist()
    assert heard["presses"].sum() > 0


def test_a_person_with_a_say_is_heard():
    rows = run_trial(settings(), 4)
    assert rows["presses"].max() <= 5
    assert (rows["w_h"] > 0).any()
    again = run_trial(settings(), 4)
    assert all(np.array_equal(rows[name], again[name]) for name in rows)


def test_the_boards_that_are_judged_are_those_that_were_played():
    trial = new_trial(settings(), 4)
    domain = Tetris(RULES)
    policy = trial.agent.begin_episode(exploring=True, watched=True)
    game = open_game(trial.agent, policy, 99, RULES, window=60)
    game.advance(60)
    assert game.pieces > 5
    state = domain.initial(99)
    for step in range(game.pieces):
        columns, action = game.kept(step)
        assert TetrisState(columns, 99, step, state.lines) == state
        state = domain.transition(state, action).next_state
    assert state.lines == game.lines
    with pytest.raises(ValueError, match="not one of the last"):
        game.kept(game.pieces)
