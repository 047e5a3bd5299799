"""Several sources of human feedback: folded into one, each with its own weight."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from core.combination.agent import ArlAgent
from core.combination.config import (
    AgentConfig,
    BootstrapConfig,
    Constant,
    ControlSharing,
    EnvironmentOnly,
    Exponential,
    HumanOnly,
    Signed,
)
from core.combination.tally import EpisodeTally
from core.domain import Choices
from core.events import KeyPressed, UnseenPlayed
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import CurrentStep
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.learners.human_config import SgdModel
from core.session.protocol import SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.combination.test_agent import CountingLearner, EpisodeOutcome
from tests.core.sessions import TALKATIVE, simulated, small_protocol

SETTINGS = {
    "credit": CreditConfig(delay=CurrentStep()),
    "human_model": SgdModel(step_size=0.5, intercept=False),
}


def agent(n_participants: int, **changes) -> ArlAgent:
    return ArlAgent(
        CountingLearner(),
        AgentConfig(**SETTINGS, **changes),
        n_feedback_features=2,
        n_participants=n_participants,
        root_seed=1,
    )


def decision(seed: int, n: int = 5) -> Choices:
    rng = np.random.Generator(np.random.PCG64(seed))
    return Choices(rng.normal(size=(n, 2)), rng.normal(size=(n, 2)), np.zeros(n, dtype=bool))


def press(who: ArlAgent, number: int, psi: tuple[float, float], value: float, participant: int = 0) -> None:
    who.step_shown(number, np.array(psi), 10 * number)
    who.learn_from_press(number, 10 * number + 1, value, participant)
    who.step_hidden(10 * number + 5)


def live(who: ArlAgent, episodes: int, decisions: int = 12):
    """Let the agent decide some episodes; return what it chose, and its weights."""
    chosen = []
    for episode in range(episodes):
        policy = who.begin_episode(exploring=episode % 2 == 0, watched=True)
        tally = EpisodeTally()
        for step in range(decisions):
            chosen.append(who.choose(decision(100 * episode + step), policy, step=step))
            tally.add(chosen[-1])
        press(who, episode, (1.0, -0.5), 1.0 if episode % 3 else -1.0)
        outcome = EpisodeOutcome(float(episode % 4), agreement=tally.agreement, with_each=tally.with_each)
        who.learn_from_domain(policy, outcome)
    return chosen, who.trust_of_sources


@pytest.mark.parametrize(
    "scheme", [None, Exponential(), Constant(), ControlSharing(), HumanOnly(), EnvironmentOnly()], ids=str
)
@pytest.mark.parametrize("trust", [None, Signed(minimum_episodes=2)], ids=str)
def test_a_crowd_of_which_one_speaks_is_that_one(scheme, trust):
    changes = {} if scheme is None else {"scheme": scheme}
    if trust is not None:
        changes["bootstrap"] = BootstrapConfig(trust=trust)
    alone, weights = live(agent(1, **changes), 8)
    together, crowd_weights = live(agent(3, **changes), 8)
    assert together == alone
    assert crowd_weights == pytest.approx([weights[0], 0.0, 0.0])


def test_folding_by_hand():
    """Two sources with v = (1, 0) and (0, 4), weights 0.5 and -0.25, in one decision."""
    who = agent(2)
    crowd = who.human
    press(who, 0, (2.0, 0.0), 1.0, participant=0)  # v = 0.5 * 1 * (2, 0) = (1, 0)
    press(who, 1, (0.0, 2.0), 1.0, participant=1)
    press(who, 2, (0.0, 2.0), 1.0, participant=1)  # (0, 1), error 1 - 2 = -1: (0, 0)
    press(who, 3, (0.0, 8.0), 1.0, participant=1)  # (0, 4)
    assert [learner.weights.tolist() for learner in crowd.learners] == [[1.0, 0.0], [0.0, 4.0]]
    psi = np.array([[1.0, 0.0], [-1.0, 0.0], [1.0, 3.0], [-1.0, 3.0]])
    who.window.remember(Choices(np.zeros((4, 2)), psi, np.zeros(4, dtype=bool)))
    # sd of psi_0 is 1, so sd_0 = 1; sd of psi_1 is 1.5, so sd_1 = 6. v = 0.5 (1, 0) - 0.25 (0, 4) / 6 = (1/2,
    # -1/6)
    weight = crowd.fold([0.5, -0.25], who.window)
    assert crowd.weights == pytest.approx([1 / 2, -1 / 6])
    # The two features are uncorrelated here: sqrt(0.5^2 + 0.25^2)
    assert weight == pytest.approx(np.hypot(0.5, 0.25))


def test_who_presses_more_has_no_more_say():
    """Ten times the labels give ten times the v, and the same fold."""
    folds = []
    for size in (1.0, 10.0):
        who = agent(2)
        press(who, 0, (2.0, 0.0), 1.0, participant=0)
        press(who, 1, (0.0, 2.0), size, participant=1)
        for k in range(5):
            who.window.remember(decision(k))
        who.human.fold([1.0, 1.0], who.window)
        folds.append(who.human.weights)
    np.testing.assert_allclose(folds[0], folds[1], rtol=1e-12)


def test_a_press_is_taken_back_from_the_one_who_made_it():
    who = agent(2)
    press(who, 0, (2.0, 0.0), 1.0, participant=0)
    press(who, 1, (0.0, 2.0), 1.0, participant=1)
    who.retract(1)
    assert [learner.knows_something for learner in who.human.learners] == [True, False]


def test_a_press_of_an_unknown_participant_is_refused():
    with pytest.raises(ValueError, match="press 0 is by participant 2, but this agent listens to 2"):
        press(agent(2), 0, (1.0, 0.0), 1.0, participant=2)
    with pytest.raises(ValueError, match="press 0 is by participant 1, but this agent listens to 1"):
        press(agent(1), 0, (1.0, 0.0), 1.0, participant=1)
    with pytest.raises(ValueError, match="at least one participant"):
        agent(0)


# --- sessions -----------------------------------------------------------------------------------------------

GOOD = msgspec.structs.replace(TALKATIVE, press_probability=0.15, max_presses=5, mistake_rate=0.1)
ADVERSARY = msgspec.structs.replace(GOOD, mistake_rate=1.0)


def session_of(*others: TrainerConfig):
    return small_protocol(
        trainer=GOOD,
        others=others,
        session=SessionConfig(episodes=3, unseen_between=20, watched_steps=20, unseen_steps=300),
    )


def test_a_session_of_three_people_is_replayed_bit_for_bit_and_says_who_pressed(tmp_path: Path):
    recording = simulated(tmp_path, session_of(GOOD, ADVERSARY))
    presses = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert {press.person for press in presses} == {0, 1, 2}
    assert sorted(press.press for press in presses) == list(range(len(presses)))
    for person in range(3):
        mine = [press for press in presses if press.person == person and press.verdict == "accepted"]
        assert 0 < len(mine) <= 3 * 20
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    assert replay_exactly(recording, session).difference is None
    assert set(recording.outputs[-1].weights) >= {"human", "human-1", "human-2", "trust"}
    assert len(recording.outputs[-1].weights["trust"]) == 3


def test_a_session_of_one_records_no_person(tmp_path: Path):
    recording = simulated(tmp_path, session_of())
    assert b'"person"' not in recording.path.read_bytes()


def final_weights_and_unseen_lines(folder: Path, *others: TrainerConfig, seeds: range):
    """Weights at the end (signed agreement), and mean lines of the last unseen episodes, of each session."""
    weights, lines = [], []
    folder.mkdir()
    for seed in seeds:
        protocol = small_protocol(
            trainer=GOOD,
            others=others,
            learner=CrossEntropyConfig(population=30, elite_fraction=0.2),
            agent=AgentConfig(bootstrap=BootstrapConfig(trust=Signed(minimum_episodes=10))),
            session=SessionConfig(episodes=12, unseen_between=60, watched_steps=60, unseen_steps=500),
        )
        recording = simulated(folder, protocol, root_seed=seed)
        weights.append(recording.outputs[-1].weights["trust"])
        unseen = [event for event in recording.outputs if isinstance(event, UnseenPlayed)]
        lines.append(np.mean([line for event in unseen[-4:] for line in event.performances]))
    return np.array(weights), np.array(lines)


@pytest.mark.slow
@pytest.mark.statistical
@pytest.mark.jit
def test_an_adversary_among_two_good_people_is_not_trusted_and_does_no_harm(tmp_path: Path):
    """Sixteen seeds, 12 watched and 660 unseen episodes: the same seeds with and without the adversary."""
    seeds = range(900, 916)
    three, with_adversary = final_weights_and_unseen_lines(tmp_path / "3", GOOD, ADVERSARY, seeds=seeds)
    _, without = final_weights_and_unseen_lines(tmp_path / "2", GOOD, seeds=seeds)
    assert three[:, :2].mean() > 0.05
    assert three[:, 2].mean() < 0
    standard_error = without.std(ddof=1) / np.sqrt(len(without))
    assert with_adversary.mean() > without.mean() - 2 * standard_error
