"""When the agent asks, what it asks, and what an answer says."""

import numpy as np
import pytest

from core.combination.asking import Asker, Question, disagreement_of, samples_of, votes
from core.combination.config import AskingConfig
from core.domain import Choices


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
    asker.begin_episode()
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
    asker.begin_episode()
    asker.question(decision(), AGREED, THIRDS)
    question = asker.question(decision(), [0, 2, 4], [0.2, 0.5, 0.3])
    assert question.options == (2, 4)


def test_the_budget_is_per_episode():
    asker = Asker(ASKING)
    rows = [AGREED] * 4 + [TORN] * 2
    asker.begin_episode()
    first = [asker.question(decision(), actions, THIRDS) for actions in rows]
    assert sum(question is not None for question in first) == 1
    asker.begin_episode()
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
