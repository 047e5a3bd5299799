"""Our own play, logged as the reference's is."""

from core.keepaway.autoplay import Autoplay
from core.keepaway.simulator.policies import POLICIES
from studies.fidelity.keepaway_fidelity import Setting, play_cycles
from studies.fidelity.keepaway_rollouts import LoggedEpisode


def played(setting: Setting, n_episodes: int) -> list[LoggedEpisode]:
    """Return episodes of our own, as they would have been logged."""
    game = Autoplay(setting.config, 77, "as logged")
    return [
        LoggedEpisode(ball, players, kicked, setting.config.n_keepers)
        for ball, players, kicked in play_cycles(game, POLICIES[setting.policy], n_episodes)
    ]
