"""The simulator against the reference's episodes: `pytest -m slow
tests/studies/fidelity/test_keepaway_targets.py`."""

import pytest

from studies.fidelity.keepaway_fidelity import (
    FINE_NAMES,
    SETTINGS,
    TRACED_EPISODES,
    compare,
    compare_fine,
)
from tests.data_folder import data_folder

N_EPISODES = 2000
FINE_TOLERANCE = 0.10
# A target that is missed by a little (docs/results/keepaway_fidelity.md). The limit only keeps the gap from
# growing.
KNOWN_GAPS = {("v15_full_hold", "passes per episode"): 0.25}


@pytest.mark.slow
@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: s.label)
def test_durations_and_ends_follow_the_reference(setting):
    result = compare(setting, data_folder("keepaway"), N_EPISODES, root_seed=11)
    assert abs(result.relative_difference) < 0.10 or abs(result.standard_errors) < 2
    assert result.ks_distance < 0.10
    assert abs(result.out_difference) < 0.10


@pytest.mark.slow
@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: s.label)
def test_passes_flights_and_first_kicks_follow_the_reference(setting):
    both = compare_fine(setting, data_folder("keepaway"), root_seed=11)
    if both is None:
        pytest.skip(f"the reference logged no trajectories for {setting.label}")
    ours, reference = both
    assert TRACED_EPISODES >= 1000
    for name in FINE_NAMES:
        tolerance = KNOWN_GAPS.get((setting.label, name), FINE_TOLERANCE)
        assert ours[name] == pytest.approx(reference[name], rel=tolerance), name
