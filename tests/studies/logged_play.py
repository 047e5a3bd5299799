"""Our own play, logged as the reference's is."""

import numpy as np

from core.keepaway.autoplay import Autoplay
from core.keepaway.pitch import KICK, KIND
from core.keepaway.simulator.game import step_cycle
from core.keepaway.simulator.match import start_episode
from core.keepaway.simulator.policies import POLICIES
from core.numerics.compiled import specialised
from studies.fidelity.keepaway_fidelity import Setting
from studies.fidelity.keepaway_rollouts import LoggedEpisode


def played(setting: Setting, n_episodes: int) -> list[LoggedEpisode]:
    """Return episodes of our own, as they would have been logged."""
    game = Autoplay(setting.config, 77, "as logged")
    match, rules, streams = game.match, game.rules, game.streams
    policy = POLICIES[setting.policy]
    step = specialised(step_cycle, match, rules, policy, streams)
    episodes = []
    for _ in range(n_episodes):
        start_episode(match, rules, streams.placement)
        balls, rows = [match.ball.copy()], [match.players.copy()]
        kicked = [np.zeros(len(match.players), np.bool_)]
        while not step(match, rules, policy, streams):
            balls.append(match.ball.copy())
            rows.append(match.players.copy())
            kicked.append(match.commands[:, KIND] == KICK)
        episodes.append(
            LoggedEpisode(np.array(balls), np.array(rows), np.array(kicked), setting.config.n_keepers)
        )
    return episodes
