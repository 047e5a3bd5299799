"""The agent: absence of feedback, learning from presses, exploring, and the fingerprint."""

from dataclasses import dataclass
from typing import Literal

import msgspec
import numpy as np
import pytest

from core.combination.agent import ArlAgent, EpisodePolicy
from core.combination.agreement import Agreement
from core.combination.config import (
    ENVIRONMENT_WEIGHTS,
    LINEAR,
    AgentConfig,
    BootstrapConfig,
    Constant,
    ControlSharing,
    EpisodeWeights,
    Equation4,
    HumanOnly,
    Linear,
    Scheme,
    Signed,
    Tried,
    TrustRule,
)
from core.combination.preference import takes_control
from core.combination.tally import EpisodeTally
from core.combination.window import exact_values
from core.domain import Choices
from core.feedback.credit import CurrentStep, PreviousStep
from core.feedback.samples import CreditConfig
from core.learners.contract import Candidate
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream


class CountingLearner:
    """Proposes theta = (k, 1) as policy k and remembers what it was told."""

    def __init__(self) -> None:
        self.reported: list[tuple[int, float]] = []

    def propose(self) -> Candidate:
        policy_id = len(self.reported)
        return Candidate(policy_id, np.array([float(policy_id), 1.0]))

    def report(self, policy_id: int, performance: float) -> None:
        self.reported.append((policy_id, performance))

    def state_digest(self) -> bytes:
        return repr(self.reported).encode()


@dataclass(frozen=True)
class EpisodeOutcome:
    performance: float
    ended: Literal["termination", "truncation"] = "termination"
    time: int = 0
    agreement: Agreement | None = None
    with_each: tuple[Agreement | None, ...] = ()


def agent(
    scheme: Scheme | None = None,
    *,
    learner: CountingLearner | None = None,
    root_seed: int = 1,
    bootstrap: BootstrapConfig | None = None,
    credit: CreditConfig | None = None,
    n_participants: int = 1,
) -> ArlAgent:
    config = AgentConfig(
        scheme=scheme or Linear(),
        bootstrap=bootstrap or BootstrapConfig(),
        credit=credit or CreditConfig(delay=CurrentStep()),
    )
    return ArlAgent(
        learner or CountingLearner(),
        config,
        n_feedback_features=2,
        root_seed=root_seed,
        n_participants=n_participants,
    )


def choices(*rows: tuple[float, float], feedback: tuple[tuple[float, float], ...] | None = None) -> Choices:
    features = np.array(rows)
    return Choices(features, np.array(feedback or rows), np.zeros(len(rows), dtype=np.bool_))


def teach(pupil: ArlAgent, *, first_press: int = 0) -> None:
    """Show two steps and praise the first feature, blame the second."""
    for step, (features, value) in enumerate([((1.0, 0.0), 1.0), ((0.0, 1.0), -1.0)], start=2 * first_press):
        now_ns = (step + 1) * NS_PER_S
        pupil.step_shown(step, np.array(features), now_ns)
        pupil.learn_from_press(step, now_ns + NS_PER_S // 2, value)
        pupil.step_hidden(now_ns + 3 * NS_PER_S // 4)


def play(pupil: ArlAgent, outcome: EpisodeOutcome, *, exploring: bool = True) -> EpisodePolicy:
    policy = pupil.begin_episode(exploring=exploring, watched=True)
    pupil.learn_from_domain(policy, outcome)
    return policy


def test_the_agent_initially_assumes_the_absence_of_a_human() -> None:
    for scheme in (Linear(), Constant(), ControlSharing()):
        pupil = agent(scheme)
        policy = pupil.begin_episode(exploring=True, watched=True)
        assert policy.episode_weights == ENVIRONMENT_WEIGHTS
        assert not policy.human_known
        decision = pupil.choose(choices((1, 2), (3, 1), (0, 4)), policy, step=0)
        # the values are the second feature: theta is 0, 1
        assert (decision.action, decision.environment_action) == (2, 2)
        assert (decision.human_action, decision.human_worst_action) == (-1, -1)
        pupil.learn_from_domain(policy, EpisodeOutcome(7.0))
        assert pupil.trust == 0.0


def test_presses_teach_preferences_and_the_constant_scheme_follows_them() -> None:
    pupil = agent(Constant(w_h=9.0))
    teach(pupil)
    assert pupil.human.weights[0] > 0 > pupil.human.weights[1]
    policy = pupil.begin_episode(exploring=True, watched=True)
    assert policy.episode_weights == EpisodeWeights(LINEAR, 1.0, 9.0)
    decision = pupil.choose(choices((1, 2), (3, 1), (0, 4)), policy, step=0)
    assert (decision.action, decision.environment_action) == (1, 2)
    assert (decision.human_action, decision.human_worst_action) == (1, 2)


def test_a_press_counts_from_the_next_decision_on() -> None:
    pupil = agent(Constant(w_h=9.0))
    teach(pupil)
    policy = pupil.begin_episode(exploring=True, watched=True)
    decision = choices((1, 2), (3, 1), (0, 4))
    assert pupil.choose(decision, policy, step=0).human_action == 1
    for press in (0, 1):
        pupil.retract(press)
    assert pupil.choose(decision, policy, step=1).human_action == -1
    assert pupil.choose(decision, policy, step=2).action == 2


def test_the_human_alone_decides_where_that_is_asked_for() -> None:
    pupil = agent(HumanOnly())
    assert pupil.begin_episode(exploring=True, watched=True).episode_weights == EpisodeWeights(
        LINEAR, 0.0, 1.0
    )
    teach(pupil)
    policy = pupil.begin_episode(exploring=True, watched=True)
    assert pupil.choose(choices((1, 2), (0, 9), (5, 5), (9, 0)), policy, step=0).action == 3


def test_trust_follows_the_agreement_of_an_episode() -> None:
    pupil = agent()
    teach(pupil)
    play(pupil, EpisodeOutcome(5.0, agreement=Agreement(20, 8, 1)))
    assert pupil.trust == 0.4
    assert pupil.begin_episode(exploring=True, watched=True).episode_weights == EpisodeWeights(
        LINEAR, 1.0, 0.4
    )


def test_agreement_is_not_counted_before_there_is_a_human_policy() -> None:
    pupil = agent()
    play(pupil, EpisodeOutcome(5.0))
    teach(pupil)
    assert pupil.trust == 0.0
    play(pupil, EpisodeOutcome(5.0, agreement=Agreement(20, 4, 0)))
    assert pupil.trust == 0.2
    # The first press came in the middle of a watched episode: two decisions were compared, one agreed.
    other = agent()
    policy, tally = other.begin_episode(exploring=True, watched=True), EpisodeTally()
    tally.add(other.choose(choices((1, 2), (3, 1)), policy, step=0))
    teach(other)
    for step, rows in enumerate(
        [
            ((1, 2), (3, 1)),  # environment 0, human 1, and 0 their worst
            ((2, 2), (0, 1), (1, 1)),  # both 0
            ((0, 3), (3, 1), (0, 4)),  # environment 2, human 1, and 2 their worst
        ],
        start=1,
    ):
        tally.add(other.choose(choices(*rows), policy, step=step))
    assert tally.agreement == Agreement(3, 1, 2)
    assert tally.with_each == (Agreement(3, 1, 2),)
    other.learn_from_domain(policy, EpisodeOutcome(5.0, agreement=tally.agreement, with_each=tally.with_each))
    assert other.bootstrap.ranked[0].agreement == Agreement(3, 1, 2)
    assert other.trust == 1 / 3


def test_exploring_episodes_play_the_learners_proposals_and_report_them() -> None:
    learner = CountingLearner()
    pupil = agent(learner=learner)
    for episode, performance in enumerate([3.0, 8.0, 5.0]):
        assert play(pupil, EpisodeOutcome(performance)).policy_id == episode
    assert learner.reported == [(0, 3.0), (1, 8.0), (2, 5.0)]


def test_shown_episodes_play_a_top_policy_and_do_not_tell_the_learner() -> None:
    learner = CountingLearner()
    pupil = agent(learner=learner)
    play(pupil, EpisodeOutcome(0.0))
    play(pupil, EpisodeOutcome(8.0))
    policy = play(pupil, EpisodeOutcome(2.0, ended="truncation"), exploring=False)
    assert (policy.policy_id, policy.exploring) == (1, False)
    assert policy.theta.tolist() == [1.0, 1.0]
    assert len(learner.reported) == 2
    # 8 lines in its own episode, 2 more without dying
    assert pupil.bootstrap.ranked[0].performance == 10.0


def test_without_any_ranked_policy_a_shown_episode_explores() -> None:
    learner = CountingLearner()
    policy = play(agent(learner=learner), EpisodeOutcome(2.0), exploring=False)
    assert policy.exploring
    assert learner.reported == [(0, 2.0)]


def test_the_choice_of_a_policy_follows_from_seed_and_episode_alone() -> None:
    def drawn(root_seed: int, looked_at: bool) -> list[int]:
        pupil = agent(root_seed=root_seed)
        for _ in range(6):
            play(pupil, EpisodeOutcome(10.0))
        if looked_at:
            pupil.next_policy(exploring=False)
        return [pupil.begin_episode(exploring=False, watched=True).policy_id for _ in range(20)]

    assert drawn(1, looked_at=False) == drawn(1, looked_at=True)
    assert drawn(1, looked_at=False) != drawn(2, looked_at=False)


def test_shared_control_hands_the_drawn_decisions_to_the_human_policy() -> None:
    pupil = agent(ControlSharing(beta_0=0.5, decay=1.0))
    teach(pupil)
    policy = pupil.begin_episode(exploring=True, watched=True)
    for step in range(40):
        decision = pupil.choose(choices((1, 2), (3, 1)), policy, step=step)
        expected = 1 if takes_control(policy.handover_seed, step, 0.5) else 0
        assert (decision.action, decision.environment_action, decision.human_action) == (expected, 0, 1)
    assert 0 <= policy.handover_seed < 2**62


def test_a_retracted_press_leaves_no_trace_in_the_agent() -> None:
    def taught(*, retracted: bool) -> ArlAgent:
        pupil = agent()
        teach(pupil)
        if retracted:
            pupil.step_shown(7, np.array([2.0, 2.0]), 20 * NS_PER_S)
            pupil.learn_from_press(7, 21 * NS_PER_S, -1.0)
            pupil.retract(7)
        return pupil

    assert taught(retracted=True).digest() == taught(retracted=False).digest()


def test_the_fingerprint_tells_what_was_learned_from_whom() -> None:
    digests = set()
    fresh = agent()
    digests.add(fresh.digest())
    teach(fresh)
    digests.add(fresh.digest())
    play(fresh, EpisodeOutcome(5.0, agreement=Agreement(10, 3, 0)))
    digests.add(fresh.digest())
    other = agent()
    teach(other)
    play(other, EpisodeOutcome(5.0, agreement=Agreement(10, 4, 0)))
    digests.add(other.digest())
    assert len(digests) == 4
    assert all(len(digest) == 64 for digest in digests)


@pytest.mark.parametrize("n_participants", [1, 2])
@pytest.mark.parametrize(
    ("trust", "goes_by_it"),
    [(Tried(), True), (Signed(consistent_above=2.0), True), (Signed(), False), (Equation4(), False)],
    ids=str,
)
def test_the_fingerprint_knows_how_well_presses_were_foreseen_where_trust_goes_by_it(
    trust: TrustRule, goes_by_it: bool, n_participants: int
) -> None:
    def taught(*presses: tuple[tuple[float, float], float]) -> ArlAgent:
        pupil = agent(bootstrap=BootstrapConfig(trust=trust), n_participants=n_participants)
        for step, (features, value) in enumerate(presses):
            now_ns = (step + 1) * NS_PER_S
            pupil.step_shown(step, np.array(features), now_ns)
            pupil.learn_from_press(step, now_ns + NS_PER_S // 2, value)
            pupil.step_hidden(now_ns + 3 * NS_PER_S // 4)
        return pupil

    # In either order the model is the same, but what it had foreseen of the second press is not.
    praise, blame = ((1.0, 0.0), 1.0), ((0.0, 1.0), -1.0)
    one, other = taught(praise, blame), taught(blame, praise)
    assert one.human.state_bytes() == other.human.state_bytes()
    assert (one.digest() != other.digest()) is goes_by_it


def test_credit_is_reported_with_what_fell_outside() -> None:
    pupil = agent(credit=CreditConfig(delay=PreviousStep()))
    pupil.step_shown(4, np.array([1.0, 0.0]), 0)
    lost = pupil.learn_from_press(0, NS_PER_S, 1.0)
    assert (lost.steps, lost.before_first) == ([], 1.0)
    pupil.step_shown(5, np.array([0.0, 1.0]), 2 * NS_PER_S)
    given = pupil.learn_from_press(1, 3 * NS_PER_S, 1.0)
    assert (given.press, given.steps, given.shares, given.in_gaps) == (1, [4], [1.0], 0.0)


def test_all_weights_are_exported_by_name() -> None:
    pupil = agent()
    teach(pupil)
    play(pupil, EpisodeOutcome(5.0, agreement=Agreement(10, 5, 0)))
    play(pupil, EpisodeOutcome(9.0, agreement=Agreement(10, 5, 0)))
    exported = pupil.export()
    assert exported["policy-0"] == [1.0, 1.0]
    assert exported["policy-1"] == [0.0, 1.0]
    assert exported["human"] == pupil.human.weights.tolist()
    assert exported["trust"] == [0.5]


def test_an_adversary_becomes_a_teacher_under_the_signed_rule() -> None:
    pupil = agent(bootstrap=BootstrapConfig(trust=Signed(minimum_episodes=2)))
    teach(pupil)
    for _ in range(3):
        play(pupil, EpisodeOutcome(5.0, agreement=Agreement(10, 0, 8)))
    assert pupil.trust == pytest.approx(-1.6)
    policy = pupil.begin_episode(exploring=True, watched=True)
    # The environment is indifferent between the first two, the human model likes the first one: not that one.
    decision = pupil.choose(choices((1, 0), (1, 0), feedback=((5, 0), (0, 5))), policy, step=0)
    assert (decision.human_action, decision.action) == (0, 1)


def test_exact_values_do_not_depend_on_the_order_of_features() -> None:
    rng = stream(4, "rows")
    rows, weights = rng.integers(-20, 21, size=(30, 21)).astype(float), rng.normal(size=21)
    order = rng.permutation(21)
    assert (
        exact_values(rows, weights).tobytes()
        == exact_values(np.ascontiguousarray(rows[:, order]), weights[order]).tobytes()
    )


def test_the_configuration_survives_a_recordings_header() -> None:
    config = AgentConfig(scheme=Constant(), bootstrap=BootstrapConfig(trust=Signed()))
    assert msgspec.json.decode(msgspec.json.encode(config), type=AgentConfig) == config
