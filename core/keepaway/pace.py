"""How long options are on screen: some episodes are played, and their options timed.

Half of the episodes are those of a team that chooses at random, as an untrained one does, half those of the
hand-coded policy. In 3v2 on 20 m x 20 m a pass takes 6.6 cycles on average, a hold one.
"""

from collections.abc import Iterator

from core.feedback.viewing import Viewing, Watched
from core.keepaway.domain import Keepaway
from core.keepaway.simulator.policies import hand_coded
from core.numerics.interpreting import is_interpreting
from core.numerics.streams import stream

EPISODES = 12
EPISODES_IN_PYTHON = 2
"""While kernels are not compiled yet: an episode then takes seconds."""
MOST_OPTIONS = 150
"""Of one episode: the hand-coded policy may keep the ball for minutes."""


def options_on_screen(domain: Keepaway, viewing: Viewing) -> tuple[Watched, ...]:
    """Return how the options of 12 episodes are seen, in order; of the first 2 while Python stands in for
    kernels.
    """
    episodes = EPISODES_IN_PYTHON if is_interpreting() else EPISODES
    return tuple(watched for seed in range(episodes) for watched in _one_episode(domain, viewing, seed))


def _one_episode(domain: Keepaway, viewing: Viewing, seed: int) -> Iterator[Watched]:
    rng, task = stream(seed, "pace"), domain.config
    state = domain.initial(seed)
    for _ in range(MOST_OPTIONS):
        if domain.terminal(state):
            return
        if seed % 2 == 0:
            action = int(rng.integers(task.n_actions))
        else:
            action = hand_coded(state.variables, task.n_keepers, task.n_takers)
        following = domain.transition(state, action).next_state
        yield viewing.watched(state, action, following)
        state = following
