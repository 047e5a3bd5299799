"""A session played in compiled code between the presses is the session played step by step."""

import msgspec
import numpy as np
import pytest

from core.combination.config import (
    Advise,
    AgentConfig,
    Annealed,
    BootstrapConfig,
    Coach,
    ControlSharing,
    EnvironmentOnly,
    Equation4,
    Equation5,
    Exponential,
    HumanOnly,
    Linear,
    RewardShaping,
    Signed,
)
from core.events import EpisodeEnded, EpisodeStarted, KeyPressed
from core.feedback.config import CreditConfig
from core.feedback.delays import GammaDelay, UniformDelay
from core.feedback.keys import PressGate
from core.feedback.source import SimulatedParticipant
from core.feedback.trainers import SimulatedTrainer, TrainerConfig
from core.feedback.viewing import SteadyViewing
from core.learners.cross_entropy import CrossEntropyConfig
from core.learners.policy_gradient_config import PolicyGradientConfig
from core.numerics.clock import NS_PER_MS, ManualClock
from core.numerics.compiled import JIT_DISABLED
from core.session.protocol import Protocol, SessionConfig
from core.session.session import build_session
from core.tetris.config import TetrisConfig
from core.tetris.oracle import TetrisOracle
from studies.experiments.tetris_trial import new_trial, step_ns

EPISODES = 6 if JIT_DISABLED else 25


def protocol(
    agent: AgentConfig | None = None,
    trainer: TrainerConfig | None = None,
    learner: CrossEntropyConfig | PolicyGradientConfig | None = None,
    **domain,
) -> Protocol:
    return Protocol(
        domain=TetrisConfig(placements="all", **domain),
        learner=learner or CrossEntropyConfig(population=10),
        agent=agent or AgentConfig(),
        session=SessionConfig(episodes=EPISODES, unseen_between=0, watched="proposed", watched_steps=150),
        trainer=trainer or TrainerConfig(press_probability=0.05),
    )


def with_trust(trust) -> AgentConfig:
    return AgentConfig(bootstrap=BootstrapConfig(trust=trust))


def step_by_step(settings: Protocol, root_seed: int):
    """Return (lines, pieces, weight) of each episode, the accepted presses of the session, and the last
    digest."""
    clock = ManualClock()
    session = build_session(settings, root_seed)
    participant = SimulatedParticipant(
        session.domain,
        TetrisOracle(settings.domain),
        SimulatedTrainer(settings.trainer, root_seed=root_seed),
        PressGate(settings.keys),
        clock,
        SteadyViewing(
            step_ns=step_ns(settings),
            pause_ns=round(settings.screen.pause_between_episodes_s * 1000) * NS_PER_MS,
        ),
    )
    weights, played, presses, digest = [], [], 0, ""
    for output in session.run(participant, clock):
        if isinstance(output, EpisodeStarted):
            weights.append(output.weight)
        elif isinstance(output, EpisodeEnded):
            played.append((output.performance, output.steps))
        digest = getattr(output, "digest", digest)
        for item in participant.watch(output):
            presses += isinstance(item, KeyPressed) and item.verdict == "accepted"
    return [(*result, weight) for result, weight in zip(played, weights, strict=True)], presses, digest


def in_compiled_code(settings: Protocol, root_seed: int):
    trial = new_trial(settings, root_seed)
    episodes = [trial.play() for _ in range(settings.session.episodes)]
    trial.finish()
    return (
        [(e.performance, e.steps, e.weight) for e in episodes],
        sum(e.presses for e in episodes),
        trial.agent.digest(),
    )


@pytest.mark.parametrize(
    "settings",
    [
        protocol(),
        protocol(with_trust(Signed(minimum_episodes=3))),
        protocol(with_trust(Equation4(match="chance-corrected", chance=0.15))),
        protocol(with_trust(Equation5(cumulative=True))),
        protocol(AgentConfig(scheme=EnvironmentOnly())),
        protocol(AgentConfig(scheme=HumanOnly())),
        protocol(AgentConfig(scheme=Annealed())),
        protocol(AgentConfig(scheme=Exponential())),
        protocol(AgentConfig(scheme=ControlSharing())),
        protocol(AgentConfig(credit=CreditConfig(delay=GammaDelay()))),
        protocol(AgentConfig(credit=CreditConfig(delay=UniformDelay(), merge_within_s=0.5))),
        protocol(AgentConfig(scheme=Linear()), game_over="overflow", features="paper-12"),
        protocol(
            trainer=TrainerConfig(
                press_probability=0.3,
                mean_presses=3.0,
                burst_rate=0.5,
                anticipation_rate=0.3,
                deliberate_rate=0.2,
                fatigue_half_life_episodes=20.0,
                delay=GammaDelay(shape=2.5, scale_s=1.5),
            )
        ),
        protocol(AgentConfig(scheme=Advise())),
        protocol(learner=PolicyGradientConfig(step_size=0.2)),
        protocol(AgentConfig(scheme=Advise()), learner=PolicyGradientConfig(natural=True, step_size=0.02)),
        protocol(AgentConfig(scheme=ControlSharing()), learner=PolicyGradientConfig(update="episode")),
        protocol(AgentConfig(scheme=RewardShaping(beta_0=0.2)), learner=PolicyGradientConfig()),
        protocol(AgentConfig(scheme=HumanOnly()), learner=PolicyGradientConfig()),
    ],
    ids=range(19),
)
def test_trials_equal_sessions_bit_for_bit(settings: Protocol):
    for root_seed in (1,) if JIT_DISABLED else (1, 2):
        assert in_compiled_code(settings, root_seed) == step_by_step(settings, root_seed)


def test_there_is_something_to_compare():
    episodes, presses, _ = in_compiled_code(protocol(), 1)
    assert presses >= EPISODES / 2
    assert any(weight != 0 for _, _, weight in episodes)
    assert np.sum([lines for lines, _, _ in episodes]) > 0


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({"domain": TetrisConfig(placements="reachable")}, "placements"),
        ({"session": SessionConfig(unseen_between=0)}, "watched"),
        ({"session": SessionConfig(watched="proposed")}, "unseen"),
        ({"agent": AgentConfig(credit=CreditConfig(scheme="aggregate"))}, "individual"),
        ({"agent": with_trust(Equation4(measured="window"))}, "window"),
        (
            {"agent": AgentConfig(scheme=Coach()), "learner": PolicyGradientConfig()},
            "presses teach the human model",
        ),
    ],
)
def test_what_would_need_every_step_is_refused(changes: dict, wanted: str):
    with pytest.raises(ValueError, match=wanted):
        new_trial(msgspec.structs.replace(protocol(), **changes), 1)
