"""Kicks in logged states: our own are found again within noise, another kick shows, and the reference's are
ours."""

import dataclasses
from collections.abc import Iterable

import numpy as np
import pytest
from scipy.stats import ks_2samp

from studies.fidelity.keepaway_fidelity import SETTINGS
from studies.fidelity.keepaway_kicks import LoggedKick, logged_kicks
from studies.fidelity.keepaway_rollouts import LoggedEpisode, read_episodes
from tests.data_folder import data_folder
from tests.studies.logged_play import played

SETTING = {setting.label: setting for setting in SETTINGS}
HOLD = SETTING["v15_full_hold"]
EVERYBODY = range(5)


def compared(kicks: list[LoggedKick]) -> list[LoggedKick]:
    return [kick for kick in kicks if not np.isnan(kick.missed_m)]


def test_our_own_kicks_are_found_again_within_noise():
    kicks = list(logged_kicks(HOLD, played(HOLD, 3), EVERYBODY))
    assert len(compared(kicks)) > 100
    assert not any(kick.another for kick in kicks)
    # The bound is no wider than noise is: some kicks come close to it.
    assert max(kick.missed_m / kick.noise_m for kick in compared(kicks)) > 0.6


def changed(episode: LoggedEpisode, kick: LoggedKick, by_m: float) -> LoggedEpisode:
    """Return the episode with the ball elsewhere after this kick."""
    ball = episode.ball.copy()
    ball[kick.row + 1, 0] += by_m
    return dataclasses.replace(episode, ball=ball)


def test_a_ball_that_went_where_noise_cannot_take_it_was_kicked_another_way():
    (episode,) = played(HOLD, 1)
    kick = compared(list(logged_kicks(HOLD, [episode], EVERYBODY)))[10]
    there = [
        other
        for other in logged_kicks(HOLD, [changed(episode, kick, 0.3)], EVERYBODY)
        if other.row == kick.row
    ]
    assert [other.another for other in there] == [True]
    assert there[0].noise_m == kick.noise_m < 0.3 - kick.missed_m


def test_a_kick_that_only_one_of_both_made_is_another():
    (episode,) = played(HOLD, 1)
    kick = compared(list(logged_kicks(HOLD, [episode], EVERYBODY)))[10]
    kicked = episode.kicked.copy()
    kicked[kick.row + 1, kick.player] = False
    silent = dataclasses.replace(episode, kicked=kicked)
    there = [other for other in logged_kicks(HOLD, [silent], EVERYBODY) if other.row == kick.row]
    assert [(other.logged, other.ours, other.another) for other in there] == [(False, True, True)]


def shares_of_noise(kicks: Iterable[LoggedKick]) -> list[float]:
    return [kick.missed_m / kick.noise_m for kick in compared(list(kicks))]


def alike(some: list[float], others: list[float]) -> bool:
    return bool(ks_2samp(some, others).pvalue > 0.001)


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.parametrize(
    ("label", "players"), [("v15_full_hold", EVERYBODY), ("v15_full_rand", range(3, 5))], ids=str
)
def test_the_references_kicks_are_ours(label: str, players: range):
    path = data_folder("keepaway") / f"{label}_traj.csv.gz"
    if not path.exists():
        pytest.skip(f"the reference logged no trajectories for {label}")
    setting = SETTING[label]
    kicks = list(logged_kicks(setting, read_episodes(path), players))
    assert len(compared(kicks)) > 500
    assert np.mean([kick.another for kick in kicks]) < 0.001
    assert alike(
        shares_of_noise(kicks), shares_of_noise(logged_kicks(setting, played(setting, 300), players))
    )
