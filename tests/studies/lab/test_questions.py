"""Questionnaires: the ready ones are whole, answers are checked, totals are the published ones."""

import pytest

from studies.lab.questions import READY, QuestionsError, passed, read_questions, refusal, total


@pytest.mark.parametrize("name", READY)
def test_every_ready_questionnaire_can_be_read(name, tmp_path):
    assert read_questions(name, tmp_path).questions


def test_the_best_and_the_worst_answers_to_sus_give_100_and_0(tmp_path):
    sus = read_questions("sus", tmp_path)
    best = {question.id: 5 if number % 2 == 0 else 1 for number, question in enumerate(sus.questions)}
    assert total(sus, best) == 100.0
    assert total(sus, {name: 6 - answer for name, answer in best.items()}) == 0.0
    # All neutral: ten times 2 points, times 2.5.
    assert total(sus, dict.fromkeys(best, 3)) == 50.0


def test_a_raw_task_load_is_the_mean_of_six_scales(tmp_path):
    tlx = read_questions("nasa-tlx", tmp_path)
    answers = {question.id: 10 * number for number, question in enumerate(tlx.questions)}
    assert total(tlx, answers) == 25.0
    assert total(tlx, answers | {"effort": None}) is None


def questionnaire(tmp_path, body):
    (tmp_path / "mine.toml").write_text('name = "mine"\n[[questions]]\nid = "q"\ntext = "?"\n' + body)
    return read_questions("mine.toml", tmp_path).questions[0]


@pytest.mark.parametrize(
    ("body", "good", "bad", "reason"),
    [
        ('type = "likert"\npoints = 7', 7, 8, "from 1 to 7"),
        ('type = "scale"\nlow = "a"\nhigh = "b"', 0, 101, "from 0 to 100"),
        ('type = "choice"\noptions = ["x", "y"]', "x", "z", "from the list"),
        ('type = "choice"\noptions = ["x", "y"]', "x", ("x", "y"), "one answer"),
        ('type = "choice"\noptions = ["x", "y"]\nseveral = true', ("x", "y"), ("x", "z"), "from the list"),
        ('type = "number"\nlowest = 18\nhighest = 99\nunit = "years"', 18, 17.5, "from 18 to 99 years"),
        ('type = "text"\nlongest = 3', "abc", "abcd", "at most 3 characters"),
        ('type = "text"', "a", None, "Please answer"),
    ],
)
def test_answers_are_checked(tmp_path, body, good, bad, reason):
    question = questionnaire(tmp_path, body)
    assert refusal(question, good) is None
    assert reason in str(refusal(question, bad))


def test_a_question_that_is_not_required_may_be_left_out(tmp_path):
    assert refusal(questionnaire(tmp_path, 'type = "text"\nrequired = false'), None) is None


def test_an_attention_check_is_passed_or_failed_and_other_questions_are_neither(tmp_path):
    check = questionnaire(tmp_path, 'type = "likert"\ncorrect = 2')
    assert (passed(check, 2), passed(check, 3)) == (True, False)
    assert passed(questionnaire(tmp_path, 'type = "likert"'), 3) is None


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ('type = "likert"\npoint = 7', "point"),
        ('type = "choice"\noptions = ["x"]', "two or more"),
        ('type = "slider"', "slider"),
    ],
)
def test_a_wrong_question_is_named(tmp_path, body, message):
    with pytest.raises(QuestionsError, match=message):
        questionnaire(tmp_path, body)


def test_a_missing_file_is_named_with_the_ready_ones(tmp_path):
    with pytest.raises(QuestionsError, match=r"there is no such file.*nasa-tlx"):
        read_questions("none.toml", tmp_path)


def test_an_instructed_press_is_passed_with_its_key_alone(tmp_path):
    asked = questionnaire(tmp_path, 'type = "press"\nkey = "k"')
    assert (passed(asked, "k"), passed(asked, "j")) == (True, False)
    assert refusal(asked, "j") is None
    assert refusal(asked, "jj") == "Please press one key."
    with pytest.raises(QuestionsError, match="one small letter but q, or one digit"):
        questionnaire(tmp_path, 'type = "press"\nkey = "q"')
