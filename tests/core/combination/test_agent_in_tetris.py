"""The agent's own decisions and a compiled game's are the same, whatever the scheme."""

import numpy as np
import pytest

from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.config import (
    AgentConfig,
    BootstrapConfig,
    Constant,
    ControlSharing,
    Exponential,
    FixedWeight,
    HumanOnly,
    Linear,
    Scheme,
)
from core.feedback.credit import CurrentStep
from core.feedback.samples import CreditConfig
from core.learners.cross_entropy import CrossEntropyConfig, CrossEntropyLearner
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream
from core.tetris.afterstate import Tetris
from core.tetris.combined import CombinedGame
from core.tetris.config import TetrisConfig

RULES = TetrisConfig()


def taught(scheme: Scheme) -> ArlAgent:
    """An agent that was told of twelve made-up steps that holes and height are bad."""
    agent = ArlAgent(
        CrossEntropyLearner(CrossEntropyConfig(), n_weights=21, root_seed=5),
        AgentConfig(
            scheme=scheme,
            credit=CreditConfig(delay=CurrentStep()),
            bootstrap=BootstrapConfig(trust=FixedWeight(0.8)),
        ),
        n_feedback_features=21,
        root_seed=5,
    )
    rng = stream(3, "made up")
    for step in range(12):
        features = rng.integers(-3, 4, size=21).astype(np.float64)
        agent.step_shown(step, features, step * NS_PER_S)
        agent.learn_from_press(
            step, step * NS_PER_S + NS_PER_S // 2, -1.0 if features[19:].sum() > 0 else 1.0
        )
    return agent


def play(agent: ArlAgent, policy: EpisodePolicy, seed: int, most_steps: int) -> tuple[float, int, int, int]:
    domain = Tetris(RULES)
    state = domain.initial(seed)
    step = agreed = agreed_worst = 0
    while not domain.terminal(state) and step < most_steps:
        decision = agent.choose(domain.choices(state), policy, step=step)
        agreed += decision.environment_action == decision.human_action
        agreed_worst += decision.environment_action == decision.human_worst_action
        state = domain.transition(state, decision.action).next_state
        step += 1
    return domain.performance(state), step, agreed, agreed_worst


@pytest.mark.parametrize(
    "scheme",
    [
        Linear(),
        Linear(scale="raw"),
        Exponential(),
        Constant(w_h=0.7),
        Constant(w_h=-0.5),
        ControlSharing(beta_0=0.4, decay=1.0),
        HumanOnly(),
    ],
)
def test_watched_and_unseen_episodes_are_decided_alike(scheme: Scheme) -> None:
    agent = taught(scheme)
    for episode in range(3):
        policy = agent.begin_episode(exploring=True, watched=False)
        seed = 1000 + episode
        unseen = CombinedGame(
            policy.theta,
            policy.human_weights,
            seed,
            RULES,
            policy.episode_weights,
            handover_seed=policy.handover_seed,
        )
        unseen.advance(60)
        assert play(agent, policy, seed, 60) == (unseen.lines, *unseen.tally.tolist())
