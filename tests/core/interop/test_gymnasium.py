"""Gymnasium environments play, are recorded, replayed and asked about as the program's own games are."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from core.interop.gymnasium.config import GymnasiumConfig
from core.interop.gymnasium.game import GymnasiumDomain
from core.plugins import GameError
from core.registry import game_of
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


class NoCopies(Unseeded):
    def __init__(self) -> None:
        self.file = Path(__file__).open()  # noqa: SIM115

    def __del__(self) -> None:
        if hasattr(self, "file"):
            self.file.close()


@pytest.mark.parametrize(
    ("env", "told"),
    [
        ("Pendulum-v1", "only discrete ones can be learned"),
        ("Blackjack-v1", "has the observations"),
        ("NoSuch-v7", "'NoSuch-v7' cannot be made"),
        (f"{__name__}:Unseeded", "cannot be seeded"),
        (f"{__name__}:NoCopies", "cannot be copied"),
    ],
)
def test_what_cannot_be_played_is_refused_with_the_reason(env: str, told: str) -> None:
    with pytest.raises(GameError, match=told):
        GymnasiumDomain(GymnasiumConfig(env))
