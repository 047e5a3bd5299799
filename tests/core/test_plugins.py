"""Games are found by name: the program's own, those of other packages, and one that only this test knows."""

import subprocess
import sys
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core import plugins
from core.configuration.reading import ConfigurationError
from core.plugins import BUILT_IN, GROUP, GameError, GamePlugin, game_names, plugin_called
from core.recording.summary import summarise_recording
from core.registry import game_of
from core.session.effects import idle, uses
from core.session.plan import plan
from core.session.protocol import DEFAULTS
from core.session.protocol_file import ProtocolError
from core.session.protocol_reading import load_protocol, protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, replay_human_model, watched_steps
from studies.demo import summarise
from tests.contracts.domain_contract import DomainContract
from tests.core.sessions import simulated
from tests.games.corridor import Corridor, CorridorConfig

WHERE = "tests.games.corridor:PLUGIN"


@pytest.fixture
def corridor(monkeypatch: pytest.MonkeyPatch) -> GamePlugin:
    """A third game, installed."""
    monkeypatch.setattr(plugins, "_installed", lambda: (("corridor", WHERE),))
    return plugin_called("corridor")


class TestCorridor(DomainContract):
    """The third game keeps the contract."""

    @pytest.fixture(params=[CorridorConfig(), CorridorConfig(cells=9, slip=0.0)], ids=["slippery", "dry"])
    def domain(self, request: Any) -> Corridor:
        return Corridor(request.param)


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_game_of_the_program_is_complete_and_its_default_protocol_is_its_own(name: str) -> None:
    plugin = plugin_called(name)
    default = DEFAULTS[name]
    assert default.game == plugin.name == name
    assert type(default.learner) in plugin.learners
    assert type(default.agent.human_model) in plugin.human_models
    assert plugin.expected_game_s(default) > 0
    assert protocol_from({"domain": name}, to_run=True) == default


@pytest.mark.parametrize("name", BUILT_IN)
def test_the_metadata_name_the_games_that_the_program_knows(name: str) -> None:
    text = (Path(__file__).resolve().parents[2] / "pyproject.toml").read_text()
    assert f'{name} = "{BUILT_IN[name]}"' in text


def test_a_protocol_is_read_without_compiled_code() -> None:
    code = (
        "import sys; from core.session.protocol import DEFAULTS; list(map(DEFAULTS.get, DEFAULTS)); "
        "print('numba' in sys.modules or 'numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_a_third_game_plays_is_recorded_replayed_and_asked_about(
    corridor: GamePlugin, tmp_path: Path
) -> None:
    recording = simulated(tmp_path, DEFAULTS["corridor"])
    protocol = protocol_from(recording.header.protocol)
    assert protocol == corridor.default()
    assert "the paper has no corridor" in recording.header.departures
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert (result.difference, result.outputs) == (None, len(recording.outputs))

    summary = summarise(recording)
    assert (summary.game, summary.episodes, summary.unseen_episodes) == ("corridor", 4, 6)
    assert max(summary.performances) < 0
    assert summary.accepted > 0
    assert summarise_recording(recording).game == "corridor"

    # What-ifs: the session's own agent again, another delay, and a human model alone.
    steps = watched_steps(recording, protocol)
    again = relearn(recording, protocol, steps, root_seed=recording.header.root_seed)
    assert again.agent.digest() == recording.outputs[-1].digest
    other = protocol_from({**recording.header.protocol, "agent": {"credit": {"delay": "current"}}})
    assert relearn(recording, other, steps, root_seed=1).agent.digest() != again.agent.digest()
    heard = replay_human_model(recording, protocol, steps, count=lambda press: True)
    np.testing.assert_array_equal(heard.human.weights, again.agent.human.weights)


def test_sarsa_learns_the_third_game_from_its_costs(corridor: GamePlugin) -> None:
    protocol = protocol_from({"domain": {"type": "corridor", "slip": 0.0}})
    game = game_of(protocol)
    agent = game.agent(protocol, 1)
    play = game.player(protocol, agent)
    for seed in range(200):
        policy = agent.begin_episode(exploring=True, watched=False)
        agent.learn_from_domain(policy, play(policy, seed, 500))
    # At most 5 cells to go, one in a hundred decisions explores.
    for played in game.evaluate(protocol, agent, range(1000, 1020), max_steps=100):
        assert played.performance >= -9


def test_words_about_settings_name_the_games_that_have_them(corridor: GamePlugin, tmp_path: Path) -> None:
    where = {use.settings: use.where for use in uses()}
    assert where["screen.tick_ms",] == "in Tetris, Gymnasium and Corridor only"
    assert where["domain.slip",] == "in long corridors only"
    short = protocol_from({"domain": {"type": "corridor", "cells": 2, "slip": 0.5}})
    assert [each.path for each in idle(short, DEFAULTS["corridor"])] == [("domain", "slip")]
    assert "30 paces" in plan(DEFAULTS["corridor"])["Games"]
    file = tmp_path / "p.toml"
    file.write_text('[domain]\ntype = "corridor"\nsell = 3\n')
    with pytest.raises(ProtocolError, match=r"p.toml:3: \[domain\] sell .*did you mean `cells`"):
        load_protocol(file)
    file.write_text('[domain]\ntype = "coridor"\n')
    with pytest.raises(ProtocolError, match='"gymnasium", "corridor"; did you mean "corridor"'):
        load_protocol(file)


def test_a_recording_of_a_game_that_is_gone_says_which_and_that_a_package_is_missing(tmp_path: Path) -> None:
    with pytest.raises(
        ConfigurationError, match='type = "corridor": expected one of "tetris", "keepaway", "gymnasium"'
    ):
        protocol_from({"domain": {"type": "corridor"}})


def test_a_game_that_cannot_be_loaded_hinders_no_other_and_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(plugins, "_installed", lambda: (("broken", "no_such_module:PLUGIN"),))
    assert list(DEFAULTS) == ["tetris", "keepaway", "gymnasium"]
    with pytest.raises(ConfigurationError, match="'broken' at no_such_module:PLUGIN cannot be loaded"):
        protocol_from({"domain": "broken"})


@pytest.mark.parametrize(
    ("name", "where", "told"),
    [
        ("corridor", "tests.games.corridor:MOVES", "not an instance of a subclass"),
        ("hallway", WHERE, "its entry point is called 'hallway', its name is 'corridor'"),
    ],
)
def test_what_is_no_game_is_refused_with_the_reason(
    monkeypatch: pytest.MonkeyPatch, name: str, where: str, told: str
) -> None:
    monkeypatch.setattr(plugins, "_installed", lambda: ((name, where),))
    with pytest.raises(GameError, match=told):
        plugin_called(name)


def test_two_games_of_one_name_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plugins, "_installed", lambda: (("tetris", WHERE),))
    with pytest.raises(GameError, match="two games are called 'tetris'"):
        game_names()


def test_entry_points_are_read_from_the_metadata(monkeypatch: pytest.MonkeyPatch) -> None:
    plugins._installed.cache_clear()
    point = EntryPoint("corridor", WHERE, GROUP)
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: [point] if group == GROUP else [])
    try:
        assert game_names()["corridor"] == WHERE
    finally:
        plugins._installed.cache_clear()
