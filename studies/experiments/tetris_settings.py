"""Settings that experiments in Tetris share: who plays, who watches, for how long."""

import msgspec

from core.combination.config import AgentConfig
from core.feedback.config import TrainerConfig
from core.protocol import Protocol, SessionConfig
from core.tetris.config import TetrisConfig

ITERATIONS = 15
EPISODES_PER_ITERATION = 100
"""The population of one cross-entropy iteration."""
PIECE_CAP = 20_000
"""A game is stopped there: about 8,000 lines. Fewer than 1 in 50 of all games get so far."""

PERSON = TrainerConfig(press_probability=0.05, max_presses=5, mean_presses=2.0, mistake_rate=0.1)
"""The paper's participants (section 4): at most 5 presses per episode, 2 on average; and 1 in 10 wrong."""

DEPARTURES = (
    "the participants are simulated: they judge a placement by a far better player (DT-20), good if in its best quarter",
    "every episode is watched, and every episode is one sample of the cross-entropy method",
    f"a game is stopped after {PIECE_CAP} pieces and counts with the lines it has",
    "R and H are standardised over the actions of each decision",
)


def session(
    agent: AgentConfig, person: TrainerConfig = PERSON, *, features: str = "bertsekas-21"
) -> Protocol:
    """Return the protocol of one trial: 15 iterations of 100 watched games.

    Args:
        agent: how environment and human are combined.
        person: the simulated participant.
        features: of the environment's learner.
    """
    return Protocol(
        name="experiment",
        domain=TetrisConfig(placements="all", features=features),
        agent=agent,
        session=SessionConfig(
            episodes=ITERATIONS * EPISODES_PER_ITERATION,
            unseen_between=0,
            watched="proposed",
            watched_steps=PIECE_CAP,
        ),
        trainer=person,
    )


def quick(protocol: Protocol) -> Protocol:
    """Return a trial of a second: 2 iterations of games of at most 500 pieces."""
    shorter = msgspec.structs.replace(
        protocol.session, episodes=2 * EPISODES_PER_ITERATION, watched_steps=500
    )
    return msgspec.structs.replace(protocol, session=shorter)
