"""Minari data sets: its loader reads them, games are those recorded, and a third-party learner learns."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from core.feedback.keys import KeyConfig
from core.feedback.trainers import TrainerConfig
from core.recording.reader import read_recording
from core.session.protocol import SessionConfig
from studies.exports.minari import FOLDER_VARIABLE, export_minari
from studies.exports.session_rows import SessionRows
from studies.exports.tidy import ExportError
from tests.core.sessions import simulated, small_protocol
from tests.studies.exports.conftest import REFERENCE, REPOSITORY

minari = pytest.importorskip("minari", reason="minari is not installed: pip install 'arl-tui[minari]'")
pytestmark = pytest.mark.jit


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    into = tmp_path_factory.mktemp("minari") / "sets"
    exported = export_minari(REFERENCE / "version-2", into)
    assert exported.episodes == {"arl/keepaway-3v2-v0": 4, "arl/tetris-20x10-v0": 9}
    return into


@pytest.fixture
def load(folder, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return minari.load_dataset


def test_the_loader_reads_what_was_recorded(load):
    data = load("arl/tetris-20x10-v0")
    about = list(data.storage.get_episode_metadata(range(9)))
    for episode, said in zip(data.iterate_episodes(), about, strict=True):
        path = REFERENCE / "version-2" / f"{said['session']}.jsonl"
        session = SessionRows(read_recording(path), said["session"])
        steps = [
            step for number, step in session.steps.items() if session.places[number].game == said["game"]
        ]
        assert episode.rewards.tolist() == [step.reward for step in steps]
        assert episode.actions.tolist() == [
            [step.detail["orientation"], step.detail["column"]] for step in steps
        ]
        assert episode.observations["piece"][:-1].tolist() == [step.detail["piece"] for step in steps]
        assert episode.infos["step_index"].tolist() == [-1, *(step.step for step in steps)]
        started = session.started[said["game"] - 1]
        assert set(episode.infos["weight"]) == {started.weight}
        assert set(episode.infos["trust"]) == {started.trust}


def test_boards_grow_by_the_piece_that_is_put_down(load):
    for episode in load("arl/tetris-20x10-v0").iterate_episodes():
        cells = episode.observations["board"].sum(axis=(1, 2))
        assert cells[0] == 0
        # Four cells come with each piece; ten go with each line.
        assert np.diff(cells).tolist() == (4 - 10 * episode.rewards).tolist()


def test_keepaway_shows_the_recorded_state_variables(load):
    session = SessionRows(
        read_recording(REFERENCE / "version-2" / "keepaway-exponential-equation-4.jsonl"), ""
    )
    states = [step.state for step in session.steps.values()]
    found = [
        row
        for episode in load("arl/keepaway-3v2-v0").iterate_episodes()
        for row in episode.observations[:-1].tolist()
    ]
    assert found == states


def test_feedback_is_what_the_presses_gave(folder, load):
    pandas = pytest.importorskip("pandas")
    presses = pandas.read_csv(folder / "arl" / "tetris-20x10-v0" / "presses.csv")
    total = sum(episode.infos["feedback"].sum() for episode in load("arl/tetris-20x10-v0").iterate_episodes())
    lost = presses[["before_first", "in_gaps", "too_late"]].sum(axis=1)
    credited = presses[presses.counted & presses.merged_into_index.isna()]
    assert total == pytest.approx((credited.value * (1 - lost[credited.index])).sum())


def test_reading_a_data_set_leaves_the_environment_as_it_was(folder):
    assert FOLDER_VARIABLE not in os.environ


def test_a_folder_without_games_is_refused_with_the_reason(lab, tmp_path):
    with pytest.raises(ExportError, match="no game could be exported"):
        export_minari(lab / "calibration", tmp_path / "sets")


def test_the_example_learns_from_presses_alone(tmp_path):
    pytest.importorskip("sklearn", reason="scikit-learn is not installed: pip install 'arl-tui[dev]'")
    (tmp_path / "data").mkdir()
    protocol = small_protocol(
        session=SessionConfig(episodes=12, unseen_between=0, watched_steps=40, unseen_steps=100),
        keys=KeyConfig(max_presses_per_episode=40),
        trainer=TrainerConfig(press_probability=0.9, max_presses=40),
    )
    simulated(tmp_path / "data", protocol)
    export_minari(tmp_path / "data", tmp_path / "sets")
    example = REPOSITORY / "docs" / "examples" / "train_from_presses.py"
    done = subprocess.run(
        [sys.executable, example],
        env={**os.environ, FOLDER_VARIABLE: str(tmp_path / "sets")},
        capture_output=True,
        text=True,
        check=True,
    )
    agreed = re.search(r"predicted: (\d+)%", done.stdout)
    assert agreed, done.stdout
    # One in ten presses is wrong; a coin agrees with half of them.
    assert int(agreed.group(1)) >= 65


def test_a_data_set_of_tetris_has_the_spaces_and_games_of_our_environment(load):
    pytest.importorskip("gymnasium")
    from core.interop.gymnasium.tetris_env import TetrisEnv

    data, env = load("arl/tetris-20x10-v0"), TetrisEnv()
    assert data.spec.observation_space == env.observation_space
    assert data.spec.action_space == env.action_space
    about = list(data.storage.get_episode_metadata(range(9)))
    for episode, said in zip(data.iterate_episodes(), about, strict=True):
        observation, _ = env.reset(options={"episode_seed": int(said["episode_seed"])})
        for step, action in enumerate(episode.actions):
            assert np.array_equal(observation["board"], episode.observations["board"][step])
            assert observation["piece"] == episode.observations["piece"][step]
            observation, reward, *_ = env.step(action)
            assert reward == episode.rewards[step]


def test_a_data_set_of_keepaway_has_the_spaces_of_our_environment(load):
    pytest.importorskip("pettingzoo")
    from core.interop.pettingzoo import keepaway_v0

    data, env = load("arl/keepaway-3v2-v0"), keepaway_v0.parallel_env()
    assert data.spec.observation_space == env.observation_space("keeper_0")
    assert data.spec.action_space == env.action_space("keeper_0")
    (episode, *_), (said, *_) = data.iterate_episodes([0]), data.storage.get_episode_metadata([0])
    seen, infos = env.reset(options={"episode_seed": int(said["episode_seed"])})
    (deciding,) = (name for name in env.agents if infos[name]["decides"])
    assert np.array_equal(seen[deciding], episode.observations[0])


@pytest.mark.parametrize("env", ["CartPole-v1", "FrozenLake-v1"])
def test_sessions_of_gymnasium_become_data_sets_with_the_environments_spaces(env, tmp_path, monkeypatch):
    gymnasium = pytest.importorskip("gymnasium")
    from core.session.protocol_reading import protocol_from

    (tmp_path / "data").mkdir()
    protocol = protocol_from(
        {
            "domain": {"type": "gymnasium", "env": env},
            "session": {"episodes": 2, "unseen_between": 0, "watched_steps": 15},
            "trainer": {"knowledge": "myopic", "press_probability": 0.9},
        }
    )
    recording = simulated(tmp_path / "data", protocol)
    exported = export_minari(tmp_path / "data", tmp_path / "sets")
    assert exported.episodes == {f"arl/gymnasium-{env}-v0": 2}
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "sets"))
    data, made = minari.load_dataset(f"arl/gymnasium-{env}-v0"), gymnasium.make(env)
    assert data.spec.observation_space == made.observation_space
    assert data.spec.action_space == made.action_space
    states = [step.state for step in SessionRows(recording, "").steps.values()]
    found = [
        np.ravel(seen).astype(float).tolist()
        for episode in data.iterate_episodes()
        for seen in episode.observations[:-1]
    ]
    assert found == states


def test_a_session_whose_environment_is_gone_is_left_out_with_the_reason(tmp_path, monkeypatch):
    pytest.importorskip("gymnasium")
    from core.session.protocol_reading import protocol_from
    from tests.core.interop import own_task

    own = "tests.core.interop.own_task"
    protocol = protocol_from(
        {
            "domain": {"type": "gymnasium", "env": f"{own}:make", "phi": f"{own}:phi"},
            "session": {"episodes": 1, "unseen_between": 0, "watched_steps": 3},
            "trainer": {"knowledge": "myopic"},
        }
    )
    (tmp_path / "data").mkdir()
    simulated(tmp_path / "data", protocol)
    monkeypatch.delattr(own_task, "make")
    with pytest.raises(ExportError, match=r"session-5.jsonl: there is no function '.*own_task:make'"):
        export_minari(tmp_path / "data", tmp_path / "sets")
