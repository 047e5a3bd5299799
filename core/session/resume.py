"""A session that broke off goes on: what was recorded is run again and compared, then it goes on live."""

from collections.abc import Callable, Iterator, Sequence

from core.events import CreditGiven, Input, Output
from core.numerics.clock import Clock
from core.recording.joined import FinishedPart, ResumeError
from core.recording.version_1 import as_far_as_recorded
from core.session.replay import Recorded, first_difference
from core.session.rollout import FeedbackSource
from core.session.session import Session


class ResumedSession:
    """A session up to its last finished game as it was recorded, and live from there on."""

    def __init__(self, session: Session, kept: FinishedPart) -> None:
        """Prepare; nothing is run yet.

        Args:
            session: a new one, built from the recording's protocol and root seed.
            kept: what the recording holds of it, at least one finished game.
        """
        self._session = session
        self._kept = kept
        self._joint = _Joint(kept.inputs)
        self._outputs = session.run(self._joint, self._joint)

    def catch_up(self) -> None:
        """Run everything again that was recorded: afterwards the agent knows what it knew.

        Raises:
            ResumeError: something comes out otherwise than recorded.
        """
        recorded = self._kept.outputs
        for number, before in enumerate(recorded):
            timed = next((one for one in recorded[number:] if not isinstance(one, CreditGiven)), None)
            if timed is None:
                self._joint.taken_before_next_output = len(self._kept.inputs)
            else:
                self._joint.taken_before_next_output, self._joint.time_ns = timed.inputs, timed.time_ns
            try:
                now = next(self._outputs, None)
            except (ValueError, LookupError, ArithmeticError) as error:
                raise ResumeError(
                    f"{self._kept.path}: no session can go on from what was recorded: "
                    f"{type(error).__name__}: {error}. "
                    "The file was changed after it was recorded, or another program wrote it"
                ) from error
            if now is not None:
                now = as_far_as_recorded(before, now)
            if now != before:
                raise ResumeError(
                    f"{self._kept.path}: the session cannot go on, because it comes out otherwise now: "
                    f"{first_difference(number, before, now)}. Go on with the program that recorded it "
                    f"({self._kept.header.software.get('commit', 'its header names no commit')}), or begin "
                    f"anew"
                )

    @property
    def before_unseen(self) -> Callable[[], None]:
        """Called before each block of unseen episodes (`core.session.session.Session`)."""
        return self._session.before_unseen

    @before_unseen.setter
    def before_unseen(self, call: Callable[[], None]) -> None:
        self._session.before_unseen = call

    @property
    def after_unseen(self) -> Callable[[int, int], None]:
        """Called after each unseen episode (`core.session.session.Session`)."""
        return self._session.after_unseen

    @after_unseen.setter
    def after_unseen(self, call: Callable[[int, int], None]) -> None:
        self._session.after_unseen = call

    def run(self, feedback: FeedbackSource, clock: Clock) -> Iterator[Output]:
        """Yield the outputs after the recorded ones; to be called after `catch_up`."""
        self._joint.go_live(feedback, clock)
        yield from self._outputs


class _Joint(Recorded):
    """Feedback and clock of a session that goes on: the recorded ones first, then live ones."""

    def __init__(self, inputs: Sequence[Input]) -> None:
        super().__init__(inputs)
        self.time_ns = 0
        self._n_recorded = len(inputs)
        self._live: tuple[FeedbackSource, Clock] | None = None

    def go_live(self, feedback: FeedbackSource, clock: Clock) -> None:
        """Take the rest of the recorded inputs first, and then those of `feedback`."""
        self.taken_before_next_output = self._n_recorded
        self._live = feedback, clock

    def during(self, step: int) -> Iterator[Input]:
        """Yield the inputs that are taken in now (`core.session.rollout.FeedbackSource`)."""
        live = self._live
        yield from super().during(step)
        if live is not None:
            yield from live[0].during(step)

    def now_ns(self) -> int:
        """Return the recorded time, or the live one (`core.numerics.clock.Clock`)."""
        return self.time_ns if self._live is None else self._live[1].now_ns()
