"""The one loop in which an agent meets a domain: live, simulated and replayed sessions all run it."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, Protocol

from core.combination.agreement import Agreement
from core.combination.sides import EpisodePolicy
from core.combination.tally import AGREED, AGREED_WORST, Compared, EpisodeTally
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
    ScreenCleared,
    StepTaken,
    StopAsked,
    TimeGap,
)
from core.numerics.clock import Clock


class Decision(Compared, Protocol):
    """What an agent decided, and what each of its two sources would have."""

    @property
    def action(self) -> int:
        """Index of the chosen action."""
        ...


@dataclass(frozen=True, slots=True)
class Played:
    """What came of one episode: the agent learns from this, whether it was watched or not."""

    performance: float
    """The domain's performance measure (`Domain.performance`)."""
    steps: int
    agreed: int
    """Steps at which environment and human policy chose the same action."""
    agreed_worst: int
    """Steps at which the environment policy chose the human policy's worst action."""
    ended: Literal["termination", "truncation"]
    time: int = 0
    """The domain's own time at the end (`Domain.time`)."""
    agreement: Agreement | None = None
    """Agreement over the decisions at which there was a human policy; None where there was none. (`agreed`
    and `agreed_worst` are recorded, and compiled games count them without a human policy, too.)"""
    with_each: tuple[Agreement | None, ...] = ()
    """Agreement with each participant's own model; empty where the player did not count it."""


class FeedbackSource(Protocol):
    """Where inputs come from: a live screen, a recording, or a simulated participant."""

    def during(self, step: int) -> Iterable[Input]:
        """Return, in order, the inputs that have arrived since the last call.

        Called when a watched step's time on screen is over; `step` is -1 between episodes.
        """
        ...


class Listener(Protocol):
    """What hears a participant: the part of an agent that inputs reach."""

    def step_shown(self, step: int, features: Features, time_ns: int) -> None:
        """Note that a watched step with these feedback features, shape (G,), came on screen."""
        ...

    def step_hidden(self, time_ns: int) -> None:
        """Note that the step on screen went off it."""
        ...

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on: no later press speaks of what was on screen
        before.
        """
        ...

    def learn_from_press(self, press: int, time_ns: int, value: float, participant: int = 0) -> CreditGiven:
        """Learn from an accepted press of a participant; return how it was shared out."""
        ...

    def retract(self, press: int) -> None:
        """Forget a press as if it had never been made."""
        ...

    def finish(self, time_ns: int) -> None:
        """Learn from the steps that still waited for presses: the session is over."""
        ...


class Agent(Listener, Protocol):
    """What a session asks of an agent."""

    @property
    def trust(self) -> float:
        """What the rule of trust says of the participant now."""
        ...

    def begin_episode(self, *, exploring: bool, watched: bool) -> EpisodePolicy:
        """Begin the next episode; return its policy: a new one to evaluate, or one of the best so far."""
        ...

    def choose(self, choices: Choices, policy: EpisodePolicy, *, step: int) -> Decision:
        """Decide step number `step` of the episode."""
        ...

    def learn_from_step(
        self, choices: Choices, action: int, reward: float, *, watched_step: int = -1
    ) -> None:
        """Take in what was done in the decision last made, and the reward of its step.

        `watched_step` is the step's number among all watched ones of the session; -1 where nobody watches.
        """
        ...

    def learn_from_domain(self, policy: EpisodePolicy, played: Played) -> None:
        """Take in how an episode with `policy` went."""
        ...

    def export(self) -> dict[str, list[float]]:
        """Return all weight vectors by name."""
        ...

    def digest(self) -> str:
        """Return a fingerprint of everything learned, hex."""
        ...


class FeedbackIntake:
    """Brings the inputs to whoever learns from them: which step was on screen when, and what the participant
    said of it.

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
            case ScreenCleared(time_ns=time_ns):
                self._screen_shows(-1, time_ns)
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

    When a `StepTaken` has been yielded, whoever consumes this shows the step, and asks for the next output
    when the step's time on screen is over: then what the participant did meanwhile is taken in.
    """
    weights = plan.policy.episode_weights
    yield EpisodeStarted(
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
    state = domain.initial(plan.episode_seed)
    count = _Count()
    for step in _steps(domain, agent, plan.policy, state, first_watched=plan.first_step):
        number, decision = plan.first_step + count.steps, step.decision
        intake.expect(number, step.choices.feedback_features[decision.action])
        count.add(decision)
        yield StepTaken(
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


def _steps(
    domain: Domain[Any],
    agent: Agent,
    policy: EpisodePolicy,
    state: Any,
    *,
    learning: bool = True,
    first_watched: int = -1,
) -> Iterator[_Step]:
    """Let the agent play from `state` to the end of the episode: the one loop of agent and domain.

    `first_watched` is the number of the first step among the session's watched ones; -1 where nobody watches.
    """
    number = 0
    while not domain.terminal(state):
        choices = domain.choices(state)
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
