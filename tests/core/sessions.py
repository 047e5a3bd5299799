"""Small simulated sessions for tests."""

from pathlib import Path

from core.feedback.keys import KeyConfig
from core.feedback.trainers import TrainerConfig
from core.recording.reader import Recording, read_recording
from core.session.protocol import Protocol, SessionConfig
from studies.demo import simulate_session

TALKATIVE = TrainerConfig(press_probability=0.6, max_presses=20)


def small_protocol(**changes) -> Protocol:
    """A session of seconds: three watched episodes, twenty unseen ones between."""
    settings = {
        "session": SessionConfig(episodes=3, unseen_between=20, watched_steps=12, unseen_steps=100),
        "keys": KeyConfig(max_presses_per_episode=20),
        "trainer": TALKATIVE,
    }
    return Protocol(**settings | changes)


def simulated(folder: Path, protocol: Protocol | None = None, *, root_seed: int = 5) -> Recording:
    """Play and record a session, read it back."""
    path = folder / f"session-{root_seed}.jsonl"
    simulate_session(protocol or small_protocol(), root_seed, path, software={})
    return read_recording(path)
