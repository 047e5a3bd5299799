"""Simulated participants: what they press, when, and how their properties show."""

import math

import msgspec
import numpy as np
import pytest

from core.feedback.credit import GammaDelay, UniformDelay
from core.feedback.trainers import IntendedPress, SimulatedTrainer, TrainerConfig, draw_delay_s, judgement
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream

VALUES = np.arange(8.0)  # action 7 is the best one; 6 and 7 are the best quarter
BEST, WORST = 7, 0


def presses_of(
    config: TrainerConfig, *, n_steps: int = 60, n_episodes: int = 1, action: int = BEST, root_seed: int = 1
) -> list[tuple[IntendedPress, ...]]:
    """What is said about each step, step by step, the step being on screen for a second."""
    trainer = SimulatedTrainer(config, root_seed=root_seed)
    said = []
    for episode in range(n_episodes):
        trainer.watch_episode(episode)
        for k in range(n_steps):
            step = episode * n_steps + k
            said.append(
                trainer.watch(step, VALUES, action, shown_ns=step * NS_PER_S, hidden_ns=(step + 1) * NS_PER_S)
            )
    return said


def talkative(**changes: object) -> TrainerConfig:
    """Says something about every step, and never wrongly, unless changed."""
    return msgspec.structs.replace(
        TrainerConfig(press_probability=1.0, max_presses=10**9, mistake_rate=0.0), **changes
    )


def values(said: list[tuple[IntendedPress, ...]]) -> list[float]:
    return [press.value for presses in said for press in presses]


def test_the_best_quarter_of_the_actions_is_good() -> None:
    # 8 actions: fewer than 2 better ones
    assert [judgement(VALUES, action, good_share=0.25) for action in range(8)] == [-1.0] * 6 + [1.0] * 2


def test_equal_actions_are_judged_alike() -> None:
    assert judgement(np.zeros(5), 3, good_share=0.25) == 1.0
    assert judgement(np.array([-math.inf, 0.0]), 0, good_share=0.25) == -1.0


def test_borderline_actions_are_passed_over_where_that_is_asked_for() -> None:
    # shares of better actions 7/8 ... 0; the border is 1/4, and 1/8, 2/8, 3/8 are less than 0.2 away
    said = [judgement(VALUES, action, good_share=0.25, skip_margin=0.2) for action in range(8)]
    assert said == [-1.0, -1.0, -1.0, -1.0, None, None, None, 1.0]


def test_good_actions_are_praised_and_others_blamed() -> None:
    assert values(presses_of(talkative(), action=BEST)) == [1.0] * 60
    assert values(presses_of(talkative(), action=WORST)) == [-1.0] * 60


def test_an_adversary_always_presses_the_wrong_key() -> None:
    said = presses_of(talkative(mistake_rate=1.0))
    assert values(said) == [-1.0] * 60
    assert {press.believed for presses in said for press in presses} == {1.0}


def test_a_deliberately_wrong_press_is_known_as_such() -> None:
    said = presses_of(talkative(deliberate_rate=1.0))
    assert values(said) == [-1.0] * 60
    assert all(press.deliberate for presses in said for press in presses)
    assert not any(
        press.deliberate for presses in presses_of(talkative(mistake_rate=1.0)) for press in presses
    )


def test_there_are_no_more_judgements_than_the_budget_in_any_episode() -> None:
    said = presses_of(talkative(max_presses=5), n_episodes=3)
    for episode in range(3):
        assert len(values(said[60 * episode : 60 * (episode + 1)])) == 5


@pytest.mark.statistical
def test_the_paper_s_two_presses_per_episode_on_average() -> None:
    n_episodes = 150
    count = len(values(presses_of(TrainerConfig(), n_episodes=n_episodes)))
    # 60 steps at 0.03: 1.8 presses, sd 1.32, cut at 5 (takes away 0.02); standard error 1.32/sqrt(150) =
    # 0.108
    assert count / n_episodes == pytest.approx(1.8, abs=4 * 0.108)


@pytest.mark.statistical
def test_one_press_in_ten_is_a_mistake() -> None:
    said = values(presses_of(talkative(mistake_rate=0.1), n_steps=2000))
    # standard error sqrt(0.1 * 0.9 / 2000) = 0.0067; allow 4 of them
    assert np.mean(np.array(said) < 0) == pytest.approx(0.1, abs=0.027)


@pytest.mark.statistical
@pytest.mark.parametrize(
    ("delay", "mean_s", "sd_s"),
    [(GammaDelay(), 0.75, 0.474), (GammaDelay(2, 0.1, 0.2), 0.4, 0.141), (UniformDelay(), 0.5, 0.173)],
)
def test_presses_come_after_the_outcome_by_the_delay_density(
    delay: GammaDelay | UniformDelay, mean_s: float, sd_s: float
) -> None:
    said = presses_of(talkative(delay=delay), n_steps=2000)
    delays_s = [
        (press.time_ns - (press.step + 1) * NS_PER_S) / NS_PER_S for presses in said for press in presses
    ]
    assert min(delays_s) >= 0
    assert np.mean(delays_s) == pytest.approx(mean_s, abs=4 * sd_s / math.sqrt(2000))
    drawn = [draw_delay_s(delay, rng=stream(3, "delay", k)) for k in range(2000)]
    # Kolmogorov-Smirnov: the largest distance exceeds 1.95/sqrt(n) in 1 of 1000 samples.
    ordered = delay.cdf(np.sort(drawn))
    steps = np.arange(1, 2001) / 2000
    assert np.abs(ordered - steps).max() < 1.95 / math.sqrt(2000)


def test_an_anticipating_participant_presses_before_the_outcome() -> None:
    said = presses_of(talkative(anticipation_rate=1.0))
    assert all(
        press.step * NS_PER_S <= press.time_ns <= (press.step + 1) * NS_PER_S
        for presses in said
        for press in presses
    )


def test_a_burst_is_one_judgement_by_several_presses() -> None:
    said = presses_of(talkative(burst_rate=1.0, burst_presses=4, burst_interval_s=0.19, max_presses=2))
    spoken = [presses for presses in said if presses]
    assert [len(presses) for presses in spoken] == [4, 4]
    first = spoken[0]
    assert [press.time_ns - first[0].time_ns for press in first] == [0, 190_000_000, 380_000_000, 570_000_000]
    assert len({press.value for press in first}) == 1


def test_fatigue_halves_the_rate() -> None:
    trainer = SimulatedTrainer(
        TrainerConfig(press_probability=0.4, fatigue_half_life_episodes=2.0), root_seed=1
    )
    rates = []
    for episode in range(5):
        trainer.watch_episode(episode)
        rates.append(trainer.press_probability)
    # in episode k: 0.4 * 0.5^(k/2)
    assert rates == pytest.approx([0.4, 0.4 / math.sqrt(2), 0.2, 0.2 / math.sqrt(2), 0.1])


def test_a_participant_who_stops_presses_no_more() -> None:
    said = presses_of(talkative(stops_after_episodes=2), n_episodes=4)
    assert [len(values(said[60 * k : 60 * (k + 1)])) for k in range(4)] == [60, 60, 0, 0]


def test_presses_follow_from_seed_episode_and_step_alone() -> None:
    config = TrainerConfig(press_probability=0.5, max_presses=10**9, anticipation_rate=0.3, burst_rate=0.3)
    whole = presses_of(config)
    assert presses_of(config) == whole
    assert presses_of(config, root_seed=2) != whole
    late = SimulatedTrainer(config, root_seed=1)
    late.watch_episode(0)
    assert late.watch(40, VALUES, BEST, shown_ns=40 * NS_PER_S, hidden_ns=41 * NS_PER_S) == whole[40]


@pytest.mark.statistical
def test_the_budget_of_an_episode_can_be_drawn_with_a_given_mean_and_most() -> None:
    said = presses_of(talkative(max_presses=5, mean_presses=2.0), n_episodes=400, n_steps=20)
    counts = [len(values(said[20 * k : 20 * (k + 1)])) for k in range(400)]
    assert max(counts) <= 5
    # Binomial(5, 0.4): sd 1.095, standard error 1.095/sqrt(400) = 0.055
    assert np.mean(counts) == pytest.approx(2.0, abs=4 * 0.055)


def test_a_player_may_skip_the_steps_at_which_nothing_would_be_said() -> None:
    config = TrainerConfig(press_probability=0.05, max_presses=5)
    patient, hasty = SimulatedTrainer(config, root_seed=3), SimulatedTrainer(config, root_seed=3)
    for episode in range(10):
        patient.watch_episode(episode)
        hasty.watch_episode(episode)
        first, end = 300 * episode, 300 * (episode + 1)
        every = [
            patient.watch(k, VALUES, BEST, shown_ns=k * NS_PER_S, hidden_ns=(k + 1) * NS_PER_S)
            for k in range(first, end)
        ]
        said = []
        step = hasty.next_inclined(first, end)
        while step < end:
            shown_ns = step * NS_PER_S
            said.append(hasty.watch(step, VALUES, BEST, shown_ns=shown_ns, hidden_ns=shown_ns + NS_PER_S))
            step = hasty.next_inclined(step + 1, end)
        assert said == [presses for presses in every if presses]
        assert len(said) == 5


def test_changing_one_rate_leaves_the_other_draws_alone() -> None:
    config = TrainerConfig(press_probability=0.5, max_presses=10**9, mistake_rate=0.0)
    right, wrong = presses_of(config), presses_of(msgspec.structs.replace(config, mistake_rate=1.0))
    assert [[press.time_ns for press in presses] for presses in right] == [
        [press.time_ns for press in presses] for presses in wrong
    ]


def test_the_configuration_survives_a_recordings_header() -> None:
    config = TrainerConfig(delay=UniformDelay(0.1, 0.9), fatigue_half_life_episodes=7.5)
    assert msgspec.json.decode(msgspec.json.encode(config), type=TrainerConfig) == config


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"press_probability": 1.1}, "press_probability is in"),
        ({"mistake_rate": -0.1}, "mistake_rate is in"),
        ({"max_presses": -1}, "max_presses >= 0"),
        ({"mean_presses": 6.0}, "mean_presses is 0..max_presses"),
        ({"burst_presses": 0}, "burst_presses >= 1"),
        ({"burst_interval_s": 0.0}, "burst_interval_s is > 0"),
        ({"fatigue_half_life_episodes": 0.0}, "fatigue_half_life_episodes is > 0"),
        ({"stops_after_episodes": -1}, "stops_after_episodes is >= 0"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(changes: dict[str, float], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        TrainerConfig(**changes)  # type: ignore[arg-type]


def test_watching_without_an_episode_or_an_impossible_action_is_refused() -> None:
    trainer = SimulatedTrainer(talkative(), root_seed=1)
    with pytest.raises(ValueError, match="watch_episode"):
        trainer.watch(0, VALUES, BEST, shown_ns=0, hidden_ns=1)
    with pytest.raises(ValueError, match="action 8"):
        judgement(VALUES, 8, good_share=0.25)
