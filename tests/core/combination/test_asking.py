"""When the agent asks, what it asks, and what an answer says."""

import itertools

import numpy as np
import pytest

from core.combination.agent import ArlAgent
from core.combination.asking import Asker, Question, disagreement_of, samples_of, votes
from core.combination.config import AgentConfig, AskingConfig
from core.combination.human_learner import HumanLearner
from core.domain import Choices
from core.feedback.config import CreditConfig
from core.feedback.delays import CurrentStep
from core.learners.human_config import RidgeModel
from tests.core.combination.test_agent import CountingLearner, EpisodeOutcome


def decision(n: int = 6) -> Choices:
    return Choices(np.zeros((n, 1)), np.arange(2.0 * n).reshape(n, 2), np.zeros(n, dtype=bool))


ASKING = AskingConfig(per_episode=1, share=0.25, memory=8, minimum_decisions=4)
AGREED, SPLIT, TORN = [3, 3, 3], [3, 3, 1], [3, 1, 5]
THIRDS = [1 / 3] * 3


def test_disagreement_by_hand():
    shares = votes([4, 2, 4], [0.5, 0.3, 0.2])
    assert shares == pytest.approx({4: 0.7, 2: 0.3})
    # two draws differ with probability 1 - 0.49 - 0.09
    assert disagreement_of(shares) == pytest.approx(0.42)
    assert disagreement_of({1: 1.0}) == 0.0


def asked_at(rows, config=ASKING):
    asker = Asker(config)
    asker.reset()
    return [asker.question(decision(), actions, THIRDS) for actions in rows]


def test_it_asks_where_the_policies_disagree_most():
    questions = asked_at([SPLIT, SPLIT, AGREED, SPLIT, SPLIT, TORN])
    assert [question is not None for question in questions] == [False] * 5 + [True]
    question = questions[-1]
    assert question.options == (1, 3, 5)  # equal votes: the lower number first
    np.testing.assert_array_equal(question.features, decision().feedback_features[[1, 3, 5]])
    assert question.disagreement == pytest.approx(2 / 3)


def test_it_does_not_ask_before_it_knows_what_much_is():
    assert asked_at([AGREED, AGREED, AGREED, TORN]) == [None] * 4


def test_the_options_are_those_with_most_votes():
    asker = Asker(AskingConfig(per_episode=1, options=2, share=0.5, minimum_decisions=1))
    asker.reset()
    asker.question(decision(), AGREED, THIRDS)
    question = asker.question(decision(), [0, 2, 4], [0.2, 0.5, 0.3])
    assert question.options == (2, 4)


def test_the_budget_is_per_episode():
    asker = Asker(ASKING)
    rows = [AGREED] * 4 + [TORN] * 2
    asker.reset()
    first = [asker.question(decision(), actions, THIRDS) for actions in rows]
    assert sum(question is not None for question in first) == 1
    asker.reset()
    asked = [asker.question(decision(), actions, THIRDS) for actions in [AGREED] * 7 + [TORN]]
    assert sum(question is not None for question in asked) == 1


def test_one_who_may_not_ask_never_does():
    assert asked_at([AGREED] * 6 + [TORN] * 3, AskingConfig(minimum_decisions=1)) == [None] * 9


def test_unanimous_policies_are_no_question():
    assert asked_at([AGREED] * 10) == [None] * 10


def test_an_answer_praises_one_option_and_blames_the_others_together_as_much():
    question = Question((4, 0, 2), decision().feedback_features[[4, 0, 2]], 0.6)
    samples = samples_of(question, 0, number=7)
    assert [(sample.label, sample.weight) for sample in samples] == [(-1.0, 0.5), (1.0, 1.0), (-1.0, 0.5)]
    assert {sample.step for sample in samples} == {-8}
    np.testing.assert_array_equal(samples[1].features, [0.0, 1.0])


def test_an_answer_must_be_one_of_the_options():
    with pytest.raises(ValueError, match=r"answer 3 is not among the options \(0, 1\)"):
        samples_of(Question((0, 1), np.zeros((2, 2)), 0.5), 3, number=0)


@pytest.mark.parametrize(
    "wrong", [{"per_episode": -1}, {"options": 4}, {"share": 1.0}, {"memory": 3, "minimum_decisions": 4}]
)
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(ValueError, match=r"asking needs|minimum_decisions <= memory"):
        AskingConfig(**wrong)


@pytest.mark.parametrize("n_participants", [1, 2])
def test_an_agent_asks_its_top_policies_and_learns_from_the_answer(n_participants):
    who = ArlAgent(
        CountingLearner(),
        AgentConfig(asking=AskingConfig(per_episode=1, share=0.5, minimum_decisions=1)),
        n_feedback_features=2,
        n_participants=n_participants,
        root_seed=1,
    )
    for _ in range(3):  # theta = (0, 1), (1, 1), (2, 1), equally good
        who.learn_from_domain(
            who.begin_episode(exploring=True, watched=True), EpisodeOutcome(performance=1.0)
        )
    alike = Choices(np.array([[1.0, 1.0], [0.0, 0.0]]), np.eye(2), np.zeros(2, dtype=bool))
    split = Choices(np.array([[0.0, 1.0], [0.6, 0.0]]), np.eye(2), np.zeros(2, dtype=bool))
    who.begin_episode(exploring=False, watched=True)
    assert who.question(alike) is None
    question = who.question(split)  # theta_0 and theta_1 want action 0, theta_2 action 1: 1.2 to 1
    assert question is not None
    assert question.options == (0, 1)
    assert question.disagreement == pytest.approx(1 - 4 / 9 - 1 / 9)
    before = who.digest()
    who.learn_from_answer(question, 1)
    assert who.human.knows_something
    assert who.digest() != before
    first = who.human.learners[0]
    assert first.weights[1] > first.weights[0]


def test_an_answer_outlives_a_press_that_is_taken_back():
    learner = HumanLearner(CreditConfig(delay=CurrentStep()), RidgeModel(), 2)
    learner.learn_from_answer(Question((0, 1), np.eye(2), 0.5), 0)
    weights = learner.weights.tolist()
    learner.step_shown(0, np.array([0.0, 1.0]), 0)
    learner.learn_from_press(0, 1, 1.0)
    learner.step_hidden(5)
    assert learner.weights.tolist() != weights
    learner.retract(0)
    assert learner.weights.tolist() == weights


def test_the_papers_agent_does_not_ask():
    who = ArlAgent(CountingLearner(), AgentConfig(), n_feedback_features=2, root_seed=1)
    assert who.question(decision(2)) is None


def asked_by_values(rows, config=ASKING):
    asker = Asker(config)
    asker.reset()
    return [asker.question_by_values(decision(len(row)), np.array(row)) for row in rows]


CLEAR, CLOSE = [3.0, 1.0, 0.0], [1.0, 3.0, 2.75]


def test_a_learner_without_policies_asks_where_its_best_values_are_closest():
    questions = asked_by_values([CLEAR] * 4 + [CLOSE])
    assert [question is not None for question in questions] == [False] * 4 + [True]
    assert questions[-1].options == (1, 2, 0)
    assert questions[-1].disagreement == pytest.approx(1 / 1.25)


def test_actions_that_are_ruled_out_are_no_options():
    asker = Asker(ASKING)
    asker.reset()
    choices = Choices(np.zeros((3, 1)), np.zeros((3, 2)), np.array([False, True, False]))
    for _ in range(4):
        asker.question_by_values(choices, np.array([3.0, 9.0, 1.0]))
    assert asker.question_by_values(choices, np.array([3.0, 9.0, 2.9])).options == (0, 2)


def test_one_action_alone_is_no_question():
    assert asked_by_values([[1.0]] * 9) == [None] * 9


def test_equal_values_are_asked_about_as_rarely_as_the_rest():
    config = AskingConfig(per_episode=9, share=0.25, memory=8, minimum_decisions=4)
    asked = [question is not None for question in asked_by_values([[0.0, 0.0]] * 16, config)]
    places = [n for n, was in enumerate(asked) if was]
    assert places
    assert all(later - earlier > 4 for earlier, later in itertools.pairwise(places))


def test_keys_choose_options():
    config = AskingConfig(keys=("a", "b", "c"), none_key="9")
    assert [config.option_of(key, 2) for key in "abc9x"] == [0, 1, None, -1, None]
