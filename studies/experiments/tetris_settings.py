"""Settings that experiments in Tetris share: who plays, who watches, for how long."""

import msgspec

from core.combination.config import AgentConfig, BootstrapConfig, Equation4, Linear, Scheme, TrustRule
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import Delay, PreviousStep
from core.learners.human_config import RidgeModel
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.tetris.config import TetrisConfig

ITERATIONS = 15
EPISODES_PER_ITERATION = 100
"""The population of one cross-entropy iteration."""
PIECE_CAP = 20_000
"""A game is stopped there: about 8,000 lines. Fewer than 1 in 50 of all games get so far."""

TICK_MS = 150
"""Pace of TAMER's demo: a placement is on screen for 2.1 s, as in its public logs (medians of 2.0 to 2.9 s),
so that nearly every press comes before the next piece lands: the paper's "instantaneous" feedback."""

PERSON = TrainerConfig(press_probability=0.05, max_presses=5, mean_presses=2.0, mistake_rate=0.1)
"""The paper's participants (section 4): at most 5 presses per episode, 2 on average; and 1 in 10 wrong."""

DEPARTURES = (
    (
        "the participants are simulated: they judge a placement by a far better player (DT-20), good if in its "  # noqa: E501
        "best quarter"
    ),
    "every episode is watched, and every episode is one sample of the cross-entropy method",
    f"a game is stopped after {PIECE_CAP} pieces and counts with the lines it has",
    "R and H are standardised over the actions of each decision",
)


HUMAN_MODEL = RidgeModel(l2=10.0)
"""Least squares with ten times the default's penalty: with a few hundred unreliable presses it foresees the
next ones better (found on pilot seeds)."""


def tetris_agent(
    scheme: Scheme | None = None, trust: TrustRule | None = None, delay: Delay | None = None
) -> AgentConfig:
    """Return how environment and participant are combined.

    Args:
        scheme: f(R, H); linear by default (Eq. 3).
        trust: how w_h is found; Eq. 4 by default.
        delay: of credit; the previous placement by default.
    """
    return AgentConfig(
        scheme=scheme or Linear(),
        bootstrap=BootstrapConfig(trust=trust or Equation4()),
        credit=CreditConfig(delay=delay or PreviousStep()),
        human_model=HUMAN_MODEL,
    )


def session(
    agent: AgentConfig, person: TrainerConfig = PERSON, *, features: str = "bertsekas-21"
) -> Protocol:
    """Return the protocol of one trial: 15 iterations of 100 watched games.

    Args:
        agent: how environment and participant are combined.
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
        screen=ScreenConfig(tick_ms=TICK_MS),
        trainer=person,
    )


def quick(protocol: Protocol) -> Protocol:
    """Return a trial of a second: 2 iterations of games of at most 500 pieces."""
    shorter = msgspec.structs.replace(
        protocol.session, episodes=2 * EPISODES_PER_ITERATION, watched_steps=500
    )
    return msgspec.structs.replace(protocol, session=shorter)
