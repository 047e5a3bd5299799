"""The program's Keepaway is a PettingZoo environment: its tests pass, and matches are the sessions'."""

import warnings
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pettingzoo")

with warnings.catch_warnings():
    # PettingZoo's tests import an environment of its own in a way that it deprecates.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test

from core.interop.pettingzoo import keepaway_v0
from core.interop.spaces import keepaway_names
from core.keepaway.domain import Keepaway
from core.keepaway.pitch import CYCLE_S, KeepawayConfig

pytestmark = pytest.mark.jit


def test_pettingzoos_test_of_the_parallel_interface_passes() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(keepaway_v0.parallel_env(), num_cycles=300)


def test_pettingzoos_test_of_seeds_passes() -> None:
    parallel_seed_test(keepaway_v0.parallel_env, num_cycles=100)


@pytest.mark.filterwarnings("ignore:Agent's m:UserWarning")  # belief has no bounds
def test_turns_instead_of_parallel_steps_pass_their_test_as_well() -> None:
    api_test(keepaway_v0.env(), num_cycles=100)


def test_another_seed_gives_another_match() -> None:
    env = keepaway_v0.parallel_env()
    first, _ = env.reset(seed=1)
    other, _ = env.reset(seed=2)
    again, _ = env.reset(seed=1)
    assert not np.array_equal(first["keeper_0"], other["keeper_0"])
    assert np.array_equal(first["keeper_0"], again["keeper_0"])


@pytest.mark.parametrize("settings", [{}, {"n_keepers": 4, "n_takers": 3}])
def test_a_match_is_that_of_a_session_with_the_same_episode_seed(settings: dict[str, Any]) -> None:
    domain, env = Keepaway(KeepawayConfig(**settings)), keepaway_v0.parallel_env(**settings)
    rng = np.random.default_rng(4)
    for seed in range(5):
        state = domain.initial(seed)
        if domain.terminal(state):
            continue
        seen, infos = env.reset(options={"episode_seed": seed})
        assert len(seen["keeper_0"]) == len(keepaway_names(env.config)) == len(state.variables)
        # The seconds until the first decision belong to no step.
        seconds = infos["keeper_0"]["cycle"] * CYCLE_S
        while env.agents:
            wanted = {name: int(rng.integers(domain.n_actions)) for name in env.agents}
            deciding = [name for name in env.agents if infos[name]["decides"]]
            for name in deciding:
                assert name == f"keeper_{state.keeper}"
                assert np.array_equal(seen[name], state.variables)
                state = domain.transition(state, wanted[name]).next_state
            seen, rewards, terminations, _, infos = env.step(wanted)
            seconds += rewards["keeper_0"]
        assert domain.terminal(state)
        assert all(terminations.values())
        assert seconds == pytest.approx(domain.performance(state))


def test_a_keeper_that_has_to_decide_needs_an_action() -> None:
    env = keepaway_v0.parallel_env()
    _, infos = env.reset(seed=3)
    deciding = next(name for name in env.agents if infos[name]["decides"])
    with pytest.raises(ValueError, match=f"{deciding} has to decide"):
        env.step({name: 0 for name in env.agents if name != deciding})
    with pytest.raises(ValueError, match="Discrete"):
        env.step(dict.fromkeys(env.agents, 7))


def test_pictures() -> None:
    env = keepaway_v0.parallel_env("ansi")
    env.reset(seed=3)
    text = env.render()
    assert sum(text.count(letter) for letter in "123ABo") in (5, 6)  # the ball may cover its keeper
    assert len(text.splitlines()) == 21
    env = keepaway_v0.parallel_env("rgb_array")
    env.reset(seed=3)
    pixels = env.render()
    assert (pixels.shape, pixels.dtype) == ((264, 264, 3), np.uint8)
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 5


@pytest.mark.parametrize("settings", [{"render_mode": "human"}, {"n_keepers": 0}])
def test_what_it_does_not_know_is_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError):
        keepaway_v0.parallel_env(**settings)
