"""What a study will be like: minutes and presses from simulated sessions, and everything that is missing."""

import pytest

from studies.lab.check import PLACEHOLDER, forecast
from studies.lab.read import load_study
from studies.lab.ready_studies import copy_ready_study
from tests.studies.lab.test_read import STUDY


@pytest.fixture
def write(tmp_path):
    def write_study(text=STUDY, consent="# Consent\n"):
        (tmp_path / "consent.md").write_text(consent)
        (tmp_path / "study.toml").write_text(text.replace("episodes = 3", "episodes = 2\nwatched_steps = 4"))
        return load_study(tmp_path / "study.toml")

    return write_study


def test_a_block_takes_as_long_as_its_games_are_on_screen(write):
    found = forecast(write(), sessions=1)
    assert [block.games for block in found.blocks] == [2, 2]
    blocks = [step for step in found.steps if step.kind == "block"]
    assert all(step.minutes == max(block.minutes for block in found.blocks) > 0 for step in blocks)
    assert found.minutes(0) == pytest.approx(sum(step.minutes for step in found.steps))


def test_half_the_games_take_half_the_time(write):
    half = write(STUDY.replace('type = "block"', 'type = "block"\ngames = 1'))
    assert [step.minutes for step in forecast(half, sessions=1).steps if step.kind == "block"] == [
        pytest.approx(max(block.minutes for block in forecast(half, sessions=1).blocks) / 2)
    ] * 2


def test_placeholders_a_missing_debriefing_and_an_unbalanced_number_are_named(write):
    loaded = write(STUDY.replace("participants = 8", "participants = 7"), consent="Ask [NAME] about it.\n")
    missing = " ".join(forecast(loaded, sessions=1).missing)
    assert "consent.md still holds [NAME]" in missing
    assert "no step of type debriefing" in missing
    assert "7 participants cannot be balanced over 2 orders: plan a multiple of 2" in missing


def test_a_page_without_a_text_is_missing(write):
    assert any("consent.md is empty" in line for line in forecast(write(consent=" \n"), sessions=1).missing)


def test_every_placeholder_of_a_ready_consent_is_named(tmp_path):
    for language in ("en", "de"):
        text = load_study(copy_ready_study("demo", tmp_path / language, language)[0]).texts["consent.md"]
        assert len(PLACEHOLDER.findall(text)) == text.count("[") == 7


def test_an_own_delay_needs_a_calibration_before_it(write):
    own = STUDY.replace("[protocol.session]", '[protocol]\ndelay_of = "feedback-lag"\n[protocol.session]')
    assert any("no calibration comes before it" in line for line in forecast(write(own), sessions=1).missing)
    calibration = '[[sittings.steps]]\ntype = "calibration"\n[[sittings.steps]]\ntype = "block"\n'
    calibrated = own.replace('[[sittings.steps]]\ntype = "block"\n', calibration, 1)
    assert not any("calibration" in line for line in forecast(write(calibrated), sessions=1).missing)


def test_of_a_ready_study_only_the_placeholders_are_missing(tmp_path):
    loaded = load_study(copy_ready_study("demo", tmp_path)[0])
    assert [line.split(" still")[0] for line in forecast(loaded, sessions=1).missing] == ["consent.md"]
