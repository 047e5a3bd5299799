"""The studies that come with the program: whole, and planned as the paper's."""

from collections import Counter

import pytest

from studies.lab.config import Break, Consent, Debriefing
from studies.lab.orders import order_of
from studies.lab.read import load_study
from studies.lab.ready_studies import READY, copy_ready_study


@pytest.fixture(params=READY)
def loaded(request, tmp_path):
    return load_study(copy_ready_study(request.param, tmp_path / "new")[0])


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


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "consent.md").write_text("mine")
    with pytest.raises(FileExistsError, match=r"consent\.md is there already"):
        copy_ready_study("demo", tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["consent.md"]


def test_an_unknown_name_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(ValueError, match="choose one of demo, fig5, fig6, fig7"):
        copy_ready_study("fig8", tmp_path)
