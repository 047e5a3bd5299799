"""How ours and the reference's episodes are compared."""

import numpy as np

from core.keepaway.autoplay import Episodes
from studies.fidelity.keepaway_fidelity import SETTINGS, DurationComparison, Durations, Trace, passes_of

CYCLES = np.arange(20, 60)


def durations(seconds):
    return Durations(np.asarray(seconds), np.zeros(len(seconds), np.bool_))


def test_durations_equal_in_cycles_have_no_distance_however_they_were_written():
    read_from_a_table = durations([float(f"{c / 10:.1f}") for c in CYCLES])
    multiplied = durations(CYCLES * 0.1)
    assert (multiplied.seconds != read_from_a_table.seconds).any()
    assert DurationComparison(SETTINGS[0], multiplied, read_from_a_table).ks_distance == 0


def test_an_episodes_duration_is_the_float_nearest_to_its_decimal():
    episodes = Episodes(CYCLES, np.zeros(len(CYCLES), np.bool_))
    assert episodes.duration_s.tolist() == [float(f"{c / 10:.1f}") for c in CYCLES]


def test_a_shift_by_one_cycle_is_a_distance_of_one_step():
    shifted = DurationComparison(SETTINGS[0], durations(CYCLES / 10), durations((CYCLES + 1) / 10))
    assert abs(shifted.ks_distance - 1 / len(CYCLES)) < 1e-12


def trace(ball, keeper, kicked):
    """Return an episode of one keeper: rows of x, y, vx, vy; of x, y; of whether it kicked."""
    return Trace(np.array(ball, float), np.array(keeper, float)[:, None], np.array(kicked)[:, None])


def test_a_ball_kicked_out_of_reach_is_a_pass_until_a_keeper_has_it_again():
    # Kicked with 1.6 m per cycle: 1.504 after the decay. It bounces off somebody and is back after two cycles
    # of flight.
    ball = [(0, 0, 0, 0), (1.6, 0, 1.504, 0), (3.1, 0, -0.9, 0), (0.9, 0, -0.9, 0)]
    ((speed, flight),) = passes_of(trace(ball, [(0, 0)] * 4, [False, True, False, False]))
    assert (round(speed, 9), flight) == (1.6, 2)


def test_a_stuck_ball_that_is_dropped_is_no_pass_though_its_keeper_is_put_back():
    ball = [(0, 0, 0.5, 0), (0.8, 0, 0, 0), (0.8, 0, 0, 0)]
    assert passes_of(trace(ball, [(0, 0), (-8.65, 0), (-8.65, 0)], [False, True, False])) == []
