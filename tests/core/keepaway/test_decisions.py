"""Keepaway from decision to decision: what a step is, and that it is the game that experiments play."""

import numpy as np
import pytest

from core.keepaway.decisions import DecisionPlay
from core.keepaway.domain import HOLD, Keepaway, KeepawayState
from core.keepaway.pitch import (
    AUTOPLAY_CYCLE_LIMIT,
    KICK_DISTANCE,
    NO_PLAYER,
    ONGOING,
    OUT,
    TAKEN,
    KeepawayConfig,
    X,
    Y,
)
from core.keepaway.simulator.game import step_cycle
from core.keepaway.simulator.match import (
    CYCLE,
    END,
    HOLD_BALL,
    OPTION,
    PASS_BALL,
    TARGET,
    new_match,
    open_streams,
)
from core.keepaway.simulator.policies import HAND_CODED, hand_coded

EXACT = KeepawayConfig(exact_state=True)
CONFIGS = {"exact": EXACT, "noisy": KeepawayConfig(), "4v3": KeepawayConfig(4, 3, 25.0, 25.0)}


def advice(play: DecisionPlay, config: KeepawayConfig) -> int:
    return hand_coded(play.variables, config.n_keepers, config.n_takers)


@pytest.mark.parametrize("config", CONFIGS.values(), ids=CONFIGS)
@pytest.mark.parametrize("seed", range(3))
def test_an_episode_played_by_decisions_is_the_one_played_as_a_whole(config, seed):
    play = DecisionPlay(config, seed)
    play.begin()
    while play.keeper != NO_PLAYER:
        play.decide(advice(play, config))
    streams = open_streams(seed)
    match = new_match(config, streams)
    while not step_cycle(match, config.rules(), HAND_CODED, streams):
        assert match.status[CYCLE] < AUTOPLAY_CYCLE_LIMIT
    assert play.cycle == match.status[CYCLE] > 10
    assert play.ended == match.status[END] != ONGOING
    np.testing.assert_array_equal(play.match.ball, match.ball)
    np.testing.assert_array_equal(play.match.players, match.players)


def test_watching_every_cycle_changes_nothing():
    alone, watched = DecisionPlay(EXACT, 4), DecisionPlay(EXACT, 4)
    cycles = [0]

    def note(match):
        cycles.append(int(match.status[CYCLE]))

    alone.begin()
    watched.begin(note)
    while alone.keeper != NO_PLAYER:
        alone.decide(advice(alone, EXACT))
        watched.decide(advice(watched, EXACT), note)
    assert watched.keeper == NO_PLAYER
    assert cycles == list(range(watched.cycle + 1))
    np.testing.assert_array_equal(alone.match.players, watched.match.players)


def test_nobody_decides_before_the_ball_has_been_fetched():
    for seed in range(5):
        state = Keepaway(EXACT).initial(seed)
        me = state.match.players[state.keeper]
        assert state.cycle > 0
        assert np.hypot(*(me[: Y + 1] - state.match.ball[: Y + 1])) < KICK_DISTANCE


def test_a_hold_ends_after_one_cycle():
    domain = Keepaway(EXACT)
    state = domain.initial(1)
    for _ in range(5):
        following = domain.transition(state, HOLD)
        assert following.reward == pytest.approx(0.1)
        assert following.next_state.cycle == state.cycle + 1
        assert following.next_state.keeper == state.keeper
        state = following.next_state


def test_a_pass_ends_when_another_keeper_decides():
    domain = Keepaway(EXACT)
    caught = 0
    for seed in range(10):
        state = domain.initial(seed)
        target = domain.action_record(state, 1).plain()["target"]
        following = domain.transition(state, 1).next_state
        if domain.terminal(following):
            assert following.ended in (OUT, TAKEN)
            continue
        assert following.keeper != state.keeper
        caught += following.keeper == target
        assert following.cycle - state.cycle > 3  # the ball has to get there
    assert caught >= 5


def test_a_step_names_keeper_cycle_and_receiver():
    domain = Keepaway(EXACT)
    state = domain.initial(2)
    order = [int(player) for player in state.match.order[state.keeper, :3]]
    assert order[0] == state.keeper
    for action in (1, 2):
        assert domain.action_record(state, action).plain() == {
            "keeper": state.keeper,
            "cycle": state.cycle,
            "target": order[action],
        }
    assert domain.action_record(state, HOLD).plain()["target"] == NO_PLAYER


def two_at_the_ball() -> KeepawayState:
    """A match in which two keepers can kick the ball."""
    domain = Keepaway(EXACT)
    state = domain.initial(3)
    play = DecisionPlay.resumed(EXACT, state.saved)
    other = (state.keeper + 1) % 3
    play.match.players[other, :4] = play.match.players[state.keeper, :4] + (0.7, 0.0, 0.0, 0.0)
    play.match.ball[:] = (
        *((play.match.players[state.keeper, :2] + play.match.players[other, :2]) / 2),
        0.0,
        0.0,
    )
    play.match.actions[:] = HOLD
    play.match.deciding[:] = False
    play.begin()  # the cycle begins anew, with the ball between the two
    return KeepawayState(play.save())


def test_two_keepers_with_the_ball_decide_one_after_the_other_in_the_same_moment():
    state = two_at_the_ball()
    domain = Keepaway(EXACT)
    assert state.match.deciding.sum() == 2
    first, second = np.flatnonzero(state.match.deciding)
    assert state.keeper == first
    between = domain.transition(state, HOLD)
    assert between.next_state.keeper == second
    assert between.next_state.cycle == state.cycle
    assert between.reward == 0.0
    after = domain.transition(between.next_state, 1).next_state
    assert after.cycle > state.cycle
    passing = DecisionPlay.resumed(EXACT, between.next_state.saved)
    seen = []
    passing.decide(1, lambda match: seen.append(match.options.copy()))
    # Both options have begun: the first keeper holds, the second one passes.
    assert seen[0][first, OPTION] == HOLD_BALL
    assert seen[0][second, OPTION] == PASS_BALL
    assert seen[0][second, TARGET] == domain.action_record(between.next_state, 1).plain()["target"]


def test_an_old_state_can_be_gone_back_to():
    domain = Keepaway()
    early = domain.initial(6)
    once = domain.transition(early, 1)
    late = once.next_state
    for _ in range(3):
        if not domain.terminal(late):
            late = domain.transition(late, HOLD).next_state
    again = domain.transition(early, 1)
    assert again == once
    assert again.next_state is not once.next_state
    assert domain.transition(early, 2) != once


def test_nobody_decides_after_the_end():
    play = DecisionPlay(EXACT, 1)
    play.begin()
    while play.keeper != NO_PLAYER:
        play.decide(1)
    with pytest.raises(ValueError, match="nobody has to decide"):
        play.decide(0)
    assert play.match.ball[X] == play.match.ball[X]
