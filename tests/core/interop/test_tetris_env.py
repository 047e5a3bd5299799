"""The program's Tetris is a Gymnasium environment: its checker passes, and games are the sessions'."""

import subprocess
import sys
import warnings
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env

from core.interop.gymnasium.envs import TETRIS, register_envs
from core.interop.gymnasium.tetris_env import PRIMITIVES, TetrisEnv
from core.tetris.afterstate import Tetris
from core.tetris.config import TetrisConfig
from core.tetris.game import Primitive, reachable_placements

SMALL = {"rows": 8, "columns": 6}


@pytest.mark.parametrize("actions", ["placements", "primitives"])
def test_gymnasiums_checker_passes(actions: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(TETRIS, actions=actions)
        check_env(env.unwrapped)


@pytest.mark.parametrize(
    "begin",
    [
        "import gymnasium, core.interop.gymnasium; name = 'arl/Tetris-v0'",
        "import core.interop.gymnasium.envs, gymnasium; name = 'arl/Tetris-v0'",
        "import gymnasium; name = 'core.interop.gymnasium.envs:arl/Tetris-v0'",
    ],
)
def test_one_import_makes_it_known(begin: str) -> None:
    code = f"{begin}; print(gymnasium.make(name).reset(seed=1)[0]['board'].shape)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "(20, 10)"


def test_protocols_are_read_without_gymnasium() -> None:
    code = (
        "import sys; from core.session.protocol_reading import protocol_from; "
        "protocol_from({'domain': {'type': 'gymnasium'}}); print('gymnasium' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_registering_twice_changes_nothing() -> None:
    before = gymnasium.registry[TETRIS]
    register_envs()
    assert gymnasium.registry[TETRIS] is before


def test_placements_are_those_of_a_session_with_the_same_episode_seed() -> None:
    domain, env = Tetris(TetrisConfig(**SMALL)), TetrisEnv(**SMALL)
    state = domain.initial(5)
    observation, info = env.reset(options={"episode_seed": 5})
    rng = np.random.default_rng(0)
    while not domain.terminal(state):
        placements = domain.placements(state)
        assert sorted(map(tuple, np.argwhere(info["action_mask"]))) == sorted(map(tuple, placements))
        assert observation["piece"] == domain.piece(state)
        choice = int(rng.integers(len(placements)))
        step = domain.transition(state, choice)
        observation, reward, terminated, truncated, info = env.step(placements[choice])
        state = step.next_state
        assert (reward, terminated, truncated) == (step.reward, domain.terminal(state), False)
        assert info["offered"]
        cells = [[column >> row & 1 for column in state.columns] for row in range(8)]
        assert observation["board"].tolist() == cells
        # The picture is made from settled pieces, the observation from the rules: they agree.
        letters = env._wall.board
        assert letters == state.columns
    assert info["action_mask"].sum() == 0
    with pytest.raises(ValueError, match=r"call reset\(\)"):
        env.step(placements[0])


def test_a_placement_that_is_not_offered_changes_nothing_and_says_so() -> None:
    env = TetrisEnv()
    before, info = env.reset(options={"episode_seed": 0})
    orientation, column = np.argwhere(info["action_mask"] == 0)[0]
    after, reward, terminated, _, info = env.step(np.array([orientation, column]))
    assert (reward, terminated, info["offered"], info["pieces"]) == (0.0, False, False, 0)
    assert np.array_equal(before["board"], after["board"])
    assert before["piece"] == after["piece"]


def test_primitives_bring_about_the_placements_that_they_reach() -> None:
    env, domain = TetrisEnv("primitives", **SMALL), Tetris(TetrisConfig(**SMALL))
    rng = np.random.default_rng(3)
    for seed in range(10):
        env.reset(options={"episode_seed": seed})
        state = domain.initial(seed)
        for _ in range(6):
            if domain.terminal(state):
                break
            plans = reachable_placements(state.columns, domain.piece(state), 8)
            places = domain.placements(state).tolist()
            reachable = [at for at, place in enumerate(places) if tuple(place) in plans]
            if not reachable:
                break
            choice = reachable[int(rng.integers(len(reachable)))]
            state = domain.transition(state, choice).next_state
            for primitive in plans[tuple(places[choice])]:
                env.step(PRIMITIVES.index(primitive))
            assert (env.state.columns, env.state.lines, env.state.k) == (state.columns, state.lines, state.k)


def test_a_game_of_drops_alone_ends_by_primitives() -> None:
    env = TetrisEnv("primitives", **SMALL)
    env.reset(seed=1)
    drops, terminated = 0, False
    while not terminated and drops < 100:
        _, _, terminated, _, info = env.step(PRIMITIVES.index(Primitive.DROP))
        drops += 1
    # Pieces of at most 4 rows in the middle of 8 rows: at least 3 drops, at most 9.
    assert 3 <= drops == info["pieces"] <= 9


def test_pictures() -> None:
    env = TetrisEnv(render_mode="ansi", **SMALL)
    env.reset(options={"episode_seed": 1})
    env.step(np.array([0, 0]))
    lines = env.render().splitlines()
    assert len(lines) == 8 + 2
    assert lines[-1].startswith("lines 0  pieces 1  next ")
    assert sum(line.count(".") for line in lines) == 8 * 6 - 4
    env = TetrisEnv("primitives", render_mode="rgb_array", **SMALL)
    env.reset(options={"episode_seed": 1})
    pixels = env.render()
    assert (pixels.shape, pixels.dtype) == ((128, 96, 3), np.uint8)
    # Four cells of the falling piece: the floor of every other cell is dark.
    assert (pixels[::16, ::16].max(axis=2) > 100).sum() == 4


@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"actions": "keys"}, "placements"),
        ({"render_mode": "human"}, "rgb_array"),
        ({"rows": 2}, "rows of a Tetris board"),
    ],
)
def test_what_it_does_not_know_is_refused(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        TetrisEnv(**settings)
