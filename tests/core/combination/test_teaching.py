"""Schemes that act on what the environment's learner learns: reward shaping, Q augmentation, COACH. By
hand."""

import numpy as np
import pytest

from core.combination.agent import ArlAgent
from core.combination.climbing import Coached
from core.combination.config import (
    ENVIRONMENT_WEIGHTS,
    SCHEMES,
    AgentConfig,
    Coach,
    EnvironmentOnly,
    Linear,
    QAugmentation,
    RewardShaping,
)
from core.combination.environment import environment_sides
from core.combination.sides import EpisodeEnd, EpisodeStart, HumanPreference
from core.combination.window import Values
from core.domain import Choices
from core.events import CreditGiven
from core.feedback.config import CreditConfig
from core.feedback.delays import CurrentStep
from core.learners.contract import Candidate
from core.learners.human_config import SgdModel
from core.learners.policy_gradient import PolicyGradientConfig, PolicyGradientLearner
from core.learners.sarsa import SarsaConfig
from core.learners.sarsa_learner import SarsaLearner
from core.numerics.streams import stream
from core.numerics.tile_coding import Range, tile_coder

CHAIN = tile_coder((Range(0.0, 2.5, 1.0),), n_tilings=1)
VALUES: Values = lambda rows, theta: np.asarray(rows @ theta)


def at(state: int, time: int, psi: tuple[float, float] = (1.0, 0.0)) -> Choices:
    """A decision between two actions in a state of the chain; psi of each action, one feature."""
    seen = np.array([float(state)])
    return Choices(
        np.empty((2, 0)), np.array(psi)[:, None], np.zeros(2, dtype=bool), time=time, observation=seen
    )


def sarsa() -> SarsaLearner:
    learner = SarsaLearner(
        SarsaConfig(step_size=0.5, exploration=0.0), CHAIN, n_learners=1, n_actions=2, reward_is_time=True
    )
    learner.begin_episode(rng=stream(1, "policy"))
    return learner


def test_shaping_adds_to_the_reward_of_its_own_step():
    learner = sarsa()
    learner.took(at(0, 0), 0, 0.0, shaping=2.0)
    learner.took(at(1, 3), 0, 0.0, shaping=-1.0)  # Q0 += 0.5 * (3 + 2 + 0 - 0)
    assert learner.sarsa.weights[0, 0].tolist() == [2.5, 0.0, 0.0]
    learner.end_episode(5, terminated=True)  # Q1 += 0.5 * (2 - 1 - 0)
    assert learner.sarsa.weights[0, 0].tolist() == [2.5, 0.5, 0.0]


def test_augmentation_learns_the_rest_of_the_value():
    learner = sarsa()
    learner.took(at(0, 0), 0, 0.0, augmentation=4.0)
    learner.took(at(1, 3), 0, 0.0, augmentation=1.0)  # Q0 += 0.5 * (3 + (0 + 1) - (0 + 4)) = 0
    learner.end_episode(5, terminated=True)  # Q1 += 0.5 * (2 + 0 - (0 + 1))
    assert learner.sarsa.weights[0, 0].tolist() == [0.0, 0.5, 0.0]


def test_augmented_values_converge_to_what_plain_ones_converge_to():
    """Q + beta H of a fixed H ends where Q alone does: at the time still to come."""
    learner = sarsa()
    for _ in range(60):
        learner.begin_episode(rng=stream(1, "policy"))
        learner.took(at(0, 0), 0, 0.0, augmentation=4.0)
        learner.took(at(1, 3), 0, 0.0, augmentation=-2.0)
        learner.end_episode(5, terminated=True)
    np.testing.assert_allclose(learner.sarsa.weights[0, 0, :2] + [4.0, -2.0], [5.0, 2.0], atol=1e-6)


def test_an_episode_that_was_broken_off_leaves_no_shaping_behind():
    learner = sarsa()
    learner.took(at(0, 0), 0, 0.0, shaping=9.0)
    learner.end_episode(2, terminated=False)
    assert not learner.sarsa.extra.any()
    assert not learner.sarsa.weights.any()


def taught_agent(scheme) -> ArlAgent:
    """An agent over Sarsa whose human likes the feature: one press, credited to the step on screen, H = psi /
    2."""
    agent = ArlAgent(
        sarsa(),
        AgentConfig(
            scheme=scheme,
            credit=CreditConfig(delay=CurrentStep()),
            human_model=SgdModel(step_size=0.5, intercept=False),
        ),
        n_feedback_features=1,
        root_seed=1,
    )
    agent.step_shown(0, np.array([1.0]), 0)
    agent.learn_from_press(0, 5, 1.0)
    return agent


@pytest.mark.parametrize(
    ("scheme", "expected"),
    [
        # H = 0.5 for the action taken in state 0, 1 in state 1 (psi 2). Shaping by 2 H: 0.5 * (3 + 1), then
        # 0.5 * (2 + 2).
        (RewardShaping(beta_0=2.0), [2.0, 2.0]),
        # Augmentation by 2 H: 0.5 * (3 + 2 - 1), then 0.5 * (2 - 2).
        (QAugmentation(beta=2.0), [2.0, 0.0]),
    ],
)
def test_an_agent_teaches_its_learner_by_its_human_model(scheme, expected):
    agent = taught_agent(scheme)
    policy = agent.begin_episode(exploring=True, watched=True)
    for step, choices in enumerate((at(0, 0, (1.0, 0.0)), at(1, 3, (2.0, 0.0)))):
        agent.choose(choices, policy, step=step)
        agent.learn_from_step(choices, 0, 0.0)
    agent.learner.end_episode(5, terminated=True)
    assert agent.learner.sarsa.weights[0, 0, :2].tolist() == expected


def test_q_augmentation_adds_h_in_the_choice_too_and_shaping_does_not():
    choices = at(0, 0, (0.0, 1.0))
    for scheme, expected in ((QAugmentation(beta=2.0), 1), (RewardShaping(beta_0=2.0), 0)):
        agent = taught_agent(scheme)
        agent.learner.sarsa.weights[0, 0, 0] = 0.5
        policy = agent.begin_episode(exploring=True, watched=True)
        assert agent.choose(choices, policy, step=0).action == expected


# --- COACH --------------------------------------------------------------------------------------------------


def pair() -> Choices:
    """Two actions with features (1, 0) and (0, 1)."""
    return Choices(np.eye(2), np.zeros((2, 1)), np.zeros(2, dtype=bool))


def begin(side: Coached, episode: int) -> None:
    side.start_policy(EpisodeStart(episode, draw=None, rng=stream(1, "none")))


def coached(**settings) -> tuple[Coached, PolicyGradientLearner]:
    learner = PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0, 1.0])
    side, taught_by_presses = environment_sides(learner, VALUES, Coach(**settings))
    assert isinstance(side, Coached)
    assert taught_by_presses is side
    begin(side, 0)
    return side, learner


def decide(side: Coached, action: int, *, step: int = 0, reward: float = 0.0) -> None:
    choices = pair()
    values = side.values(choices, np.zeros(2))
    side.act(values, choices, -1, HumanPreference(np.zeros(2), ENVIRONMENT_WEIGHTS, 1, step, False))
    side.took(choices, action, reward, shaping=0.0, augmentation=0.0, watched_step=step)


def credit(*shares: tuple[int, float]) -> CreditGiven:
    return CreditGiven(
        press=0,
        steps=[step for step, _ in shares],
        shares=[share for _, share in shares],
        before_first=0.0,
        in_gaps=0.0,
    )


def test_a_press_moves_the_policy_toward_what_was_done():
    side, learner = coached(step_size=0.1, trace_decay=0.5)
    decide(side, 0)  # score (1, 0) - (0.5, 0.5) = (0.5, -0.5)
    decide(side, 1, step=1)  # trace 0.5 (0.5, -0.5) + (-0.5, 0.5) = (-0.25, 0.25)
    side.learn_from_credit(credit((0, 0.8), (1, 0.2)), 1.0)
    # 0.1 * (0.8 * (0.5, -0.5) + 0.2 * (-0.25, 0.25)) = (0.035, -0.035)
    np.testing.assert_allclose(learner.gradient.weights, [0.035, -0.035], rtol=1e-12)
    side.learn_from_credit(credit((0, 1.0)), -1.0)  # -0.1 * (0.5, -0.5)
    np.testing.assert_allclose(learner.gradient.weights, [-0.015, 0.015], rtol=1e-12)


def test_steps_have_the_numbers_of_the_session_and_traces_end_with_the_episode():
    side, learner = coached(step_size=0.1, trace_decay=0.5)
    decide(side, 0)
    side.end_episode(EpisodeEnd(0, proposed=True, performance=1.0, terminated=True, time=1))
    begin(side, 1)
    # A trace of its own: (-0.5, 0.5). Steps 1 to 6 were those of a policy that did not learn.
    decide(side, 1, step=7)
    side.learn_from_credit(credit((1, 1.0)), 1.0)
    assert not learner.gradient.weights.any()
    side.learn_from_credit(credit((7, 1.0)), 1.0)
    np.testing.assert_allclose(learner.gradient.weights, [-0.05, 0.05], rtol=1e-12)


def test_a_step_that_nobody_watches_cannot_be_praised():
    side, learner = coached()
    decide(side, 0, step=-1)
    side.learn_from_credit(credit((-1, 1.0)), 1.0)
    side.learn_from_credit(credit((0, 1.0)), 1.0)
    assert not learner.gradient.weights.any()


def test_a_press_on_a_step_nobody_remembers_changes_nothing():
    side, learner = coached()
    decide(side, 0)
    side.learn_from_credit(credit((7, 1.0)), 1.0)
    assert not learner.gradient.weights.any()


@pytest.mark.parametrize(("too", "learns"), [(True, True), (False, False)])
def test_the_environment_teaches_only_where_that_is_asked_for(too, learns):
    side, learner = coached(environment_too=too)
    decide(side, 0, reward=3.0)
    assert bool(learner.gradient.weights.any()) is learns


class Searcher:
    def propose(self) -> Candidate:
        return Candidate(0, np.zeros(2))

    def report(self, policy_id: int, performance: float) -> None:
        raise AssertionError("not asked")

    def state_digest(self) -> bytes:
        return b""


@pytest.mark.parametrize(
    ("learner", "scheme", "reason"),
    [
        (
            Searcher,
            RewardShaping(),
            "reward-shaping needs a learner that learns at every step",
        ),
        (Searcher, Coach(), "coach needs a learner with a softmax policy: policy-gradient; got Searcher"),
        (Searcher, QAugmentation(), "q-augmentation needs a learner of action values"),
        (sarsa, Coach(), "coach needs a learner with a softmax policy"),
        (
            lambda: PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0]),
            QAugmentation(),
            "q-augmentation needs a learner of action values",
        ),
    ],
)
def test_a_learner_that_cannot_be_taught_so_is_refused(learner, scheme, reason):
    with pytest.raises(ValueError, match=reason):
        ArlAgent(learner(), AgentConfig(scheme=scheme), n_feedback_features=1, root_seed=1)


@pytest.mark.parametrize("scheme", [Linear(), RewardShaping(), EnvironmentOnly()], ids=str)
def test_presses_reach_no_learner_that_they_do_not_teach_directly(scheme):
    learners = [sarsa(), PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0])]
    if scheme.acts_on == "choice":
        learners.append(Searcher())
    for learner in learners:
        assert environment_sides(learner, VALUES, scheme).taught_by_presses is None


@pytest.mark.parametrize("kind", SCHEMES.values())
def test_every_scheme_is_either_served_or_refused_by_every_kind_of_learner(kind):
    """What a scheme acts on is something that a message can name, and that some learner offers."""
    scheme, refusals = kind(), []
    for learner in (Searcher(), sarsa(), PolicyGradientLearner(PolicyGradientConfig(), scales=[1.0])):
        try:
            environment_sides(learner, VALUES, scheme)
        except ValueError as error:
            refusals.append(str(error))
    tag = kind.__struct_config__.tag
    assert all(refusal.startswith(f"scheme {tag} needs a learner") for refusal in refusals)
    assert len(refusals) == {"choice": 0, "reward": 1, "values": 2, "policy": 2}[scheme.acts_on]
