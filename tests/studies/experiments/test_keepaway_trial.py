"""Trials in Keepaway for experiments: pure, paired, and as long as asked for."""

from concurrent.futures import ThreadPoolExecutor

import msgspec
import numpy as np
import pytest

from core.combination.config import SideBySide
from core.feedback.delays import GammaDelay
from core.keepaway.arl_autoplay import ArlAutoplay
from studies.experiments import credit, fig7, keepaway_robustness
from studies.experiments.keepaway_pages import smooth
from studies.experiments.keepaway_settings import arl, person, sarsa_alone
from studies.experiments.keepaway_trial import (
    KeepawayTrial,
    mean_by_time,
    measured_delay,
    own_fit,
    quick,
    run_trial,
)
from studies.experiments.results import read_results
from studies.experiments.run import run_sweep
from studies.experiments.sweep import PILOT_SEEDS, csv_text, describe_settings, root_seeds

EXPERIMENTS = (fig7.EXPERIMENT, credit.EXPERIMENT, keepaway_robustness.EXPERIMENT)


@pytest.mark.jit
def test_a_trial_is_a_pure_function_of_settings_and_seed():
    trial = quick(arl())
    first, again, other = (run_trial(trial, PILOT_SEEDS + k) for k in (0, 0, 1))
    assert csv_text(first) == csv_text(again) != csv_text(other)


@pytest.mark.jit
def test_a_trial_ends_with_the_episode_that_reaches_its_hours():
    rows = run_trial(msgspec.structs.replace(sarsa_alone(), hours=0.05), PILOT_SEEDS)
    assert rows["hours"][-2] < 0.05 <= rows["hours"][-1]
    assert rows["hours"][-1] == pytest.approx(rows["seconds"].sum() / 3600)
    assert not rows["presses"].any()
    assert not rows["w_h"].any()


@pytest.mark.jit
@pytest.mark.parametrize("experiment", EXPERIMENTS, ids=lambda e: e.name)
def test_every_condition_can_be_played_and_described(experiment):
    settings = describe_settings(experiment.conditions)
    assert msgspec.json.encode(settings)
    for condition in experiment.conditions[::5]:
        rows = experiment.trial(experiment.quick(condition.settings), PILOT_SEEDS)
        assert set(map(len, rows.values())) == {len(rows["seconds"])}
        assert rows["presses"].max() <= 2


@pytest.mark.jit
@pytest.mark.parametrize(("mistake_rate", "sign"), [(0.0, 1), (1.0, -1)])
def test_what_learned_from_all_attitudes_agrees_with_good_people_and_not_with_adversaries(mistake_rate, sign):
    # docs/decisions/side-by-side.md: 0.3 and -0.4 on other seeds, and the opposite of both at the start.
    thirds = SideBySide(warm_up_episodes=100_000)
    early, late = [], []
    for seed in range(6):
        game = ArlAutoplay(
            arl(trust=thirds, watched_by=person(mistake_rate)).play, PILOT_SEEDS + 300 + seed, "agreement"
        )
        own = [e for e in (game.play_episode() for _ in range(400)) if e.agreement and e.trust == 0.0]
        signed = [e.agreement.signed for e in own]
        early.append(np.mean(signed[:15]))
        late.append(np.mean(signed[-40:]))
    for found in (np.array(late), np.array(late) - np.array(early)):
        assert sign * found.mean() > 2 * found.std(ddof=1) / np.sqrt(len(found))


def test_a_fit_of_many_reactions_is_near_the_true_density():
    true = GammaDelay(4.0, 0.3, 0.3)
    fitted = measured_delay(true, 20_000, root_seed=3)
    ours, theirs = (d.offset_s + d.shape * d.scale_s for d in (fitted, true))
    # Standard error of the mean: 0.6 / sqrt(20,000) = 0.0042; allow 4.
    assert ours == pytest.approx(theirs, abs=0.017)
    assert measured_delay(true, 60, root_seed=3) == measured_delay(true, 60, root_seed=3)


def test_an_own_fit_needs_a_person_and_enough_reactions():
    with pytest.raises(ValueError, match="10 reactions"):
        own_fit(arl(), 5)
    with pytest.raises(ValueError, match="person"):
        own_fit(sarsa_alone(), 60)
    with pytest.raises(ValueError, match="hours"):
        KeepawayTrial(hours=0.0)


def test_means_by_time_are_over_the_episodes_that_end_in_each_part():
    rows = {"hours": np.array([0.1, 0.4, 0.6, 1.5, 2.0]), "seconds": np.array([1.0, 3.0, 5.0, 7.0, 9.0])}
    # (0, 0.5]: 1 and 3; (0.5, 1]: 5; (1, 1.5]: 7; (1.5, 2]: 9
    assert mean_by_time(rows, "seconds", 2.0, 4).tolist() == [2.0, 5.0, 7.0, 9.0]
    # Nothing ends in (0.6, 0.7] hours of 2: the episode under way, 7.
    assert mean_by_time(rows, "seconds", 2.0, 20)[7] == 7.0


@pytest.mark.jit
def test_a_page_says_which_claims_held_from_files_alone(tmp_path):
    seeds = root_seeds(2, PILOT_SEEDS)
    with ThreadPoolExecutor(1) as executor:
        run_sweep(fig7.EXPERIMENT, seeds, tmp_path, executor, quick=True, only=["sarsa", "linear-gamma"])
    page = fig7.report(read_results(fig7.EXPERIMENT, tmp_path))
    assert "ARL, linear with gamma, keeps the ball longer than Sarsa" in page.text
    assert "without gamma, keeps" not in page.text, "nothing was played without gamma"
    assert set(page.figures) == {"fig7"}


def test_running_means_look_back_over_a_few_points():
    curve = np.array([[2.0, 4.0, 6.0, 8.0]])
    assert smooth(curve, 2).tolist() == [[2.0, 3.0, 5.0, 7.0]]
