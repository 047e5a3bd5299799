"""How ours and the reference's episodes are compared."""

import numpy as np

from core.keepaway.autoplay import Episodes
from studies.experiments.keepaway_fidelity import SETTINGS, Comparison, Durations

CYCLES = np.arange(20, 60)


def durations(seconds):
    return Durations(np.asarray(seconds), np.zeros(len(seconds), np.bool_))


def test_durations_equal_in_cycles_have_no_distance_however_they_were_written():
    read_from_a_table = durations([float(f"{c / 10:.1f}") for c in CYCLES])
    multiplied = durations(CYCLES * 0.1)
    assert (multiplied.seconds != read_from_a_table.seconds).any()
    assert Comparison(SETTINGS[0], multiplied, read_from_a_table).ks_distance == 0


def test_an_episodes_duration_is_the_float_nearest_to_its_decimal():
    episodes = Episodes(CYCLES, np.zeros(len(CYCLES), np.bool_))
    assert episodes.duration_s.tolist() == [float(f"{c / 10:.1f}") for c in CYCLES]


def test_a_shift_by_one_cycle_is_a_distance_of_one_step():
    shifted = Comparison(SETTINGS[0], durations(CYCLES / 10), durations((CYCLES + 1) / 10))
    assert abs(shifted.ks_distance - 1 / len(CYCLES)) < 1e-12
