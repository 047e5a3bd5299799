"""An environment of your own in a session: find a lamp, with features for learner and human model.

    python examples/own_environment.py

It plays a session with a simulated participant, records it, and replays it. Before people, in this folder:

    arl play gymnasium:own_environment:make
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import gymnasium
from gymnasium import spaces

from core import build_session, protocol_from, read_recording, replay_exactly
from studies.demo import simulate_session


class Lamp(gymnasium.Env[dict[str, int], int]):
    """A row of nine places. Walk left (0) or right (1) to the lamp; a step nearer pays 1, any other -1."""

    observation_space = spaces.Dict({"place": spaces.Discrete(9), "lamp": spaces.Discrete(9)})
    action_space = spaces.Discrete(2)

    def __init__(self, render_mode: str | None = None) -> None:
        self.render_mode = render_mode

    def reset(self, *, seed: int | None = None, options: Any = None) -> Any:
        """Put walker and lamp somewhere."""
        super().reset(seed=seed)
        self.place, self.lamp = (int(n) for n in self.np_random.permutation(9)[:2])
        return self.seen(), {}

    def step(self, action: int) -> Any:
        """Walk one place."""
        before = abs(self.place - self.lamp)
        self.place = min(max(self.place + (1 if action else -1), 0), 8)
        nearer = abs(self.place - self.lamp) < before
        return self.seen(), 1.0 if nearer else -1.0, self.place == self.lamp, False, {}

    def seen(self) -> dict[str, int]:
        """Return the observation."""
        return {"place": self.place, "lamp": self.lamp}

    def render(self) -> str:
        """Return the row as text."""
        return "".join("@" if n == self.place else "*" if n == self.lamp else "." for n in range(9))


def make(render_mode: str | None = None) -> Lamp:
    """Return the environment: `gymnasium:own_environment:make`."""
    return Lamp(render_mode)


def phi(observation: dict[str, int]) -> list[float]:
    """Return what the learner sees: numbers from 0 to 1, because a dictionary cannot be tiled."""
    return [observation["place"] / 8, observation["lamp"] / 8]


def psi(numbers: tuple[float, ...], action: int) -> list[float]:
    """Return what the human model sees of an action: whether it leads towards the lamp."""
    place, lamp = numbers
    towards = 1.0 if (lamp > place) == bool(action) else 0.0
    return [towards, 1.0 - towards]


def main() -> None:
    """Play, record, replay."""
    protocol = protocol_from(
        {
            "domain": {
                "type": "gymnasium",
                "env": "own_environment:make",
                "phi": "own_environment:phi",
                "psi": "own_environment:psi",
                "joint": True,
            },
            "agent": {"human_model": {"type": "ridge"}},
            "session": {"episodes": 5, "unseen_between": 5, "watched_steps": 40, "unseen_steps": 40},
            "trainer": {"knowledge": "myopic", "press_probability": 0.5},
        }
    )
    with TemporaryDirectory() as folder:
        path = simulate_session(protocol, 1, Path(folder) / "lamp.jsonl", software={})
        recording = read_recording(path)
    result = replay_exactly(recording, build_session(protocol, recording.header.root_seed))
    print(f"Recorded {len(recording.outputs)} outputs; replay: {result.difference or 'exact'}")


if __name__ == "__main__":
    main()
