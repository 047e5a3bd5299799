"""Mountain Car against the literature: Sarsa(lambda) with tiles, and ways of combining it with feedback."""

from core.combination.config import (
    ActionBiasing,
    AgentConfig,
    Annealed,
    BootstrapConfig,
    ControlSharing,
    EnvironmentOnly,
    Equation4,
    Equation5,
    FixedWeight,
    HumanOnly,
    Linear,
    QAugmentation,
    RewardShaping,
    Scheme,
    TrustRule,
)
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import GammaDelay
from core.feedback.keys import KeyConfig
from core.interop.gymnasium.config import GymnasiumConfig
from core.learners.human_config import TileModel
from core.learners.sarsa_config import SarsaConfig
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from studies.experiments.mountain_car_page import report_page
from studies.experiments.mountain_car_trial import quick, run_trial
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment

EPISODES = 100
"""Of a trial: about 40 minutes before a screen, as long as the sessions of TAMER's public logs (30 to 39
minutes)."""
CAP = 1000
"""Steps after which an episode is broken off. (Our choice; the first ones of Sarsa alone take some 500.)"""
TICK_MS = 150
"""A step on screen (Knox & Stone 2009, Mountain Car)."""
PRESSES_PER_MINUTE = 24
"""The usual rate of TAMER's public logs (three of four: 22 to 24)."""
LEARNER = SarsaConfig(step_size=0.5, trace_decay=0.9, exploration=0.0)
"""8 tilings of 8 x 8, alpha = 0.5 / 8, no exploration, values from 0 (Sutton & Barto 2018, section 10.1 and
figure 10.2); replacing traces, lambda = 0.9 (figure 12.10)."""
TEACHER = TrainerConfig(press_probability=PRESSES_PER_MINUTE * TICK_MS / 60_000, max_presses=CAP)
"""One press in ten is wrong; delays have the paper's density."""
SPARING = TrainerConfig(mean_presses=2.0, press_probability=0.06)
"""The paper's participant (section 4): at most 5 presses in an episode, 2 on average."""
ABSENT = TrainerConfig(press_probability=0.0, max_presses=0)


def trial(
    scheme: Scheme | None = None, trust: TrustRule | None = None, *, taught_by: TrainerConfig = TEACHER
) -> Protocol:
    """Return the settings of a trial.

    Args:
        scheme: how environment and participant are combined; Eq. 3 by default.
        trust: rule of w_h; Eq. 4 by default.
        taught_by: who watches every episode.
    """
    return Protocol(
        domain=GymnasiumConfig("MountainCar-v0", joint=True),
        learner=LEARNER,
        agent=AgentConfig(
            scheme=scheme or Linear(),
            bootstrap=BootstrapConfig(trust=trust or Equation4()),
            credit=CreditConfig(delay=GammaDelay()),
            human_model=TileModel(),
        ),
        keys=KeyConfig(max_presses_per_episode=CAP),
        trainer=taught_by,
        session=SessionConfig(episodes=EPISODES, unseen_between=0, watched_steps=CAP, unseen_steps=CAP),
        screen=ScreenConfig(tick_ms=TICK_MS),
    )


EXPERIMENT = Experiment(
    title="Mountain Car: Sarsa and presses, against the literature",
    conditions=(
        Condition("sarsa", "Sarsa", trial(EnvironmentOnly(), taught_by=ABSENT)),
        Condition("linear", "linear, Eq. 4", trial()),
        Condition("linear-equation-5", "linear, Eq. 5", trial(trust=Equation5())),
        Condition("linear-fixed", "linear, w_h = 1", trial(trust=FixedWeight(1.0))),
        Condition("linear-sparing", "linear, Eq. 4, 2 presses an episode", trial(taught_by=SPARING)),
        Condition("annealed", "annealed", trial(Annealed())),
        Condition("action-biasing", "action biasing", trial(ActionBiasing())),
        Condition("control-sharing", "control sharing", trial(ControlSharing())),
        Condition("q-augmentation", "Q augmentation", trial(QAugmentation())),
        Condition("shaping", "reward shaping, beta = 1", trial(RewardShaping())),
        Condition("shaping-ten", "reward shaping, beta = 10", trial(RewardShaping(beta_0=10.0))),
        Condition("human-only", "the human model alone (TAMER)", trial(HumanOnly())),
    ),
    trial=run_trial,
    quick=quick,
    departures=(
        (
            "the task is Gymnasium's MountainCar-v0 without its limit of 200 steps; an episode is broken off "
            f"after {CAP}"
        ),
        (
            "the participant is simulated: they know that pushing along with the motion leads up, err in one "
            "press of ten, and press with the paper's delay"
        ),
        (
            "every episode is watched, and the human model learns while Sarsa does; Knox & Stone (2010) "
            "taught a human model first and combined it afterwards"
        ),
        "the human model is linear over Sarsa's tiles, learned by gradient descent",
        (
            "R and H are standardised over the actions of each decision in the linear and annealed schemes, "
            "raw in action biasing"
        ),
        "every episode is a policy of its own in Eq. 4 and Eq. 5: the learner changes all the time",
        (
            "performance is minus the number of steps: where it is negative, Eq. 4 weighs an episode by how "
            "far it lies above the worst one compared, and Eq. 5 weighs its two episodes alike"
        ),
    ),
)


def report(results: Results) -> Page:
    """Return the page."""
    return report_page(results)
