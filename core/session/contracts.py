"""What a session asks of an agent, and where its inputs come from."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, Protocol

from core.combination.agreement import Agreement
from core.combination.asking import Question
from core.combination.sides import EpisodePolicy
from core.combination.tally import Compared
from core.domain import Choices, Features
from core.events import CreditGiven, Input


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
        """Note that the program stood still from `last_ns` on: no later press is about what was on screen
        before.
        """
        ...

    def learn_from_press(self, press: int, time_ns: int, value: float, participant: int = 0) -> CreditGiven:
        """Learn from an accepted press of a participant; return how it was shared out."""
        ...

    def retract(self, press: int) -> None:
        """Forget a press as if it had never been made."""
        ...

    def learn_from_answer(self, question: Question, chosen: int, participant: int = 0) -> None:
        """Learn which of a question's options a participant has chosen."""
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

    def question(self, choices: Choices) -> Question | None:
        """Return what to ask the participant before this decision of a watched episode, if anything."""
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
