"""From what was on screen and what was pressed to the samples a human reward model learns from."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from core.domain import Features
from core.feedback.ledger import Ledger
from core.feedback.samples import CreditConfig, FeedbackSample, MassAccount, PressCredit

__all__ = ["CreditAssigner", "CreditConfig", "FeedbackSample", "MassAccount", "PressCredit"]

Answer = TypeVar("Answer")
_Entry = tuple[Any, ...]
"""What happened: a method of `Ledger`, and its arguments."""


class CreditAssigner:
    """Follows a session and keeps the list of samples it has given so far.

    Call the methods in the order of events. Steps have numbers that never fall; a step may be covered and
    shown again; between steps there may be gaps.
    """

    def __init__(self, config: CreditConfig) -> None:
        self.config = config
        self._features: dict[int, Features] = {}
        self._ledger = Ledger(config, self._features)
        # What happened since two marks, so that a press can be taken out of the past: all that happened until
        # `episode_begins` is called for the first time.
        self._settled = self._ledger.mark()
        self._before: list[_Entry] = []
        self._later = self._settled
        self._log: list[_Entry] = []
        self._known: set[int] = set()
        # Samples that were taken, of all so far.
        self._taken = 0

    @property
    def samples(self) -> Sequence[FeedbackSample]:
        """The samples that can still be taken back, in the order in which a model is to see them.

        Until `episode_begins` is called for the second time these are all samples so far.
        """
        return self._ledger.samples

    @property
    def account(self) -> MassAccount:
        """Where the mass of all presses went."""
        return self._ledger.account

    def take(self) -> Sequence[FeedbackSample]:
        """Return the samples that are new since the last call."""
        new = self._ledger.samples[self._taken - self._ledger.n_settled :]
        self._taken = self._n_samples
        return new

    def episode_begins(self) -> Sequence[FeedbackSample]:
        """Note that another episode begins: only presses of this one and the last one can be taken back.

        (A press is taken back in its own episode. That is reported in the next one where a key was held.)
        What goes before is not kept, so that a session of hours does not grow.

        Returns:
            The samples that can be taken back no more, in their order. They are in `samples` no longer.
            Samples that were not taken yet (`take`) stay.
        """
        self._settled, self._before = self._later, self._log
        self._later, self._log = self._ledger.mark(), []
        self._known = {entry[1] for entry in self._before if entry[0] is Ledger.add_press}
        self._ledger.forget_before(self._settled)
        return self._ledger.settle(min(self._settled.n_samples, self._taken))

    def step_shown(self, step: int, shown_ns: int, features: Features) -> None:
        """Note that a step came on screen, or came back after it had been covered.

        Args:
            step: its number, >= that of every step before.
            shown_ns: when; whatever was on screen until then is hidden by it.
            features: psi(s, a) of the step, shape (G,).
        """
        if step not in self._features:
            self._features[step] = features.copy()
        self._do(Ledger.step_shown, step, shown_ns)

    def step_hidden(self, step: int, hidden_ns: int) -> None:
        """Note that a step left the screen with nothing in its place: a pause, the end of an episode."""
        self._do(Ledger.step_hidden, step, hidden_ns)

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on, and has gone on since (`core.events.TimeGap`).

        What was on screen is hidden from `last_ns` on. No later press is credited to what was on screen
        before: what would have fallen there counts as `in_gaps`. A burst of presses ends there.
        """
        self._do(Ledger.interrupted, last_ns)

    def add_press(self, press: int, time_ns: int, value: float) -> PressCredit:
        """Share out a press.

        Args:
            press: its number; no other press of this episode and the last one has the same.
            time_ns: when.
            value: what it says, > 0 good, < 0 bad, 0 neither: then the label of its samples is 0.
        """
        if press in self._known:
            raise ValueError(f"press {press} was given already")
        given = self._do(Ledger.add_press, press, time_ns, value)
        self._known.add(press)
        return given

    def retract(self, press: int) -> None:
        """Take a press back: `samples` and `account` become those of a session without it.

        Afterwards a model has to be fitted again, to all that `episode_begins` returned and to `samples`;
        `take` goes on from their end.
        """
        n_entries = len(self._before) + len(self._log)
        self._before, self._log = _without(press, self._before), _without(press, self._log)
        if len(self._before) + len(self._log) == n_entries:
            raise ValueError(
                f"press {press} cannot be retracted: it was never given, retracted before, or made before "
                "the last episode"
            )
        self._ledger.go_back(self._settled)
        self._repeat(self._before)
        self._later = self._ledger.mark()
        self._repeat(self._log)
        self._taken = self._n_samples

    def finish(self, now_ns: int) -> None:
        """Give out the samples of all steps: the session is over, and no press can come any more."""
        self._do(Ledger.finish, now_ns)

    @property
    def _n_samples(self) -> int:
        """How many samples there were so far."""
        return self._ledger.n_settled + len(self._ledger.samples)

    def _do(self, event: Callable[..., Answer], *facts: Any) -> Answer:
        answer = event(self._ledger, *facts)
        self._log.append((event, *facts))  # only what succeeded can be repeated
        return answer

    def _repeat(self, entries: Sequence[_Entry]) -> None:
        for event, *facts in entries:
            event(self._ledger, *facts)


def _without(press: int, entries: list[_Entry]) -> list[_Entry]:
    """Return what happened without a press."""
    return [entry for entry in entries if entry[0] is not Ledger.add_press or entry[1] != press]
