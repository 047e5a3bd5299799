"""What-if replay: what an agent would have learned from a recording under another credit rule or scheme.

The watched steps and the presses stay as they were recorded; credit, human model, trust and the unseen
episodes are worked out anew. This is off-policy: people judged the steps of the agent they saw, and another
agent would have shown others. What is learned from the recorded steps is exact; what it would have led to on
screen is not claimed.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import msgspec

from core.combination.agent import ArlAgent, Decision, EpisodePolicy
from core.combination.asking import Question
from core.combination.human_learner import HumanLearner
from core.combination.tally import AGREED, AGREED_WORST, EpisodeTally
from core.domain import Choices, Domain, Features
from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    Input,
    KeyPressed,
    PressRetracted,
    QuestionPosed,
    Resumed,
    SessionEnded,
    StepTaken,
    UnseenPlayed,
)
from core.numerics.streams import stream_seed
from core.recording.reader import Recording, RecordingError
from core.registry import Player, game_of
from core.session.inputs import check_inputs
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.replay import Recorded, naming_the_input
from core.session.rollout import FeedbackIntake, Played


@dataclass(frozen=True, slots=True, eq=False)
class WatchedStep:
    """A step of a recording, as an agent sees it."""

    step: int
    choices: Choices
    taken: Features
    """psi(s, a) of the action that was taken, shape (G,); NaN where the recording does not tell."""


OnDecision = Callable[[ArlAgent, WatchedStep, EpisodePolicy, Decision, int], None]
"""Is called after each decision of an agent at a watched step; last comes the number of the decision in its
episode."""


@dataclass(frozen=True, slots=True, eq=False)
class HumanModelReplay:
    """What a human model has learned from a recording, without any environment."""

    human: HumanLearner
    credits: list[CreditGiven]
    """How each press that counted was shared out, in order."""


@dataclass(frozen=True, slots=True, eq=False)
class Relearned:
    """What an agent has learned from a recording."""

    agent: ArlAgent
    trust: list[float] = field(default_factory=list)
    """What the rule of trust said after each watched episode."""
    credits: list[CreditGiven] = field(default_factory=list)
    """How each accepted press was shared out, in order."""


def watched_steps(recording: Recording, protocol: Protocol) -> dict[int, WatchedStep]:
    """Return every watched step by its number, with the features that `protocol` asks for.

    Raises:
        RecordingError: the protocol is about another game; a step's state was not recorded, and the game
            plays otherwise now than it did then; or an input cannot have happened where it stands.
    """
    try:
        own = protocol_from(recording.header.protocol)
    except ValueError as error:
        raise RecordingError(f"{recording.path}:1: the protocol cannot be used: {error}") from error
    check_inputs(recording, own.keys_of_people, own.agent.asking)
    recorded = own.game
    if recorded != protocol.game:
        raise RecordingError(
            f"{recording.path}: a recording of {recorded}, and the protocol is about {protocol.game}"
        )
    game = game_of(protocol)
    domain = game.domain(protocol)
    steps: dict[int, WatchedStep] = {}
    seed, state = 0, None
    for output in recording.outputs:
        match output:
            case EpisodeStarted():
                seed, state = output.episode_seed, None
            case StepTaken(state=None, observed=None):
                state = _begun(recording, domain, seed) if state is None else state
                choices = None if domain.terminal(state) else domain.choices(state)
                if choices is None or not _could_be(output, choices, domain, state):
                    raise RecordingError(
                        f"{recording.path}: step {output.step} was {output.detail}, and comes out otherwise "
                        f"now: {domain.name} has changed since, and what was on screen was not recorded. Use "
                        "the program that recorded it: "
                        f"{recording.header.software.get('commit', 'its header does not name the commit')}"
                    )
                state = domain.transition(state, output.action).next_state
                steps[output.step] = WatchedStep(
                    output.step, choices, choices.feedback_features[output.action]
                )
            case StepTaken():
                try:
                    steps[output.step] = WatchedStep(output.step, *game.recorded(domain, output))
                except (ValueError, LookupError, ArithmeticError) as error:
                    raise RecordingError(
                        f"{recording.path}: step {output.step}: {error}: is the protocol's game of another "
                        f"size?"
                    ) from error
    return steps


def _begun(recording: Recording, domain: Domain[Any], seed: int) -> Any:
    """Return the state in which a recorded episode begins."""
    try:
        return domain.initial(seed)
    except (ValueError, ArithmeticError) as error:
        raise RecordingError(
            f"{recording.path}: no game can begin as recorded: {error}. The file was changed after it was "
            f"recorded, or another program wrote it"
        ) from error


def _could_be(taken: StepTaken, choices: Choices, domain: Domain[Any], state: Any) -> bool:
    """Return whether a recorded step can be one of these choices in this state."""
    if not 0 <= taken.action < len(choices.ruled_out):
        return False
    return domain.action_record(state, taken.action).plain() == taken.detail


def recorded_question(posed: QuestionPosed, steps: dict[int, WatchedStep]) -> Question | None:
    """Return a recorded question with the features that `steps` have; None where its step was never taken.

    What was asked stays as it was recorded, as steps and presses do: an agent that learns again poses no
    questions of its own.
    """
    if posed.step not in steps:
        return None
    features = steps[posed.step].choices.feedback_features
    return Question(tuple(posed.options), features[posed.options], posed.disagreement)


def relearn(
    recording: Recording,
    protocol: Protocol,
    steps: dict[int, WatchedStep],
    *,
    root_seed: int,
    on_decision: OnDecision | None = None,
) -> Relearned:
    """Let a new agent live through a recording.

    Args:
        recording: live, simulated or imported.
        protocol: the agent's own protocol; its credit, scheme, trust and human model may differ from the
            recorded.
        steps: from `watched_steps` with the same protocol.
        root_seed: of the agent and of unseen episodes. That of the recording gives a live session's own
            agent.
        on_decision: is called after each decision at a watched step.
    """
    game = game_of(protocol)
    agent = game.agent(protocol, root_seed)
    play = game.player(protocol, agent)
    source = Recorded(recording.inputs)
    intake = FeedbackIntake(agent, source)
    relearned = Relearned(agent)
    watched = _Watched(steps, game.time_at_end, on_decision)
    imported = recording.header.origin == "imported"
    session = protocol.session
    with naming_the_input(recording, source):
        for output in recording.outputs:
            if not isinstance(output, CreditGiven):
                source.taken_before_next_output = output.inputs
                relearned.credits.extend(intake.attend(-1))
            match output:
                case EpisodeStarted():
                    if imported:
                        count = session.unseen_between if relearned.trust else session.unseen_before
                        _play_unseen(agent, play, protocol, root_seed, count)
                    watched.begin(agent.begin_episode(exploring=session.watched == "proposed", watched=True))
                case StepTaken():
                    watched.take(agent, intake, output)
                case QuestionPosed():
                    intake.pose(recorded_question(output, steps))
                case EpisodeEnded():
                    agent.learn_from_domain(watched.policy, watched.played(output))
                    relearned.trust.append(agent.trust)
                case SessionEnded():
                    agent.finish(output.time_ns)
                case UnseenPlayed():
                    _play_unseen(agent, play, protocol, root_seed, len(output.policies))
        relearned.credits.extend(_attend_rest(intake, source, recording))
    return relearned


def replay_human_model(
    recording: Recording, protocol: Protocol, steps: dict[int, WatchedStep], *, count: Callable[[int], bool]
) -> HumanModelReplay:
    """Let only a human model live through a recording.

    Args:
        recording: live, simulated or imported.
        protocol: whose credit rule and human model are used.
        steps: from `watched_steps` with the same protocol.
        count: which accepted presses (by number) count; the others are left out.
    """
    human = game_of(protocol).listener(protocol)
    inputs = tuple(_countable(recording.inputs, count))
    source = Recorded(inputs)
    intake = FeedbackIntake(human, source)
    credits: list[CreditGiven] = []
    with naming_the_input(recording, source):
        for output in recording.outputs:
            if not isinstance(output, CreditGiven):
                source.taken_before_next_output = output.inputs
                credits.extend(intake.attend(-1))
            if isinstance(output, StepTaken):
                intake.expect(output.step, steps[output.step].taken)
            elif isinstance(output, QuestionPosed):
                intake.pose(recorded_question(output, steps))
            elif isinstance(output, SessionEnded):
                human.finish(output.time_ns)
        credits.extend(_attend_rest(intake, source, recording))
    return HumanModelReplay(human, credits)


class _Watched:
    """Follows one recorded episode with an agent that is asked, but not obeyed."""

    def __init__(
        self,
        steps: dict[int, WatchedStep],
        time_at_end: Callable[[EpisodeEnded], int],
        on_decision: OnDecision | None = None,
    ) -> None:
        self._steps = steps
        self._time_at_end = time_at_end
        self._on_decision = on_decision
        self._policy: EpisodePolicy | None = None
        self._taken = 0
        self._tally = EpisodeTally()

    @property
    def policy(self) -> EpisodePolicy:
        if self._policy is None:
            raise ValueError("a step or an end of an episode that has not started")
        return self._policy

    def begin(self, policy: EpisodePolicy) -> None:
        self._policy = policy
        self._taken = 0
        self._tally = EpisodeTally()

    def take(self, agent: ArlAgent, intake: FeedbackIntake, output: StepTaken) -> None:
        watched = self._steps[output.step]
        decision = agent.choose(watched.choices, self.policy, step=self._taken)
        self._tally.add(decision)
        if self._on_decision is not None:
            self._on_decision(agent, watched, self.policy, decision, self._taken)
        agent.learn_from_step(watched.choices, output.action, output.reward, watched_step=output.step)
        intake.expect(output.step, watched.taken)
        self._taken += 1

    def played(self, output: EpisodeEnded) -> Played:
        return Played(
            output.performance,
            output.steps,
            int(self._tally.counts[AGREED]),
            int(self._tally.counts[AGREED_WORST]),
            output.ended,
            output.time if output.time is not None else self._time_at_end(output),
            self._tally.agreement,
            self._tally.with_each,
        )


def _countable(inputs: Iterable[Input], count: Callable[[int], bool]) -> Iterator[Input]:
    """Yield the inputs with presses that are not to count turned into refused ones."""
    for item in inputs:
        if isinstance(item, KeyPressed) and item.verdict == "accepted" and not count(item.press):
            yield msgspec.structs.replace(item, verdict="other")
        elif isinstance(item, PressRetracted) and not count(item.press):
            yield Resumed(time_ns=item.time_ns)  # says nothing, and keeps the inputs' numbers
        else:
            yield item


def _play_unseen(agent: ArlAgent, play: Player, protocol: Protocol, root_seed: int, count: int) -> None:
    for _ in range(count):
        policy = agent.begin_episode(exploring=True, watched=False)
        seed = stream_seed(root_seed, "episode", policy.episode)
        agent.learn_from_domain(policy, play(policy, seed, protocol.session.unseen_steps))


def _attend_rest(intake: FeedbackIntake, source: Recorded, recording: Recording) -> Iterator[CreditGiven]:
    """Take in what came after the last output of a session that was cut off; a closed one has
    none.
    """
    if recording.outputs and isinstance(recording.outputs[-1], SessionEnded):
        return
    source.taken_before_next_output = len(recording.inputs)
    yield from intake.attend(-1)
