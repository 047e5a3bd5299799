"""The studies that come with the program: whole, and planned as the paper's."""

from collections import Counter

import pytest

from studies.lab.config import Break, Consent, Debriefing
from studies.lab.orders import order_of
from studies.lab.questions import READY as READY_QUESTIONS
from studies.lab.questions import read_questions
from studies.lab.read import StudyError, load_study
from studies.lab.ready_studies import READY, SENTENCES, copy_ready_study
from tests.full_disk import files_end_at


@pytest.fixture(params=[(name, language) for name in READY for language in SENTENCES], ids="-".join)
def loaded(request, tmp_path):
    name, language = request.param
    return load_study(copy_ready_study(name, tmp_path / "new", language)[0])


def test_a_ready_study_is_whole_and_has_consent_breaks_and_debriefing(loaded):
    kinds = [type(step) for _, _, step in loaded.study.steps]
    assert Consent in kinds
    assert kinds[-1] is Debriefing
    assert loaded.study.name == "fig6" or Break in kinds


@pytest.mark.parametrize(("name", "conditions"), [("fig5", 3), ("fig6", 1), ("fig7", 3)])
def test_the_papers_studies_have_four_participants_and_twenty_trials_of_each_condition(
    tmp_path, name, conditions
):
    study = load_study(copy_ready_study(name, tmp_path)[0]).study
    assert study.participants == 4
    trials = Counter(
        order[block if len(order) > 1 else 0]
        for order in (order_of(study, place) for place in range(4))
        for block in range(study.assigned_blocks)
    )
    assert trials == dict.fromkeys(study.conditions, 20)
    assert len(study.conditions) == conditions


@pytest.mark.parametrize(("name", "presses", "wrong"), [("fig5", 5, 0.0), ("fig6", 5, 0.0), ("fig7", 2, 0.1)])
def test_the_papers_budgets_and_wrong_presses_are_kept(tmp_path, name, presses, wrong):
    for protocol in load_study(copy_ready_study(name, tmp_path)[0]).protocols.values():
        assert protocol.keys.max_presses_per_episode == presses
        assert protocol.keys.wrong_press_rate == wrong


def test_half_a_study_is_not_left_on_a_full_disk(tmp_path):
    with files_end_at(1000), pytest.raises(OSError, match="too large"):
        copy_ready_study(READY[0], tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert copy_ready_study(READY[0], tmp_path)


@pytest.mark.parametrize("name", READY)
def test_a_german_study_is_the_english_one_in_other_words(tmp_path, name):
    english = load_study(copy_ready_study(name, tmp_path / "en")[0])
    german = load_study(copy_ready_study(name, tmp_path / "de", "de")[0])
    assert english.study.language == "en"
    assert german.study.language == "de"
    assert {protocol.screen.language for protocol in german.protocols.values()} == {"de"}
    assert english.study.title != german.study.title
    assert english.texts.keys() == german.texts.keys()
    assert not set(english.texts.values()) & set(german.texts.values())
    consents = [
        step for study in (english, german) for _, _, step in study.study.steps if type(step) is Consent
    ]
    assert len(consents) == 2
    sentences = [{*consent.statements, *consent.optional} for consent in consents]
    assert len(sentences[0]) == len(sentences[1])
    assert not sentences[0] & sentences[1]


def test_a_german_study_asks_the_same_questions_in_german(tmp_path):
    for name in READY_QUESTIONS:
        english, german = read_questions(name, tmp_path), read_questions(name, tmp_path, "de")
        assert [(type(each), each.id, each.required) for each in english.questions] == [
            (type(each), each.id, each.required) for each in german.questions
        ]
        assert (english.name, english.scoring) == (german.name, german.scoring)
        assert english.title != german.title
        assert not {each.text for each in english.questions} & {each.text for each in german.questions}
        for one, other in zip(english.questions, german.questions, strict=True):
            for field in ("points", "lowest", "highest", "step", "longest", "maximum"):
                assert getattr(one, field, None) == getattr(other, field, None)
            assert len(getattr(one, "options", ())) == len(getattr(other, "options", ()))


def test_a_condition_in_another_language_than_the_study_is_refused(tmp_path):
    (path, *_) = copy_ready_study("demo", tmp_path / "new")
    path.write_text(path.read_text() + '\n[conditions.linear.screen]\nlanguage = "de"\n')
    with pytest.raises(StudyError, match="one language for all its pages"):
        load_study(path)


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "consent.md").write_text("mine")
    with pytest.raises(FileExistsError, match=r"consent\.md is there already"):
        copy_ready_study("demo", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["consent.md"]


def test_an_unknown_name_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(ValueError, match="choose one of demo, fig5, fig6, fig7"):
        copy_ready_study("fig8", tmp_path)
