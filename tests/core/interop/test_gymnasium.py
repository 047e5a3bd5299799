"""Gymnasium environments play, are recorded, replayed and asked about as the program's own games are."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from core.interop.gymnasium.config import GymnasiumConfig
from core.interop.gymnasium.game import GymnasiumDomain
from core.plugins import GameError
from core.registry import game_of
from core.session.protocol import DEFAULTS
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from core.session.what_if import relearn, watched_steps
from tests.contracts.domain_contract import DomainContract
from tests.core.sessions import simulated

SHORT = {
    "session": {"episodes": 2, "unseen_between": 1, "watched_steps": 15, "unseen_steps": 30},
    "trainer": {"knowledge": "myopic", "press_probability": 0.9, "max_presses": 9},
}
SHORTER = {**SHORT, "session": {"episodes": 2, "unseen_between": 1, "watched_steps": 3, "unseen_steps": 6}}
"""For Taxi, whose every copy takes 20 ms: it holds a table of all 3,000 transitions."""
TAXI = max(name for name in gymnasium.registry if name.startswith("Taxi-"))
ENVS = ["CartPole-v1", "MountainCar-v0", "FrozenLake-v1", TAXI, "Acrobot-v1"]


class TestContract(DomainContract):
    """CartPole ends soon under random play, FrozenLake has discrete observations."""

    @pytest.fixture(params=["CartPole-v1", "FrozenLake-v1"], scope="class")
    def domain(self, request: Any) -> GymnasiumDomain:
        return GymnasiumDomain(GymnasiumConfig(request.param))

    def test_another_seed_gives_another_episode(self, domain: GymnasiumDomain) -> None:
        # On the frozen lake two seeds may slip alike; states hold their seeds.
        assert domain.initial(3) != domain.initial(4)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("env", ENVS)
def test_an_environment_plays_is_recorded_replayed_and_asked_about(env: str, tmp_path: Path) -> None:
    short = SHORTER if env == TAXI else SHORT
    protocol = protocol_from({"domain": {"type": "gymnasium", "env": env}, **short})
    recording = simulated(tmp_path, protocol)
    read = protocol_from(recording.header.protocol)
    assert read == protocol
    result = replay_exactly(recording, build_session(read, recording.header.root_seed))
    assert (result.difference, result.outputs) == (None, len(recording.outputs))
    steps = watched_steps(recording, read)
    again = relearn(recording, read, steps, root_seed=recording.header.root_seed)
    assert again.agent.digest() == recording.outputs[-1].digest


def test_sarsa_keeps_the_pole_up_longer_with_practice() -> None:
    protocol = protocol_from({"domain": {"type": "gymnasium", "env": "CartPole-v1"}})
    game = game_of(protocol)
    agent = game.agent(protocol, 1)
    play = game.player(protocol, agent)
    kept = []
    for seed in range(150):
        policy = agent.begin_episode(exploring=True, watched=False)
        played = play(policy, seed, 200)
        agent.learn_from_domain(policy, played)
        kept.append(played.performance)
    # Random play keeps it for 22 steps on average.
    assert np.mean(kept[-30:]) > 60


class Unseeded(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0.0, 1.0, (1,))
    action_space = gymnasium.spaces.Discrete(2)

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        return np.random.default_rng().random(1), {}

    def step(self, action: int) -> Any:
        return np.random.default_rng().random(1), 0.0, False, False, {}


class Broken(Unseeded):
    def step(self, action: int) -> Any:
        raise RuntimeError("no wheels")


class Calm(gymnasium.Env):
    """The simplest that can be played: of it the ones below have one fault each."""

    observation_space = gymnasium.spaces.Box(0.0, 1.0, (1,))
    action_space = gymnasium.spaces.Discrete(2)
    seen: Any = (0.5,)
    reward: Any = 1.0
    ended = (False, False)

    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        super().reset(seed=seed)
        return self.seen, {}

    def step(self, action: int) -> Any:
        return self.seen, self.reward, *self.ended, {}


class Unreset(Calm):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        raise KeyError("no map")


class OldStep(Calm):
    def step(self, action: int) -> Any:
        return self.seen, 1.0, False, {}


class NoReward(Calm):
    reward = float("nan")


class HugeReward(Calm):
    reward = 1e200


class LargeReward(Calm):
    reward = -1e90


class AtOnce(Calm):
    ended = (False, True)


class Longer(Calm):
    seen = (0.5, 0.5)


class Worded(Calm):
    seen = "left"


class ManyStates(Calm):
    observation_space = gymnasium.spaces.Discrete(10**9)


class ManyActions(Calm):
    action_space = gymnasium.spaces.Discrete(10**6)


class Vector(Calm):
    observation_space = gymnasium.spaces.MultiDiscrete([9, 9])


class FailsLater(Calm):
    def reset(self, *, seed: Any = None, options: Any = None) -> Any:
        self.steps = 0
        return super().reset(seed=seed)

    def step(self, action: int) -> Any:
        self.steps += 1
        return self.seen, 1.0 if self.steps < 300 else float("inf"), False, False, {}


def failing_factory(**_settings: Any) -> Any:
    raise OSError("no such robot")


def nothing_made(**_settings: Any) -> None:
    return None


OWN = "tests.core.interop.own_task"


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize(
    ("settings", "told"),
    [
        ({"env": "Pendulum-v1"}, "only discrete ones can be learned here. Needed is a wrapper"),
        ({"env": "Blackjack-v1"}, r"has the observations Tuple.*\[domain\] phi ="),
        ({"env": f"{OWN}:make"}, r"has the observations Dict.*\[domain\] phi ="),
        ({"env": f"{__name__}:image"}, r"has the observations Box\(0, 255, \(84, 84, 3\).*phi"),
        ({"env": "MountainCarContinuous-v0"}, r"has the actions Box.*Discrete\(n\)"),
        ({"env": "NoSuch-v7"}, "has no environment 'NoSuch-v7'.*module:function"),
        ({"env": "MountainCra-v0"}, "the nearest is MountainCar-v0. Say `arl play gymnasium:MountainCar-v0`"),
        ({"env": "MountainCar-v7"}, "the nearest is MountainCar-v0"),
        ({"env": "Nowhere/Pong-v5"}, 'Install it, and name the module.*"module:Nowhere/Pong-v5"'),
        pytest.param(
            {"env": "Taxi-v3"},
            f"has no environment 'Taxi-v3': the nearest is {TAXI}",
            marks=pytest.mark.skipif(TAXI == "Taxi-v3", reason="this Gymnasium has it"),
        ),
        ({"env": f"{__name__}:failing_factory"}, "OSError: no such robot. It was called as a factory, with"),
        ({"env": f"{__name__}:nothing_made"}, "gave a NoneType: expected is a gymnasium.Env"),
        ({"env": "nowhere:make"}, "there is no function 'nowhere:make'.*present folder"),
        ({"env": f"{OWN}:nothing"}, f"there is no function '{OWN}:nothing'"),
        ({"env": f"{OWN}:np"}, "is a module, not a function"),
        ({"env": f"{__name__}:Unseeded"}, "cannot be seeded"),
        (
            {"env": f"{__name__}:Broken"},
            r"step\(\d\) at step 0 of .* seed 0 failed with RuntimeError: no wheels",
        ),
        ({"env": f"{__name__}:Unreset"}, r"reset\(seed=...\) at step 0.*KeyError.*\(observation, info\)"),
        ({"env": f"{__name__}:OldStep"}, r"not enough values.*Expected is \(observation, reward, terminated"),
        ({"env": f"{__name__}:NoReward"}, "gave the reward nan for action . at step 0 of the episode"),
        ({"env": f"{__name__}:HugeReward"}, r"gave the reward 1e\+200.*from -1e\+100 to 1e\+100"),
        ({"env": f"{__name__}:Longer"}, "gave 2 numbers.*1 are expected, as its observation space says"),
        ({"env": f"{__name__}:Worded"}, "gave 'left': numbers are expected"),
        ({"env": f"{__name__}:ManyStates"}, "needs 1,000,000,001 tiles for each of 2 actions.*phi ="),
        ({"env": f"{__name__}:ManyActions"}, "has 1,000,000 actions; the most is 10,000"),
        ({"env": f"{__name__}:Vector"}, r"has the observations MultiDiscrete.*phi ="),
        ({"env": "CartPole-v1", "actions": ("left",)}, "has 1 names.*CartPole-v1 are 0 to 1: name each"),
        ({"phi": f"{OWN}:failing"}, "phi failed: KeyError"),
        ({"phi": f"{OWN}:infinite"}, r"phi gave \(inf,\)"),
        ({"psi": f"{OWN}:psi", "env": "FrozenLake-v1"}, "psi failed: IndexError"),
        ({"env": "Acrobot-v1", "joint": True, "tiles": 12}, "the most is 4,194,304"),
    ],
)
def test_what_cannot_be_played_is_refused_with_what_is_needed(settings: dict[str, Any], told: str) -> None:
    with pytest.raises(GameError, match=told):
        GymnasiumDomain(GymnasiumConfig(**settings))


def test_the_extra_is_named_where_gymnasium_is_not_installed() -> None:
    code = (
        "import importlib.abc, sys\n"
        "class Gone(importlib.abc.MetaPathFinder):\n"
        "    def find_spec(self, name, path, target=None):\n"
        "        if name == 'gymnasium': raise ModuleNotFoundError(name)\n"
        "sys.meta_path.insert(0, Gone())\n"
        "from core.session.protocol_reading import load_protocol\nfrom core.registry import game_of\n"
        "try: game_of(load_protocol(None, game='gymnasium:CartPole-v1'))\n"
        "except ValueError as error: print(type(error).__name__, error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "GameError Gymnasium is not installed: pip install 'arl-tui[gym]'\n"


@pytest.mark.parametrize("env", ["AtOnce", "LargeReward"])
def test_episodes_of_one_step_and_large_negative_rewards_are_played_and_replayed(
    env: str, tmp_path: Path
) -> None:
    protocol = protocol_from({"domain": {"type": "gymnasium", "env": f"{__name__}:{env}"}, **SHORT})
    recording = simulated(tmp_path, protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert (result.difference, result.outputs) == (None, len(recording.outputs))


def test_an_environment_that_fails_in_mid_session_is_named_with_the_step() -> None:
    domain = GymnasiumDomain(GymnasiumConfig(f"{__name__}:FailsLater"))
    state = domain.initial(5)
    for _ in range(299):
        state = domain.transition(state, 1).next_state
    told = "gave the reward inf for action 1 at step 299 of the episode with seed 5: a number"
    with pytest.raises(GameError, match=told):
        domain.transition(state, 1)


@pytest.mark.parametrize(
    ("domain", "told"),
    [
        ({"env": "CartPole"}, 'name an environment of Gymnasium with its version ("CartPole-v1")'),
        ({"env": ""}, "or a function of your own"),
        ({"task": "x" * 61}, "[domain] task"),
        ({"actions": ["left", "a\nb"]}, "at most 18 printable characters"),
    ],
)
def test_what_is_unclear_is_refused_before_a_session_and_read_from_a_recording(
    domain: dict[str, Any], told: str
) -> None:
    plain = {"domain": {"type": "gymnasium", **domain}}
    with pytest.raises(ValueError, match=re.escape(told)):
        protocol_from(plain, to_run=True)
    assert protocol_from(plain).game == "gymnasium"


def test_a_variant_without_a_version_is_refused_with_what_to_say() -> None:
    with pytest.raises(GameError, match=r"with its version.*got 'CartPole'"):
        DEFAULTS["gymnasium:CartPole"]


def image() -> Any:
    env = Unseeded()
    env.observation_space = gymnasium.spaces.Box(0, 255, (84, 84, 3), np.uint8)
    return env


@pytest.mark.parametrize("env", [f"{OWN}:make", f"{OWN}:Uncopied"])
def test_an_environment_of_ones_own_with_features_is_played_recorded_and_replayed(
    env: str, tmp_path: Path
) -> None:
    protocol = protocol_from(
        {
            "domain": {
                "type": "gymnasium",
                "env": env,
                "phi": f"{OWN}:phi",
                "psi": f"{OWN}:psi",
                "joint": True,
            },
            "agent": {"human_model": {"type": "ridge"}},
            **SHORT,
        }
    )
    recording = simulated(tmp_path, protocol)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    assert (result.difference, result.outputs) == (None, len(recording.outputs))
    again = relearn(
        recording, protocol, watched_steps(recording, protocol), root_seed=recording.header.root_seed
    )
    assert again.agent.digest() == recording.outputs[-1].digest


def test_features_of_ones_own_are_what_is_seen() -> None:
    domain = GymnasiumDomain(
        GymnasiumConfig(f"{OWN}:make", phi=f"{OWN}:phi", psi=f"{OWN}:psi", joint=True, tiles=2, tilings=3)
    )
    state = domain.initial(4)
    place, lamp = state.given["place"], state.given["lamp"]
    choices = domain.choices(state)
    assert domain.recorded_state(state) == [place / 8, lamp / 8]
    towards = 1.0 if lamp > place else -1.0
    assert choices.observation.tolist() == [place / 8, lamp / 8]
    assert domain.coder.n_tiles == 3 * 9
    assert choices.feedback_features.tolist() == [[-towards, 1.0], [towards, 1.0]]
    assert domain.observation_names == ("phi 0", "phi 1")
    assert domain.feedback_feature_names == ("psi 0", "psi 1")
    # The environment's first action is 5.
    assert domain.action_record(state, 1).plain() == {"action": 6, "time": 0}


def test_states_are_the_same_by_copies_and_by_seed_and_actions() -> None:
    copied = GymnasiumDomain(GymnasiumConfig(f"{OWN}:make", phi=f"{OWN}:phi"))
    replayed = GymnasiumDomain(GymnasiumConfig(f"{OWN}:Uncopied", phi=f"{OWN}:phi"))
    rng = np.random.default_rng(2)
    for seed in range(5):
        first, second = copied.initial(seed), replayed.initial(seed)
        kept = [(first, second)]
        for _ in range(30):
            # Now and then from an earlier state: the one environment has to go back.
            first, second = kept[int(rng.integers(len(kept)))] if rng.random() < 0.3 else kept[-1]
            if first.over:
                break
            action = int(rng.integers(2))
            first = copied.transition(first, action).next_state
            second = replayed.transition(second, action).next_state
            assert first == second
            kept.append((first, second))


@pytest.mark.parametrize(
    ("domain", "model", "told"),
    [
        ({"psi": "a:b"}, "tiles", 'set [agent.human_model] type = "ridge"'),
        ({}, "ridge", "name features"),
    ],
)
def test_a_human_model_that_cannot_learn_from_what_it_sees_is_refused(
    domain: dict[str, Any], model: str, told: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(told)):
        protocol_from({"domain": {"type": "gymnasium", **domain}, "agent": {"human_model": {"type": model}}})


def test_what_goes_out_comes_in_by_features() -> None:
    domain = GymnasiumDomain(GymnasiumConfig(f"{__name__}:primitive_tetris", phi=f"{__name__}:heights"))
    assert domain.n_actions == 5
    assert len(domain.initial(0).observation) == 10


def primitive_tetris() -> Any:
    return gymnasium.make("arl/Tetris-v0", actions="primitives")


def heights(observation: Any) -> Any:
    return observation["board"].sum(axis=0) / 20
