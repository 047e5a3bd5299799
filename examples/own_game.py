"""A tiny game of your own: a walk along a corridor, learned by the same agent and the same loop as Tetris.

    python examples/own_game.py

The walker starts in the middle of nine places. The right end pays 1. A participant who watches says "good" to each step to
the right. The program plays the session without a screen. docs/extending.md says how a game gets screens and a name.
"""  # noqa: E501

from collections.abc import Iterator

import numpy as np

from core import (
    AgentConfig,
    ArlAgent,
    Choices,
    CreditConfig,
    CurrentStep,
    ManualClock,
    Session,
    SessionConfig,
    Transition,
    play_unseen,
)
from core.events import ActionRecord, EpisodeEnded, FrameShown, Input, KeyPressed, StepTaken
from core.learners.cross_entropy import CrossEntropyLearner
from core.learners.cross_entropy_config import CrossEntropyConfig

LAST = 8
STEP_NS = 500_000_000


class Move(ActionRecord, frozen=True):
    """What is done at a step."""

    place: int
    right: int


class Corridor:
    """The domain. A state is (place, steps so far); the actions are left and right."""

    name = "corridor"
    feature_names = ("left", "right")
    observation_names = ()  # each action is described by a row of features, the state by nothing more
    feedback_feature_names = ("left", "right")

    def initial(self, episode_seed: int) -> tuple[int, int]:
        """Return the middle."""
        return LAST // 2, 0

    def terminal(self, state: tuple[int, int]) -> bool:
        """Return whether an end is reached."""
        return state[0] in (0, LAST)

    def choices(self, state: tuple[int, int]) -> Choices:
        """Describe going left and going right: one row each."""
        return Choices(features=np.eye(2), feedback_features=np.eye(2), ruled_out=np.zeros(2, dtype=np.bool_))

    def transition(self, state: tuple[int, int], action: int) -> Transition[tuple[int, int]]:
        """Go one place; the right end pays 1."""
        place = state[0] + (1 if action else -1)
        return Transition((place, state[1] + 1), reward=float(place == LAST), duration=1)

    def performance(self, state: tuple[int, int]) -> float:
        """Return 1 at the right end, else 0."""
        return float(state[0] == LAST)

    def time(self, state: tuple[int, int]) -> int:
        """Return the number of steps."""
        return state[1]

    def action_record(self, state: tuple[int, int], action: int) -> Move:
        """Return the place and the direction, for recordings."""
        return Move(state[0], action)

    def recorded_state(self, state: tuple[int, int]) -> None:
        """Return nothing: the rules are enough."""


class Participant:
    """Sees each step for half a second, and praises each step to the right."""

    def __init__(self, clock: ManualClock) -> None:
        self._clock = clock
        self._presses = 0
        self.right = False
        """Whether the step on screen goes to the right."""

    def during(self, step: int) -> Iterator[Input]:
        """Yield what was shown and pressed; `step` is -1 between episodes."""
        yield FrameShown(frame=max(step, 0), step=step, flushed_ns=self._clock.now_ns())
        self._clock.advance_ns(STEP_NS)
        if step >= 0:
            value = 1.0 if self.right else -1.0
            yield KeyPressed(
                press=self._presses,
                time_ns=self._clock.now_ns() - STEP_NS // 2,
                key="j" if self.right else "f",
                value=value,
                frame=step,
                step=step,
                verdict="accepted",
            )
            self._presses += 1


def main() -> None:
    """Play five watched games with a few unseen ones between them."""
    domain, clock = Corridor(), ManualClock()
    agent = ArlAgent(
        CrossEntropyLearner(CrossEntropyConfig(population=10), n_weights=2, root_seed=1),
        AgentConfig(credit=CreditConfig(delay=CurrentStep())),
        n_feedback_features=2,
        root_seed=1,
    )
    session = Session(
        domain,
        agent,
        lambda policy, seed, most: play_unseen(domain, agent, policy, seed, most),
        SessionConfig(episodes=5, unseen_between=10, watched_steps=50, unseen_steps=50),
        root_seed=1,
    )
    participant = Participant(clock)
    for output in session.run(participant, clock):
        if isinstance(output, StepTaken):
            participant.right = bool(output.action)
        if isinstance(output, EpisodeEnded):
            print(f"Game {output.episode}: performance {output.performance:.0f}, trust {output.trust:.2f}")
    print("What the participant taught (left, right):", np.round(agent.human.weights, 2))


if __name__ == "__main__":
    main()
