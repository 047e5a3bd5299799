"""One trial in Keepaway: keepers learn by Sarsa while a simulated person watches every episode."""

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.keepaway.arl_autoplay import ArlAutoplay, ArlKeepawayConfig

SECONDS_PER_HOUR = 3600.0


class KeepawayTrial(msgspec.Struct, frozen=True, kw_only=True):
    """All that decides a trial but its root seed."""

    play: ArlKeepawayConfig = ArlKeepawayConfig()
    hours: float = 10.0
    """Simulated hours of play; the trial ends with the episode that reaches them. Pauses do not count."""

    def __post_init__(self) -> None:
        if not self.hours > 0:
            raise ValueError(f"a trial takes more than 0 hours, got {self.hours}")


def run_trial(settings: KeepawayTrial, root_seed: int) -> dict[str, NDArray[np.float64]]:
    """Play a trial; a pure function of its arguments.

    Trials of one seed meet the same kick-offs, and people with the same draws, under every condition.

    Returns:
        Columns with one number per episode: seconds it lasted, hours of play at its end, presses that counted, w_h
        during the episode, whether the ball went out (1) or was taken (0).
    """
    game = ArlAutoplay(settings.play, root_seed, "keepaway trial")
    limit_s, played_s = settings.hours * SECONDS_PER_HOUR, 0.0
    rows: list[tuple[float, ...]] = []
    while played_s < limit_s:
        episode = game.play_episode()
        played_s += episode.duration_s
        hours = played_s / SECONDS_PER_HOUR
        rows.append((episode.duration_s, hours, episode.accepted, episode.w_h, episode.out))
    table = np.array(rows, np.float64)
    return dict(zip(("seconds", "hours", "presses", "w_h", "out"), table.T, strict=True))


def quick(settings: KeepawayTrial) -> KeepawayTrial:
    """Return a trial of a second: six minutes of play."""
    return msgspec.structs.replace(settings, hours=0.1)
