"""A simulated participant in the real loop: what reaches the agent, in which order, and again the same."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from core.combination.agent import ArlAgent
from core.combination.config import AgentConfig, Constant
from core.domain import Choices, Transition
from core.events import ActionRecord, EpisodeEnded, Event, FrameShown, KeyPressed, Output, StepTaken
from core.feedback.credit import PreviousStep, UniformDelay
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.samples import CreditConfig
from core.feedback.source import SimulatedParticipant
from core.feedback.trainers import SimulatedTrainer, TrainerConfig
from core.feedback.viewing import SteadyViewing
from core.learners.contract import Candidate
from core.numerics.clock import NS_PER_S, ManualClock
from core.numerics.streams import stream
from core.session.rollout import EpisodePlan, FeedbackIntake, play_episode

N_CARDS, N_FEATURES = 6, 3
TASTE = np.array([1.0, -1.0, 0.5])
STEP_NS = NS_PER_S


@dataclass(frozen=True)
class Deal:
    seed: int
    number: int
    won: float


class PlayedCard(ActionRecord, frozen=True):
    card: int


class Cards:
    """Pick one of six cards, forty times; cards have three features, and the oracle likes some of them."""

    name = "cards"
    feature_names = ("a", "b", "c")
    feedback_feature_names = ("a", "b", "c")

    def initial(self, episode_seed: int) -> Deal:
        return Deal(episode_seed, 0, 0.0)

    def terminal(self, state: Deal) -> bool:
        return state.number == 40

    def choices(self, state: Deal) -> Choices:
        rows = (
            stream(state.seed, "cards", state.number)
            .integers(-3, 4, size=(N_CARDS, N_FEATURES))
            .astype(float)
        )
        return Choices(rows, rows, np.zeros(N_CARDS, dtype=np.bool_))

    def transition(self, state: Deal, action: int) -> Transition[Deal]:
        values = self.choices(state).features @ TASTE
        reward = float(values[action] == values.max())
        return Transition(Deal(state.seed, state.number + 1, state.won + reward), reward, 1)

    def performance(self, state: Deal) -> float:
        return state.won

    def time(self, state: Deal) -> int:
        return 0

    def action_record(self, state: Deal, action: int) -> PlayedCard:
        return PlayedCard(action)

    def recorded_state(self, state: Deal) -> None:
        return None


class Clueless:
    """A learner whose only policy wants the opposite of what the oracle likes."""

    def propose(self) -> Candidate:
        return Candidate(0, -TASTE)

    def report(self, policy_id: int, performance: float) -> None:
        pass

    def state_digest(self) -> bytes:
        return b""


def oracle(state: Deal) -> NDArray[np.float64]:
    values: NDArray[np.float64] = Cards().choices(state).features @ TASTE
    return values


@dataclass
class PlayedSession:
    events: list[Event]
    agent: ArlAgent

    def of(self, kind: type) -> list:  # type: ignore[type-arg]
        return [event for event in self.events if isinstance(event, kind)]


def play_session(
    trainer: TrainerConfig, *, keys: KeyConfig | None = None, episodes: int = 2, seed: int = 1
) -> PlayedSession:
    domain, clock = Cards(), ManualClock(5 * NS_PER_S)
    config = AgentConfig(scheme=Constant(w_h=5.0), credit=CreditConfig(delay=PreviousStep()))
    agent = ArlAgent(Clueless(), config, n_feedback_features=N_FEATURES, root_seed=seed)
    participant = SimulatedParticipant(
        domain,
        oracle,
        SimulatedTrainer(trainer, root_seed=seed),
        PressGate(keys or KeyConfig()),
        clock,
        SteadyViewing(step_ns=STEP_NS, pause_ns=2 * NS_PER_S),
    )
    intake = FeedbackIntake(agent, participant)
    events: list[Event] = []
    for episode in range(episodes):
        policy = agent.begin_episode(exploring=True, watched=True)
        plan = EpisodePlan(100 + episode, policy, first_step=40 * episode, max_steps=1000)
        for output in play_episode(domain, agent, intake, clock, plan):
            events.append(output)
            events.extend(participant.watch(output))
    return PlayedSession(events, agent)


ATTENTIVE = TrainerConfig(press_probability=0.5, max_presses=20, mistake_rate=0.0)
PATIENT_KEYS = KeyConfig(max_presses_per_episode=20)


def test_every_step_is_shown_once_and_then_the_final_picture() -> None:
    session = play_session(ATTENTIVE)
    assert [frame.step for frame in session.of(FrameShown)] == [*range(40), -1, *range(40, 80), -1]
    assert [frame.frame for frame in session.of(FrameShown)] == list(range(82))


def test_inputs_come_in_order_of_time_and_presses_name_the_step_on_screen() -> None:
    session = play_session(ATTENTIVE)
    inputs = [event for event in session.events if isinstance(event, FrameShown | KeyPressed)]
    times = [item.flushed_ns if isinstance(item, FrameShown) else item.time_ns for item in inputs]
    assert times == sorted(times)
    on_screen = -1
    presses = 0
    for event in session.events:
        if isinstance(event, FrameShown):
            on_screen = event.step
        elif isinstance(event, KeyPressed):
            assert event.step == on_screen
            assert event.source == "simulated"
            presses += 1
    assert presses > 20


def test_a_step_is_judged_when_its_outcome_has_been_seen() -> None:
    prompt = TrainerConfig(press_probability=1.0, max_presses=1, delay=UniformDelay(0.5, 0.6))
    session = play_session(prompt, episodes=1)
    [press] = session.of(KeyPressed)
    shown_ns = session.of(FrameShown)[0].flushed_ns
    # One second on screen, then the delay: the press falls on the next step.
    assert 1.5 * NS_PER_S <= press.time_ns - shown_ns <= 1.6 * NS_PER_S
    assert press.step == 1


def test_outputs_count_the_inputs_that_were_taken_in() -> None:
    session = play_session(ATTENTIVE)
    taken = 0
    for event in session.events:
        if isinstance(event, StepTaken | EpisodeEnded):
            # All inputs so far, except those of the step whose time on screen has just ended.
            assert event.inputs <= taken
        if isinstance(event, FrameShown | KeyPressed):
            taken += 1
    assert session.of(EpisodeEnded)[0].inputs == sum(
        isinstance(event, FrameShown | KeyPressed)
        for event in session.events[: session.events.index(session.of(EpisodeEnded)[0])]
    )


def test_a_good_participant_turns_a_clueless_agent_round() -> None:
    performances = [
        ended.performance for ended in play_session(ATTENTIVE, keys=PATIENT_KEYS).of(EpisodeEnded)
    ]
    # By chance 40/6 = 6.7 cards of 40; the learner's own policy gets nearly none.
    alone = [
        ended.performance for ended in play_session(TrainerConfig(press_probability=0.0)).of(EpisodeEnded)
    ]
    assert max(alone) <= 3
    assert performances[1] >= 25


def test_an_adversary_teaches_the_opposite() -> None:
    hostile = TrainerConfig(press_probability=0.5, max_presses=20, mistake_rate=1.0)
    session = play_session(hostile, keys=PATIENT_KEYS)
    assert (session.agent.human.weights @ TASTE) < 0


def test_the_budget_of_the_keys_holds_for_simulated_presses() -> None:
    session = play_session(ATTENTIVE, keys=KeyConfig(max_presses_per_episode=3), episodes=1)
    verdicts = [press.verdict for press in session.of(KeyPressed)]
    assert verdicts.count("accepted") == 3
    assert verdicts.count("no-presses-left") > 0
    assert set(verdicts) <= {"accepted", "no-presses-left", "repeat"}


def test_deliberate_errors_are_recorded_as_asked_for() -> None:
    session = play_session(TrainerConfig(press_probability=0.5, max_presses=20, deliberate_rate=0.3))
    flags = [press.asked_wrong for press in session.of(KeyPressed)]
    assert any(flags)
    assert not all(flags)


def test_the_same_seed_gives_the_same_session_and_another_seed_another() -> None:
    one, again, other = play_session(ATTENTIVE), play_session(ATTENTIVE), play_session(ATTENTIVE, seed=2)
    assert one.events == again.events
    assert one.agent.digest() == again.agent.digest()
    assert one.agent.digest() != other.agent.digest()


class Recorded:
    """Gives the inputs of a recording out at the points where they were taken in."""

    def __init__(self, events: list[Event]) -> None:
        self.inputs = [event for event in events if isinstance(event, FrameShown | KeyPressed)]
        self.given = 0
        self.upto = 0

    def during(self, step: int) -> list[FrameShown | KeyPressed]:
        given = self.inputs[self.given : self.upto]
        self.given = self.upto
        return given


def test_the_presses_alone_teach_the_same_again() -> None:
    """A replay in miniature: times and presses come from the events, not from clock and trainer."""
    session = play_session(ATTENTIVE, episodes=1)
    config = AgentConfig(scheme=Constant(w_h=5.0), credit=CreditConfig(delay=PreviousStep()))
    agent = ArlAgent(Clueless(), config, n_feedback_features=N_FEATURES, root_seed=1)
    source = Recorded(session.events)
    plan = EpisodePlan(100, agent.begin_episode(exploring=True, watched=True), first_step=0, max_steps=1000)
    outputs = [event for event in session.events if not isinstance(event, FrameShown | KeyPressed)]
    clock = ManualClock()
    replayed: list[Output] = []
    run = play_episode(Cards(), agent, FeedbackIntake(agent, source), clock, plan)
    for recorded in outputs:
        clock.advance_to_ns(getattr(recorded, "time_ns", 0))
        source.upto = getattr(recorded, "inputs", source.upto)
        if not hasattr(recorded, "inputs"):  # credit comes from inputs that the next output counts
            source.upto = next(
                (later.inputs for later in outputs[outputs.index(recorded) :] if hasattr(later, "inputs")),
                len(source.inputs),
            )
        replayed.append(next(run))
    assert [r for r in replayed if isinstance(r, StepTaken)] == session.of(StepTaken)


def test_impossible_paces_are_refused() -> None:
    with pytest.raises(ValueError, match="step_ns > 0"):
        SteadyViewing(step_ns=0, pause_ns=0)
