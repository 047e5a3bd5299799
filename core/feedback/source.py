"""A simulated participant in front of a simulated screen: a source of inputs like a live session's.

Inputs come through the same `PressGate` as real keys, so that budgets, repeats and records are the same.
"""

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from core.domain import Domain
from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    FrameShown,
    Input,
    KeyPressed,
    Output,
    QuestionAnswered,
    QuestionPosed,
    Resumed,
    ScreenCleared,
    StepTaken,
)
from core.feedback.asking_config import AskingConfig
from core.feedback.keys import PressGate
from core.feedback.trainers import IntendedPress, SimulatedTrainer
from core.feedback.viewing import Viewing
from core.numerics.clock import NS_PER_S, ManualClock

State = TypeVar("State")

Oracle = Callable[[State], NDArray[np.float64]]
"""Values of all actions in a state, by a participant who knows the game; -inf for a fatal one."""


@dataclass(frozen=True, slots=True, eq=False)
class ParticipantParts(Generic[State]):
    """One more person before the same screen."""

    oracle: Oracle[State]
    """By which they judge."""
    trainer: SimulatedTrainer
    """Decides what they press and when."""
    gate: PressGate
    """Decides which of their presses count; has their number, and shares the numbers of presses."""


class SimulatedParticipant(Generic[State]):
    """Watches a session at its pace and presses keys; a `core.session.rollout.FeedbackSource`.

    The consumer of the session's outputs hands each of them to `watch` before asking for the next one::

        for output in session.run(participant, clock):
            record(output)
            for item in participant.watch(output):
                record(item)
    """

    def __init__(
        self,
        domain: Domain[State],
        oracle: Oracle[State],
        trainer: SimulatedTrainer,
        gate: PressGate,
        clock: ManualClock,
        viewing: Viewing,
        *,
        others: Sequence[ParticipantParts[State]] = (),
        asking: AskingConfig | None = None,
    ) -> None:
        """Sit down.

        Args:
            domain: what is played; its states follow from the outputs.
            oracle: by which the trainer judges.
            trainer: decides what is pressed and when.
            gate: decides which presses count.
            clock: the session's clock; it is moved on while steps are on screen.
            viewing: how long everything stays on screen.
            others: further participants.
            asking: keys and limit of answers; None: the defaults. The first participant answers.
        """
        self._domain = domain
        self._participants = (ParticipantParts(oracle, trainer, gate), *others)
        self._clock = clock
        self._viewing = viewing
        self._asking = asking or AskingConfig()
        self._state: State | None = None
        self._frame = -1
        self._arrived: list[Input] = []
        # Presses to come; the counter keeps those of equal times in order.
        self._due: list[tuple[int, int, IntendedPress, PressGate]] = []
        self._planned = 0

    def during(self, step: int) -> list[Input]:
        """Return the inputs since the last call."""
        arrived, self._arrived = self._arrived, []
        return arrived

    def watch(self, output: Output) -> list[Input]:
        """Look at an output for as long as it is shown; return what was shown and pressed meanwhile."""
        before = len(self._arrived)
        match output:
            case EpisodeStarted(episode=episode, episode_seed=episode_seed):
                self._state = self._domain.initial(episode_seed)
                for parts in self._participants:
                    parts.trainer.watch_episode(episode)
                    parts.gate.episode_started()
                opening_ns = self._viewing.opening_ns(self._state)
                if opening_ns > 0:
                    self._show(-1)
                    self._wait(opening_ns)
            case StepTaken(step=step, action=action):
                self._show(step)
                self._wait(self._plan(step, action))
            case QuestionPosed():
                self._show(-1)
                self._wait(round(self._asking.settle_s * NS_PER_S))
                self._answer(output)
            case EpisodeEnded():
                self._show(-1)
                self._wait(self._viewing.pause_ns)
            case _:
                pass  # nothing to see
        return self._arrived[before:]

    def _show(self, step: int) -> None:
        self._frame += 1
        for parts in self._participants:
            parts.gate.frame, parts.gate.step = self._frame, step
        self._arrived.append(FrameShown(frame=self._frame, step=step, flushed_ns=self._clock.now_ns()))

    def _plan(self, step: int, action: int) -> int:
        """Note what will be pressed about a step; return how long it is on screen, in nanoseconds."""
        assert self._state is not None, "an episode starts before its first step"
        now_ns = self._clock.now_ns()
        following = self._domain.transition(self._state, action).next_state
        seen = self._viewing.watched(self._state, action, following)
        for parts in self._participants:
            presses = parts.trainer.watch(
                step,
                parts.oracle(self._state),
                action,
                shown_ns=now_ns,
                hidden_ns=now_ns + seen.judged_after_ns,
                attention=seen.attention,
            )
            for press in presses:
                heapq.heappush(self._due, (press.time_ns, self._planned, press, parts.gate))
                self._planned += 1
        self._state = following
        return seen.duration_ns

    def _wait(self, duration_ns: int) -> None:
        """Let time go by, and press what is due."""
        until_ns = self._clock.now_ns() + duration_ns
        while self._due and self._due[0][0] <= until_ns:
            time_ns, _, press, gate = heapq.heappop(self._due)
            self._clock.advance_to_ns(time_ns)
            key = gate.config.key_of(press.value)
            gate.wrong_asked = press.deliberate
            self._arrived.extend(gate.judge(key, self._clock.now_ns(), source="simulated"))
            gate.wrong_asked = False
        self._clock.advance_to_ns(until_ns)

    def _answer(self, posed: QuestionPosed) -> None:
        """Look at a question until it is over; presses that come due meanwhile do not count."""
        assert self._state is not None, "an episode starts before its first question"
        first = self._participants[0]
        shown_ns = self._clock.now_ns()
        for parts in self._participants:
            parts.gate.covered, parts.gate.frame, parts.gate.step = True, -1, -1
        self._arrived.append(ScreenCleared(time_ns=shown_ns, reason="question"))
        chosen = first.trainer.answer(posed.step, first.oracle(self._state), posed.options)
        limit_ns = round(self._asking.limit_s * NS_PER_S)
        taken_ns = round(first.trainer.answer_delay_s(posed.step) * NS_PER_S)
        self._wait(min(taken_ns, limit_ns))
        now_ns = self._clock.now_ns()
        if taken_ns > limit_ns:
            self._arrived.append(
                QuestionAnswered(
                    question=posed.question, shown_ns=shown_ns, time_ns=now_ns, answer="time-limit"
                )
            )
        else:
            keys = self._asking.keys
            key = self._asking.none_key if chosen is None else keys[posed.options.index(chosen)]
            pressed = list(first.gate.judge(key, now_ns, source="simulated"))
            self._arrived.extend(pressed)
            press = next(item for item in pressed if isinstance(item, KeyPressed))
            self._arrived.append(
                QuestionAnswered(
                    question=posed.question,
                    shown_ns=shown_ns,
                    time_ns=now_ns,
                    answer="none" if chosen is None else "chosen",
                    chosen=-1 if chosen is None else chosen,
                    press=press.press,
                )
            )
        for parts in self._participants:
            parts.gate.covered = False
        self._arrived.append(Resumed(time_ns=now_ns))
