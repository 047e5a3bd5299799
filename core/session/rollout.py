"""The one loop in which an agent meets a domain: live, simulated and replayed sessions all run it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from core.combination.asking import Question
from core.combination.sides import EpisodePolicy
from core.combination.tally import AGREED, AGREED_WORST, EpisodeTally
from core.domain import Choices, Domain, Features
from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    PressRetracted,
    QuestionAnswered,
    QuestionPosed,
    ScreenCleared,
    StepTaken,
    StopAsked,
    TimeGap,
)
from core.numerics.clock import Clock
from core.session.contracts import Agent, Decision, FeedbackSource, Listener, Played

__all__ = [
    "Agent",
    "Decision",
    "EpisodePlan",
    "FeedbackIntake",
    "FeedbackSource",
    "Listener",
    "Played",
    "play_episode",
    "play_unseen",
]


class FeedbackIntake:
    """Brings the inputs to the listener that learns from them: which step was on screen when, and how the
    participant judged it.

    Keeps the feedback features of watched steps from when they are decided until their frame has been shown.
    """

    def __init__(self, listener: Listener, feedback: FeedbackSource) -> None:
        self.inputs = 0
        """How many inputs have been taken in."""
        self.stop_asked: StopAsked | None = None
        self._listener = listener
        self._feedback = feedback
        self._features: dict[int, Features] = {}
        self._on_screen = -1
        self._posed = 0
        self._question: Question | None = None

    def pose(self, question: Question | None) -> int:
        """Announce a question whose answer may come; return its number in the session.

        None is one of which a recording does not tell what it was about: nothing is learned from its answer.
        """
        self._question = question
        self._posed += 1
        return self._posed - 1

    def expect(self, step: int, features: Features) -> None:
        """Announce a watched step whose frames may come; earlier ones than the last two are forgotten."""
        self._features[step] = features
        for old in [known for known in self._features if known < step - 1]:
            del self._features[old]

    def attend(self, step: int) -> Iterator[CreditGiven]:
        """Take in all that has arrived; yield how each press was credited."""
        for item in self._feedback.during(step):
            self.inputs += 1
            yield from self._take(item)

    def _take(self, item: Input) -> Iterator[CreditGiven]:
        match item:
            case FrameShown(step=step, flushed_ns=time_ns):
                self._screen_shows(step, time_ns)
            case ScreenCleared(time_ns=time_ns, reason=reason):
                self._screen_shows(-1, time_ns)
                if reason == "question":  # a press after it is no longer about what was on screen before
                    self._listener.interrupted(time_ns)
            case QuestionAnswered(question=number, chosen=chosen, person=person):
                self._take_answer(number, chosen, person)
            case TimeGap(last_ns=last_ns):
                self._listener.interrupted(last_ns)
                self._on_screen = -1
            case KeyPressed(verdict="accepted", press=press, time_ns=time_ns, value=value, person=person):
                if value is None:
                    raise ValueError(f"press {press} was accepted, and means nothing: its value is null")
                yield self._listener.learn_from_press(press, time_ns, value, person)
            case PressRetracted(press=press):
                self._listener.retract(press)
            case StopAsked():
                self.stop_asked = item
            case _:
                # a refused press, a cue, the end of a pause, the window's focus: recorded, nothing to learn
                pass

    def _take_answer(self, number: int, chosen: int, person: int) -> None:
        if number != self._posed - 1:
            raise ValueError(f"question {number} is answered; the last one posed is {self._posed - 1}")
        question, self._question = self._question, None
        if question is not None and chosen >= 0:
            self._listener.learn_from_answer(question, chosen, person)

    def _screen_shows(self, step: int, time_ns: int) -> None:
        if step == self._on_screen:
            return
        if self._on_screen >= 0:
            self._listener.step_hidden(time_ns)
        if step >= 0:
            if step not in self._features:
                raise ValueError(f"step {step} is shown, which is none of the last two steps taken")
            self._listener.step_shown(step, self._features[step], time_ns)
        self._on_screen = step


@dataclass(frozen=True, slots=True)
class EpisodePlan:
    """What is fixed before a watched episode begins."""

    episode_seed: int
    policy: EpisodePolicy
    """From the agent's `begin_episode`; it says which episode this is."""
    first_step: int
    """Number of the episode's first step among all watched steps of the session."""
    max_steps: int


def play_episode(
    domain: Domain[Any],
    agent: Agent,
    intake: FeedbackIntake,
    clock: Clock,
    plan: EpisodePlan,
) -> Iterator[Output]:
    """Play one watched episode; yield its outputs in the order in which they happen.

    When a `StepTaken` has been yielded, the consumer shows the step. It asks for the next output when the
    step's time on screen is over: then what the participant did meanwhile is taken in.
    """
    yield _started(intake, clock, plan)
    state = domain.initial(plan.episode_seed)
    count = _Count()
    for step in _steps(domain, agent, plan.policy, state, first_watched=plan.first_step):
        number = plan.first_step + count.steps
        if isinstance(step, _Posed):
            yield _posed(domain, intake, clock, plan, step, number)
            yield from intake.attend(-1)
            continue
        intake.expect(number, step.choices.feedback_features[step.decision.action])
        count.add(step.decision)
        yield _taken(domain, intake, clock, plan, step, number)
        yield from intake.attend(number)
        state = step.following
        if count.steps == plan.max_steps or intake.stop_asked is not None:
            break
    played = count.played(domain, state)
    agent.learn_from_domain(plan.policy, played)
    yield EpisodeEnded(
        episode=plan.policy.episode,
        time_ns=clock.now_ns(),
        inputs=intake.inputs,
        performance=played.performance,
        steps=played.steps,
        ended=played.ended,
        agreed=played.agreed,
        agreed_worst=played.agreed_worst,
        trust=agent.trust,
        digest=agent.digest(),
        time=played.time,
    )
    # Late presses on the last steps, made while the final picture was shown.
    yield from intake.attend(-1)


def _started(intake: FeedbackIntake, clock: Clock, plan: EpisodePlan) -> EpisodeStarted:
    """Return the record of an episode's begin."""
    weights = plan.policy.episode_weights
    return EpisodeStarted(
        episode=plan.policy.episode,
        time_ns=clock.now_ns(),
        inputs=intake.inputs,
        episode_seed=plan.episode_seed,
        policy=plan.policy.policy_id,
        form=weights.form,
        w_r=weights.w_r,
        trust=plan.policy.trust,
        weight=weights.w_h,
        handover=weights.handover,
        shaping=weights.shaping,
        augmentation=weights.augmentation,
    )


def _taken(
    domain: Domain[Any],
    intake: FeedbackIntake,
    clock: Clock,
    plan: EpisodePlan,
    step: "_Step",
    number: int,
) -> StepTaken:
    """Return the record of a step; `number` counts the watched steps of the session, from 0."""
    decision = step.decision
    return StepTaken(
        episode=plan.policy.episode,
        step=number,
        time_ns=clock.now_ns(),
        inputs=intake.inputs,
        action=decision.action,
        environment_action=decision.environment_action,
        human_action=decision.human_action,
        detail=domain.action_record(step.state, decision.action).plain(),
        reward=step.reward,
        state=domain.recorded_state(step.state),
    )


def _posed(
    domain: Domain[Any],
    intake: FeedbackIntake,
    clock: Clock,
    plan: EpisodePlan,
    posed: "_Posed",
    step: int,
) -> QuestionPosed:
    """Return the record of a question about the decision that comes next, step number `step`."""
    options = posed.question.options
    return QuestionPosed(
        question=intake.pose(posed.question),
        episode=plan.policy.episode,
        step=step,
        time_ns=clock.now_ns(),
        inputs=intake.inputs,
        options=list(options),
        details=[domain.action_record(posed.state, option).plain() for option in options],
        disagreement=posed.question.disagreement,
    )


def play_unseen(
    domain: Domain[Any],
    agent: Agent,
    policy: EpisodePolicy,
    episode_seed: int,
    max_steps: int,
    *,
    learning: bool = True,
) -> Played:
    """Play one episode that nobody watches, step by step.

    Args:
        domain: what is played.
        agent: who plays; told of every step (`learn_from_step`), not of the episode's end.
        policy: from the agent's `begin_episode`.
        episode_seed: of the episode.
        max_steps: where it is broken off, >= 1.
        learning: False leaves the agent as it is.
    """
    state = domain.initial(episode_seed)
    count = _Count()
    for step in _steps(domain, agent, policy, state, learning=learning):
        assert isinstance(step, _Step), "questions are posed in watched episodes"
        count.add(step.decision)
        state = step.following
        if count.steps == max_steps:
            break
    return count.played(domain, state)


@dataclass(frozen=True, slots=True)
class _Step:
    state: Any
    choices: Choices
    decision: Decision
    reward: float
    following: Any


@dataclass(frozen=True, slots=True)
class _Posed:
    """A question about the decision that comes next; what is learned from its answer counts there."""

    state: Any
    question: Question


def _steps(
    domain: Domain[Any],
    agent: Agent,
    policy: EpisodePolicy,
    state: Any,
    *,
    learning: bool = True,
    first_watched: int = -1,
) -> Iterator[_Step | _Posed]:
    """Let the agent play from `state` to the end of the episode: the one loop of agent and domain.

    `first_watched` is the number of the first step among the session's watched ones; -1 where nobody watches.
    """
    number = 0
    while not domain.terminal(state):
        choices = domain.choices(state)
        question = None if first_watched < 0 else agent.question(choices)
        if question is not None:
            yield _Posed(state, question)
        decision = agent.choose(choices, policy, step=number)
        transition = domain.transition(state, decision.action)
        if learning:
            watched = -1 if first_watched < 0 else first_watched + number
            agent.learn_from_step(choices, decision.action, transition.reward, watched_step=watched)
        yield _Step(state, choices, decision, transition.reward, transition.next_state)
        state = transition.next_state
        number += 1


class _Count:
    """Counts an episode's steps, and agreement of the agent's two sides."""

    def __init__(self) -> None:
        self.steps = 0
        self._tally = EpisodeTally()

    def add(self, decision: Decision) -> None:
        self.steps += 1
        self._tally.add(decision)

    def played(self, domain: Domain[Any], state: Any) -> Played:
        return Played(
            performance=domain.performance(state),
            steps=self.steps,
            agreed=int(self._tally.counts[AGREED]),
            agreed_worst=int(self._tally.counts[AGREED_WORST]),
            ended="termination" if domain.terminal(state) else "truncation",
            time=domain.time(state),
            agreement=self._tally.agreement,
            with_each=self._tally.with_each,
        )
