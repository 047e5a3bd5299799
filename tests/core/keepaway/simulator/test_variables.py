"""State variables and benchmark policies, by hand."""

import numpy as np
import pytest

from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.simulator.policies import HAND_CODED, HOLD, RANDOM, choose
from core.keepaway.simulator.variables import observe, state_variables
from core.numerics.streams import stream


def players(*places):
    rows = np.zeros((len(places), 6))
    rows[:, :2] = places
    return rows


def test_the_thirteen_variables_of_a_scene_drawn_by_hand():
    # Keeper 1 has the ball at (0, 3); keeper 2 is 4 away, keeper 0 is 6 away; taker 4 is 3 away, taker 3 is
    # 5.
    scene = players((6, 3), (0, 3), (-4, 3), (3, 7), (0, 0))
    out, order = np.zeros(13), np.zeros(5, np.int64)
    observe(1, scene, 3, order, out)
    assert order.tolist() == [1, 2, 0, 4, 3]
    assert out[:9].tolist() == pytest.approx([3, 4, 6, 3, 5, 5, 45**0.5, 0, 58**0.5])
    assert out[9:11].tolist() == pytest.approx([5, 5])  # K2-T1 (-4,3)-(0,0); K3-T2 (6,3)-(3,7)
    # Seen from K1, K2 lies at 180, K3 at 0, T1 at -90, T2 at 53.13 degrees.
    assert out[11:].tolist() == pytest.approx([90, np.degrees(np.arctan2(4, 3))])


@pytest.mark.parametrize(("keepers", "takers", "n"), [(3, 2, 13), (4, 3, 19), (5, 4, 25), (2, 1, 7)])
def test_there_are_4k_plus_2t_minus_3_variables(keepers, takers, n):
    variables = state_variables(KeepawayConfig(keepers, takers, 30.0, 30.0))
    assert len(variables) == n
    assert len({v.name for v in variables}) == n
    assert {v.unit for v in variables} <= {"m", "deg"}


def test_the_tile_widths_are_the_published_ones():
    widths = [v.tile_width for v in state_variables(KeepawayConfig())]
    assert widths == [2, 2, 3, 2, 3, 2, 3, 3, 3, 4, 4, 10, 10]
    assert keepaway_tiles(KeepawayConfig()).n_tilings == 32


def situation(taker_distance, distances, angles):
    return np.array([1, 5, 9, taker_distance, 8, 5, 9, 5, 5, *distances, *angles], float)


def test_hand_coded_keepers_hold_while_no_taker_is_near():
    assert choose(HAND_CODED, situation(5.1, (30, 30), (90, 90)), 3, 2, stream(1, "p")) == 0


def test_hand_coded_keepers_pass_where_four_times_distance_plus_angle_is_best():
    # 4 * 10 + 40 = 80 < 90 holds; 4 * 10 + 60 = 100 passes; ties go to the nearer mate.
    near = lambda d, a: choose(HAND_CODED, situation(4.0, d, a), 3, 2, stream(1, "p"))
    assert near((10, 5), (40, 60)) == 0
    assert near((10, 5), (60, 60)) == 1
    assert near((5, 10), (60, 60)) == 2
    assert near((10, 10), (60, 60)) == 1


def test_random_keepers_take_all_actions_and_holders_only_one():
    rng = stream(1, "p")
    state = situation(4.0, (1, 1), (1, 1))
    assert {choose(RANDOM, state, 3, 2, rng) for _ in range(60)} == {0, 1, 2}
    assert {choose(HOLD, state, 3, 2, rng) for _ in range(20)} == {0}
