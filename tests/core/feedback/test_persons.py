"""Simulated people by name: their budgets, and that their properties are there."""

import math

import numpy as np
import pytest

from core.feedback.simulated_participants import person, persons
from core.feedback.trainers import SimulatedTrainer, judgement
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream

VALUES = np.arange(8.0)
N_EPISODES, N_STEPS = 400, 300


def sessions_of(name: str) -> list[list[tuple[float, float]]]:
    """(value, believed) of each judgement, episode by episode: bursts counted once."""
    trainer, rng, said = SimulatedTrainer(person(name), root_seed=1), stream(2, "actions"), []
    for episode in range(N_EPISODES):
        trainer.watch_episode(episode)
        first, said_now = episode * N_STEPS, []
        step = trainer.next_inclined(first, first + N_STEPS)
        while step < first + N_STEPS:
            action, now = int(rng.integers(8)), step * NS_PER_S
            presses = trainer.watch(step, VALUES, action, shown_ns=now, hidden_ns=now + NS_PER_S)
            if presses:
                said_now.append((presses[0].value, presses[0].believed))
            step = trainer.next_inclined(step + 1, first + N_STEPS)
        said.append(said_now)
    return said


@pytest.mark.parametrize("name", persons())
def test_everybody_keeps_the_papers_budget(name):
    counts = [len(said) for said in sessions_of(name)]
    assert max(counts) <= 5
    # A binomial count of mean 2 has sd 1.1; 4 standard errors of the mean of 400 episodes.
    assert np.mean(counts) <= 2 + 4 * 1.1 / math.sqrt(N_EPISODES)


@pytest.mark.statistical
@pytest.mark.parametrize("name", persons())
def test_judgements_are_wrong_as_often_as_the_name_says(name):
    wrong = [value != believed for said in sessions_of(name) for value, believed in said]
    expected = {"noisy": 0.3, "useless": 0.5, "adversary": 0.9}.get(name, 0.1)
    assert np.mean(wrong) == pytest.approx(expected, abs=4 * math.sqrt(0.25 / len(wrong)))


def test_who_tires_says_less_and_who_leaves_says_nothing():
    tiring, leaves, expert = (
        [len(said) for said in sessions_of(name)] for name in ("tiring", "leaves", "expert")
    )
    assert sum(tiring[300:]) < sum(expert[300:])
    assert sum(leaves[:300]) == sum(expert[:300])
    assert sum(leaves[300:]) == 0


def test_an_unknown_name_is_refused_with_those_known():
    with pytest.raises(ValueError, match="no simulated person 'x': known are expert, lay"):
        person("x")


def test_actions_too_close_to_the_border_in_value_are_passed_over():
    # Good is the best quarter: 10 and 6; the best bad one is 5. Border (6 + 5) / 2 = 5.5, sd 3.2: 0.5 sd is
    # 1.6.
    values = np.array([10.0, 6.0, 5.0, 3.0, 2.0, 1.0, 0.0, 0.0])
    said = [judgement(values, a, good_share=0.25, equal_margin=0.5) for a in range(8)]
    assert said == [1.0, None, None, -1.0, -1.0, -1.0, -1.0, -1.0]


def test_where_all_actions_are_alike_who_minds_equality_says_nothing():
    assert judgement(np.zeros(4), 1, good_share=0.25, equal_margin=0.1) is None
    assert judgement(np.zeros(4), 1, good_share=0.25) == 1.0


def test_a_fatal_action_is_never_too_close_to_tell():
    assert judgement(np.array([-math.inf, 0.0, 0.0]), 0, good_share=0.5, equal_margin=9.0) == -1.0


def asked(name: str, options: list[int], values: np.ndarray = VALUES, n: int = 2000) -> list[int | None]:
    trainer = SimulatedTrainer(person(name), root_seed=3)
    trainer.watch_episode(0)
    return [trainer.answer(step, values, options) for step in range(n)]


@pytest.mark.statistical
def test_an_answer_is_the_best_option_but_for_mistakes():
    answers = asked("expert", [2, 7, 5])
    assert np.mean([answer == 7 for answer in answers]) == pytest.approx(0.9, abs=4 * 0.3 / math.sqrt(2000))
    wrong = [answer for answer in answers if answer != 7]
    assert np.mean([answer == 5 for answer in wrong]) == pytest.approx(
        0.5, abs=4 * 0.5 / math.sqrt(len(wrong))
    )


def test_an_adversary_answers_wrongly():
    assert np.mean([answer == 1 for answer in asked("adversary", [1, 6])]) > 0.8


def test_who_cannot_tell_does_not_answer():
    assert set(asked("hesitant", [1, 2], np.array([0.0, 5.0, 5.1, 9.0]), n=5)) == {None}
    assert None not in asked("expert", [1, 2], np.array([0.0, 5.0, 5.1, 9.0]), n=5)


def test_who_has_left_does_not_answer():
    trainer = SimulatedTrainer(person("leaves"), root_seed=3)
    for episode in range(301):
        trainer.watch_episode(episode)
    assert trainer.answer(0, VALUES, [1, 2]) is None


@pytest.mark.parametrize("options", [[3], [3, 3]])
def test_a_question_needs_two_different_options(options):
    with pytest.raises(ValueError, match="2 or more different options"):
        asked("expert", options, n=1)
