"""What keepers had learned by the end of a recorded session."""

from pathlib import Path

import numpy as np

from core.events import EpisodeEnded, SessionEnded, UnseenPlayed
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.policy_file import N_LAST, PolicyFileError, PolicyHeader, SavedPolicy
from core.learners.sarsa_config import SarsaConfig
from core.numerics.clock import S_PER_HOUR
from core.numerics.tile_coding import from_runs
from core.recording.joined import read_session
from core.recording.reader import Recording, RecordingError
from core.session.protocol_reading import protocol_from

N_TILINGS = 32
"""Tilings per variable in sessions (`core.keepaway.domain.Keepaway`)."""


def recorded_policy(path: Path) -> SavedPolicy:
    """Return the environment's learners of a session as they were at its end; what people taught is not in
    it.

    Raises:
        PolicyFileError: the file is not a whole recording of Keepaway.
        OSError: the file cannot be read.
    """
    try:
        recording = read_session(path)
        protocol = protocol_from(recording.header.protocol)
    except (RecordingError, ValueError) as error:
        raise PolicyFileError(str(error)) from error
    task, learner = protocol.domain, protocol.learner
    if not (isinstance(task, KeepawayConfig) and isinstance(learner, SarsaConfig)):
        raise PolicyFileError(f"{path}: a session of {protocol.game}, not of keepaway learned by Sarsa")
    said_last = [event for event in recording.events if isinstance(event, SessionEnded)]
    if not said_last:
        raise PolicyFileError(
            f"{path}: the session was cut off before its last word, so nothing says what had been learned"
        )
    durations = _durations(recording)
    header = PolicyHeader(
        task=task,
        learner=learner,
        n_tilings=N_TILINGS,
        root_seed=recording.header.root_seed,
        hours=sum(durations) / S_PER_HOUR,
        episodes=len(durations),
        duration_s=float(np.mean(durations[-N_LAST:])) if durations else 0.0,
        created_utc=recording.header.created_utc,
        software=recording.header.software,
    )
    weights = said_last[-1].weights
    try:
        shape = tuple(int(length) for length in weights["sarsa-shape"])
        flat = from_runs(
            np.array(weights["sarsa-starts"]), np.array(weights["sarsa-values"]), int(np.prod(shape))
        )
        return SavedPolicy(header, flat.reshape(shape))
    except (KeyError, ValueError) as error:
        raise PolicyFileError(
            f"{path}: the session's last word holds no weights of Sarsa ({error})"
        ) from error


def _durations(recording: Recording) -> list[float]:
    """Return the duration of every episode, watched or not, in seconds and in order."""
    durations: list[float] = []
    for event in recording.events:
        if isinstance(event, EpisodeEnded):
            durations.append(event.performance)
        elif isinstance(event, UnseenPlayed):
            durations += event.performances
    return durations
