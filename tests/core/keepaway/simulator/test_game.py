"""A match: resets, referee, options, decisions, determinism, and the two speeds of the one loop."""

import copy

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.keepaway.autoplay import Autoplay, keepaway_tiles, learn_cycle
from core.keepaway.pitch import DROP_DISTANCE, NECK, ONGOING, OUT, PLAYER_RADIUS, TAKEN, KeepawayConfig, X
from core.keepaway.simulator import match as m
from core.keepaway.simulator.game import begin_cycle, finish_cycle, step_cycle
from core.keepaway.simulator.match import drop_ball, is_stuck, new_match, open_streams, referee, start_episode
from core.keepaway.simulator.policies import POLICIES, choose
from core.learners.sarsa import SarsaConfig, new_sarsa
from core.numerics.streams import stream

EXACT = KeepawayConfig(exact_state=True)


def fresh(config=EXACT, seed=1):
    streams = open_streams(seed, "test")
    return new_match(config, streams), config.rules(), streams


def look(match, rules, ball, keeper=(5.0, 5.0), taker=(-5.0, 5.0)):
    match.players[:, :2] = 9.0, -9.0
    match.players[0, :2], match.players[3, :2] = keeper, taker
    match.ball[:2] = ball
    referee(match.ball, match.players, match.status, rules)
    return match.status[m.TAKE_COUNT], match.status[m.END]


def test_a_ball_on_the_edge_of_the_region_is_out():
    match, rules, _ = fresh()
    assert look(match, rules, (0.0, 9.999))[1] == ONGOING
    assert look(match, rules, (0.0, -10.0))[1] == OUT


def test_four_counted_cycles_are_a_take_one_cycle_later():
    match, rules, _ = fresh()
    for count in (1, 2, 3, 4):
        assert look(match, rules, (-5.0, 5.0)) == (count, ONGOING)
    assert look(match, rules, (-5.0, 5.0))[1] == TAKEN


def test_a_loose_ball_keeps_the_count_and_a_keeper_alone_resets_it():
    match, rules, _ = fresh()
    assert look(match, rules, (-5.0, 5.0))[0] == 1
    assert look(match, rules, (0.0, 0.0))[0] == 1
    assert look(match, rules, (5.0, 5.0), taker=(5.5, 5.0))[0] == 2
    assert look(match, rules, (5.0, 5.0))[0] == 0


@given(st.integers(0, 2**32), st.sampled_from([(3, 2), (4, 3), (5, 4)]), st.sampled_from([15.0, 20.0, 35.0]))
@settings(max_examples=20, deadline=None)
def test_a_reset_fills_three_corners_with_keepers_and_the_fourth_with_takers(seed, sizes, side):
    match, _, _ = fresh(KeepawayConfig(*sizes, side, side), seed)
    half = side / 2
    corners = np.abs(match.players[:3, :2])
    assert ((corners >= half - 3) & (corners <= half)).all()
    assert not ((match.players[:3, 0] < 0) & (match.players[:3, 1] > 0)).any()
    assert (np.abs(match.players[3 : sizes[0], :2]) <= 1).all()
    takers = match.players[sizes[0] :, :2]
    assert (takers[:, 0] <= 3 - half).all()
    assert (takers[:, 1] >= half - 3).all()
    assert match.ball.tolist() == [4 - half, 4 - half, 0, 0]


def test_a_reset_keeps_body_and_neck():
    match, rules, streams = fresh()
    before = match.players[:, 4:].copy()
    start_episode(match, rules, streams.placement)
    np.testing.assert_array_equal(match.players[:, 4:], before)


def test_a_ball_stuck_for_100_cycles_is_dropped_and_players_put_back():
    match, _, _ = fresh()
    match.ball[:] = 1.0, 2.0, 0.1, 0.0
    match.players[0, :4] = 1.0, 3.0, 0.3, 0.3
    for cycle in range(101):
        match.status[m.CLOCK] = cycle
        assert is_stuck(match) == (cycle == 100)
    drop_ball(match)
    assert match.ball.tolist() == [1.0, 2.0, 0.0, 0.0]
    assert match.players[0, :4].tolist() == pytest.approx([1.0, 2.0 + 9.45, 0.0, 0.0])


def test_players_put_back_to_the_same_place_are_parted_in_the_same_cycle():
    match, rules, streams = fresh()
    match.ball[:] = 0.0, 0.0, 0.0, 0.0
    match.players[:, :4] = [[-8, 8, 0, 0], [8, 8, 0, 0], [8, -8, 0, 0], [3.0, 0, 0, 0], [4.5, 0, 0, 0]]
    match.stuck[:] = 0.0, 0.0, -100.0
    step_cycle(match, rules, POLICIES["hold"], streams)
    takers = match.players[3:, :2]
    assert np.linalg.norm(takers[0] - takers[1]) == pytest.approx(2 * PLAYER_RADIUS)
    # Side by side on the circle: each 0.3 m off its point of it.
    assert np.linalg.norm(takers, axis=1) == pytest.approx(
        np.full(2, np.hypot(DROP_DISTANCE, PLAYER_RADIUS)), abs=0.01
    )
    assert match.hit.tolist() == [False, False, False, False, True, True]


def test_the_clock_of_a_stuck_ball_looks_at_the_last_cycle_of_an_episode_too():
    match, rules, streams = fresh()
    match.status[m.CLOCK] = 50
    match.stuck[:] = -6.0, -6.0, 10.0
    match.ball[:] = -9.99, -1.0, -1.0, 0.0
    step_cycle(match, rules, POLICIES["hold"], streams)
    assert match.status[m.END] == OUT
    assert match.stuck[2] == 51
    assert match.stuck[X] < -10


def episode(match, rules, streams, policy="random"):
    rows = [match.players.copy()]
    while not step_cycle(match, rules, POLICIES[policy], streams):
        rows.append(match.players.copy())
    return rows


@pytest.mark.jit
@pytest.mark.parametrize("config", [EXACT, KeepawayConfig(), KeepawayConfig(view_angle_deg=90.0)])
def test_the_same_seed_gives_the_same_episode_and_another_seed_another(config):
    first, again, other = (episode(*fresh(config, seed)) for seed in (4, 4, 5))
    assert np.array_equal(first, again)
    assert len(first) != len(other) or not np.array_equal(first, other)


@pytest.mark.jit
def test_whole_episodes_are_the_cycles_of_the_live_loop():
    config = KeepawayConfig()
    compiled = Autoplay(config, 9, "speeds").play("random", 4)
    streams = open_streams(9, "speeds")
    match, rules = new_match(config, streams), config.rules()
    lengths = []
    for e in range(4):
        if e:
            start_episode(match, rules, streams.placement)
        while True:
            if begin_cycle(match, rules, streams):
                for i in np.flatnonzero(match.deciding):
                    match.actions[i] = choose(POLICIES["random"], match.variables[i], 3, 2, streams.policy)
            if finish_cycle(match, rules, streams):
                break
        lengths.append(match.status[m.CYCLE])
    assert compiled.cycles.tolist() == lengths


@pytest.mark.jit
def test_learning_cycle_by_cycle_is_learning_in_whole_episodes():
    config = KeepawayConfig()
    weights = []
    for live in (False, True):
        game = Autoplay(config, 9, "learning")
        sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(config), 3, 3)
        if live:
            windows = np.zeros(13, np.int64)
            for e in range(3):
                if e:
                    start_episode(game.match, game.rules, game.streams.placement)
                while not learn_cycle(game.match, game.rules, sarsa, windows, game.streams):
                    pass
        else:
            game.learn(sarsa, 3)
        weights.append(sarsa.weights)
    assert weights[0].any()
    np.testing.assert_array_equal(*weights)


@pytest.mark.jit
def test_a_snapshot_goes_on_like_the_match_it_was_taken_from():
    match, rules, streams = fresh(KeepawayConfig())
    for _ in range(10):
        step_cycle(match, rules, POLICIES["random"], streams)
    kept = m.Match(*(a.copy() for a in match)), m.Streams(*(copy.deepcopy(g) for g in streams))
    rest = episode(match, rules, streams)
    assert np.array_equal(rest, episode(kept[0], rules, kept[1]))


@pytest.mark.jit
@pytest.mark.parametrize("policy", POLICIES)
def test_options_start_when_they_change_or_are_chosen(policy):
    match, rules, streams = fresh(KeepawayConfig(), 3)
    previous = match.options.copy()
    for cycle in range(60):
        ended = step_cycle(match, rules, POLICIES[policy], streams)
        changed = (match.options[:, :2] != previous[:, :2]).any(1)
        chosen = np.zeros(5, bool)
        chosen[:3] = match.deciding
        np.testing.assert_array_equal(match.started, changed | chosen)
        assert (match.options[match.started, m.START] == cycle).all()
        assert (match.options[~match.started, m.START] == previous[~match.started, m.START]).all()
        previous = match.options.copy()
        if ended:
            break


@pytest.mark.jit
def test_a_pass_that_takes_several_cycles_is_one_decision():
    match, rules, streams = fresh(EXACT, 2)
    passing = []
    while not begin_cycle(match, rules, streams):
        finish_cycle(match, rules, streams)
    holder = int(np.flatnonzero(match.deciding)[0])
    match.actions[holder] = 2
    finish_cycle(match, rules, streams)
    while True:
        begin_cycle(match, rules, streams)
        passing.append((match.options[holder, m.OPTION], bool(match.deciding[holder])))
        if passing[-1][0] != m.PASS_BALL:
            break
        finish_cycle(match, rules, streams)
    assert not any(decides for _, decides in passing[:-1])
    assert match.options[holder, m.START] > 0


@pytest.mark.jit
@given(st.integers(0, 2**32), st.sampled_from([1, 2, 5]))
@settings(max_examples=10, deadline=None)
def test_every_state_of_an_episode_is_possible(seed, root):
    config = KeepawayConfig(view_angle_deg=90.0 if root == 2 else 360.0, exact_state=root == 5)
    match, rules, streams = fresh(config, seed)
    for _ in range(200):
        ended = step_cycle(match, rules, POLICIES["random"], streams)
        assert np.isfinite(match.players).all()
        assert np.isfinite(match.ball).all()
        assert np.hypot(match.ball[2], match.ball[3]) <= 3.0 * 1.05 * 0.94
        assert (np.abs(match.players[:, NECK]) <= 90).all()
        assert (match.options[:, m.OPTION] >= 0).all()
        if ended:
            break
    assert ended == (match.status[m.END] != ONGOING)


def test_streams_of_a_match_are_independent():
    draws = {name: g.random() for name, g in zip(m.Streams._fields, open_streams(1, "x"), strict=True)}
    assert len(set(draws.values())) == len(draws)
    assert open_streams(1, "x").kick.random() == draws["kick"]
    assert stream(1, "x", "keepaway", "kick").random() == draws["kick"]


def test_an_unknown_policy_and_the_wrong_learners_are_refused():
    game = Autoplay(EXACT, 1)
    with pytest.raises(ValueError, match="no policy"):
        game.play("best", 1)
    with pytest.raises(ValueError, match="need 3 learners"):
        game.learn(new_sarsa(SarsaConfig(), keepaway_tiles(EXACT), 2, 3), 1)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"n_keepers": 1}, "keepers"),
        ({"n_takers": 0}, "takers"),
        ({"length_m": 5.0}, "at least 10 m"),
        ({"view_angle_deg": 0.0}, "field of view"),
    ],
)
def test_an_impossible_task_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        KeepawayConfig(**wrong)
