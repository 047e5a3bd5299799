"""Simulated participants of a study press about as often as a person would within its budget."""

import numpy as np
import pytest

from core.feedback.delays import GammaDelay
from core.feedback.simulated_participants import person, persons
from core.feedback.trainers import SimulatedTrainer
from studies.lab.config import Simulated
from studies.lab.read import load_study
from studies.lab.simulated_people import (
    MOST_PER_CHANCE,
    as_participant,
    chances_per_game,
    presses_per_game,
    settings_without_effect,
)
from tests.studies.lab.test_read import STUDY


@pytest.fixture
def write(tmp_path):
    def write_study(more="", protocol=""):
        (tmp_path / "consent.md").write_text("# Consent")
        text = STUDY.replace("[protocol.session]", f"{protocol}\n[protocol.session]", 1)
        (tmp_path / "study.toml").write_text(f"{text}\n{more}")
        return load_study(tmp_path / "study.toml")

    return write_study


def trainer_of(loaded):
    """Return the simulated participant, who is the same in all conditions."""
    first, *others = (protocol.trainer for protocol in loaded.protocols.values())
    assert all(other == first for other in others)
    return first


def test_every_kind_has_a_setting():
    assert set(Simulated.__struct_fields__) == {"presses_per_game", *persons()}


def test_two_of_five_presses_is_usual_and_a_kind_may_press_otherwise(write):
    loaded = write("[simulated]\nslow = 0.5")
    assert presses_per_game(loaded, "expert") == pytest.approx(2.0)
    assert presses_per_game(loaded, "slow") == 0.5
    loaded = write("[simulated]\npresses_per_game = 3\nslow = 0.5")
    assert [presses_per_game(loaded, kind) for kind in ("lay", "slow")] == [3.0, 0.5]


@pytest.mark.parametrize(("kind", "aim"), [("expert", 2.0), ("slow", 0.5)])
def test_a_kind_judges_as_often_as_it_aims_at(write, kind, aim):
    """Mean of 600 games of 25 steps; its standard error is below 0.06."""
    config = trainer_of(as_participant(write("[simulated]\nslow = 0.5"), kind, 25.0))
    trainer = SimulatedTrainer(config, root_seed=3)
    values, judged = np.arange(4.0), 0
    for game in range(600):
        trainer.watch_episode(game)
        for step in range(25):
            judged += bool(trainer.watch(game * 25 + step, values, 3, shown_ns=0, hidden_ns=1))
    assert judged / 600 == pytest.approx(aim, abs=0.2)


def test_nobody_presses_more_often_than_people_without_a_budget(write):
    eager = trainer_of(
        as_participant(write(protocol="[protocol.keys]\nmax_presses_per_episode = 1000"), "lay", 9.0)
    )
    assert eager.press_probability == MOST_PER_CHANCE


def test_a_kind_keeps_its_own_delay_where_the_study_names_none(write):
    assert trainer_of(as_participant(write(), "slow", 9.0)).delay == person("slow").delay
    own = '[protocol.trainer]\ndelay = { type = "gamma", shape = 3.0, scale_s = 0.2 }'
    assert trainer_of(as_participant(write(protocol=own), "slow", 9.0)).delay == GammaDelay(3.0, 0.2)


def test_other_settings_of_the_trainer_are_named(write):
    assert settings_without_effect(write()) == ()
    assert settings_without_effect(write(protocol="[protocol.trainer]\npress_probability = 0.5")) == (
        "press_probability",
    )


def test_chances_are_the_steps_of_a_watched_game(write):
    assert chances_per_game(write(protocol="")) > 0
