"""Play that goes on from logged states: whose ball it is, where it starts, and that a difference shows."""

import numpy as np
import pytest

from studies.fidelity.keepaway_fidelity import SETTINGS, Setting
from studies.fidelity.keepaway_rollouts import (
    BOTH,
    KEEPER,
    LOOSE,
    RUN_UP,
    TAKER,
    LoggedEpisode,
    Rollout,
    holder,
    read_episodes,
    roll_out,
    starts_of,
)
from tests.data_folder import data_folder
from tests.studies.logged_play import played

HOLD = next(setting for setting in SETTINGS if setting.label == "v15_full_hold")
FAR = (9.0, 9.0)


def players(*places: tuple[float, float]) -> np.ndarray:
    """Return players who stand still: two keepers, then takers."""
    return np.array([(*place, 0.0, 0.0, 0.0, 0.0) for place in places])


@pytest.mark.parametrize(
    ("keeper", "taker", "expected"),
    [
        ((1.0, 0.0), FAR, KEEPER),
        ((1.0, 0.0), (0.0, -1.08), BOTH),
        (FAR, (0.0, 1.08), TAKER),
        (FAR, (0.0, 1.09), LOOSE),
    ],
)
def test_who_can_kick_has_the_ball(keeper, taker, expected):
    assert holder(np.zeros(4), players(FAR, keeper, taker), n_keepers=2) == expected


def logged(*rows: tuple[tuple[float, float], tuple[float, float]]) -> LoggedEpisode:
    """Return an episode with the ball at rest in the middle, one keeper and one taker."""
    places = np.array([players(*row) for row in rows])
    nobody = np.zeros(places.shape[:2], np.bool_)
    return LoggedEpisode(np.zeros((len(rows), 4)), places, nobody, n_keepers=1)


def test_a_row_starts_a_comparison_where_the_ball_changes_hands():
    near, far = (0.5, 0.0), (2.0, 0.0)
    episode = logged(
        (near, far), (near, near), (near, near), (far, near), (far, far), (near, far), (near, far)
    )
    assert starts_of(episode) == {1: ["both"], 3: ["taker"], 4: ["loose"]}


def test_a_drop_starts_one_when_the_takers_can_be_there_again():
    here, put_back = ((0.5, 0.0), (1.5, 0.0)), ((0.5, 0.0), (9.45, 0.0))
    episode = logged(here, *[put_back] * (RUN_UP + 3))
    assert starts_of(episode) == {1 + RUN_UP: ["drop"]}
    assert starts_of(logged(here, *[put_back] * (RUN_UP + 1))) == {}


def test_with_beliefs_nothing_is_compared():
    with pytest.raises(ValueError, match="v15_360_hold: with beliefs a logged state does not tell"):
        roll_out(next(setting for setting in SETTINGS if setting.label == "v15_360_hold"), [])


def largest(found: list[Rollout]) -> float:
    return max(abs(rollout.standard_errors) for rollout in found)


@pytest.mark.slow
@pytest.mark.statistical
def test_our_own_play_goes_on_as_it_went_on_and_another_policy_does_not():
    # 1 in 10,000 comparisons is beyond 3.9 standard errors by chance, and there are fewer than 50.
    same = roll_out(HOLD, played(HOLD, 30), horizons=(1, 5, 15), copies=20)
    assert 10 < len(same) < 50
    assert largest(same) < 3.9
    random = Setting("ours", "random", HOLD.config, "rand")
    assert largest(roll_out(HOLD, played(random, 60), horizons=(1, 5, 15), copies=20)) > 3.9


@pytest.mark.slow
def test_from_logged_states_our_play_goes_on_as_the_reference_does():
    path = data_folder("keepaway") / f"{HOLD.label}_traj.csv.gz"
    if not path.exists():
        pytest.skip(f"the reference logged no trajectories for {HOLD.label}")
    found = roll_out(HOLD, read_episodes(path))
    assert len(found) > 30
    # By chance one run in a hundred has a comparison beyond 3.8 standard errors (70 of them, Bonferroni).
    assert largest(found) < 3.8
    assert np.sqrt(np.mean([rollout.standard_errors**2 for rollout in found])) < 1.3
