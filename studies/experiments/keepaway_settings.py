"""Settings that experiments in Keepaway share: who plays, who watches, for how long.

The constants were chosen on pilot seeds (`docs/decisions/keepaway-experiments.md`), none of which is
reported.
"""

from core.combination.config import (
    AgentConfig,
    BootstrapConfig,
    Equation4,
    FixedWeight,
    Linear,
    Scheme,
    TrustRule,
)
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import Delay, Density, GammaDelay
from core.keepaway.arl_autoplay import ArlKeepawayConfig
from core.keepaway.participant_config import KeepawayPersonConfig
from core.learners.human_config import TileModel
from studies.experiments.keepaway_trial import KeepawayTrial

HUMAN_STEP = 0.3
"""Fraction of a sample's error that the human model takes out."""
HUMAN_SHARED = True
"""One human model for all keepers: a press teaches three keepers at once."""
BELIEVED = FixedWeight(1.0)
"""In place of a rule of trust where none is asked for: as much say as the environment."""
HOURS = 10.0
"""Simulated hours of a trial: where the published curves have risen most of their way."""

DEPARTURES = (
    (
        "the participants are simulated: they judge by the hand-coded policy of the benchmark, on what the "
        "keeper sees"
    ),
    "each pass may be judged when it is made, holding now and then",
    "every episode is watched",
    (
        "the human model is linear over the tiles of the learner, one for all keepers, learned by gradient "
        "descent"
    ),
    "R and H are standardised over the options of each decision",
    "every episode is a policy of its own in Eq. 4: the learner changes all the time",
)


def person(
    mistake_rate: float = 0.1, delay: Density | None = None, *, holds_noticed_per_s: float = 0.3
) -> KeepawayPersonConfig:
    """Return the paper's participant (section 4): at most 2 presses per episode, about 1 in 10 wrong.

    Args:
        mistake_rate: chance of the wrong key, in [0, 1].
        delay: their true delay; the paper's density by default.
        holds_noticed_per_s: see `KeepawayPersonConfig`.
    """
    trainer = TrainerConfig(
        press_probability=0.3, max_presses=2, mistake_rate=mistake_rate, delay=delay or GammaDelay()
    )
    return KeepawayPersonConfig(trainer=trainer, holds_noticed_per_s=holds_noticed_per_s)


def sarsa_alone(hours: float = HOURS) -> KeepawayTrial:
    """Return a trial in which nobody watches."""
    return KeepawayTrial(play=ArlKeepawayConfig(person=None), hours=hours)


def arl(
    scheme: Scheme | None = None,
    trust: TrustRule | None = None,
    delay: Delay | None = None,
    *,
    watched_by: KeepawayPersonConfig | None = None,
    hours: float = HOURS,
) -> KeepawayTrial:
    """Return a trial of ARL over Sarsa.

    Args:
        scheme: Eq. 3 by default.
        trust: Eq. 4 by default.
        delay: how presses are credited; the paper's density by default.
        watched_by: the paper's participant by default.
        hours: simulated hours.
    """
    agent = AgentConfig(
        scheme=scheme or Linear(),
        bootstrap=BootstrapConfig(trust=trust or Equation4()),
        credit=CreditConfig(delay=delay or GammaDelay()),
        human_model=TileModel(step_size=HUMAN_STEP, shared=HUMAN_SHARED),
    )
    return KeepawayTrial(play=ArlKeepawayConfig(agent=agent, person=watched_by or person()), hours=hours)
