"""One participant: their presses, the credit these get, and the model learned from them."""

import copy
import struct

import numpy as np
from numpy.typing import NDArray

from core.combination.asking import Question, samples_of
from core.domain import Features
from core.events import CreditGiven
from core.feedback.assigner import CreditAssigner
from core.feedback.samples import CreditConfig, FeedbackSample, MassAccount
from core.learners.consistency import Consistency
from core.learners.human_config import HumanModelConfig
from core.learners.human_reward import HumanRewardModel
from core.learners.human_tiles import HumanTileModel, human_model
from core.numerics.tile_coding import Tiling


class HumanLearner:
    """Keeps assigner and model in step: after every call the model has seen exactly the assigner's samples,
    those of earlier episodes among them.
    """

    def __init__(
        self, credit: CreditConfig, model: HumanModelConfig, n_features: int, *, tiles: Tiling | None = None
    ) -> None:
        """Begin without any press.

        Args:
            credit: how presses become samples.
            model: how samples become H.
            n_features: length of psi(s, a).
            tiles: what psi(s, a) indexes where it lists active tiles; None for plain features.
        """
        self._assigner = CreditAssigner(credit)
        self._now = _Learned(human_model(model, n_features, tiles))
        # What was learned from the presses of earlier episodes, which cannot be taken back any more. After a
        # retraction learning goes on from here, so that no sample of long ago has to be kept.
        self._settled = copy.deepcopy(self._now)
        self._on_screen = -1
        # What was learned from answers to questions, beside the assigner's samples. After a retraction they
        # are learned after all samples: all of them are kept.
        self._answers: list[FeedbackSample] = []
        self._n_answers = 0

    @property
    def consistency(self) -> float:
        """How many standard errors better than chance the model foresaw the presses
        (`core.learners.consistency`).
        """
        return self._now.consistency.score

    @property
    def model(self) -> HumanRewardModel | HumanTileModel:
        """The model behind `weights`."""
        return self._now.model

    @property
    def account(self) -> MassAccount:
        """Where the mass of all presses went."""
        return self._assigner.account

    @property
    def knows_something(self) -> bool:
        """Whether the model prefers any action to another."""
        return self._now.model.knows_something

    @property
    def weights(self) -> NDArray[np.float64]:
        """v, shape (G,), in the features' own units; zeros while nothing is known."""
        return self._now.model.weights

    def episode_begins(self) -> None:
        """Note that another watched episode begins: earlier presses than the last one's are settled."""
        for sample in self._assigner.episode_begins():
            self._settled.learn_from(sample)

    def step_shown(self, step: int, features: Features, time_ns: int) -> None:
        """Note that a step came on screen; features psi(s, a), shape (G,).

        NaN features are those of a step of which a recording does not tell what it led to: it takes its
        credit, and nothing is learned from it.
        """
        self._assigner.step_shown(step, time_ns, features)
        self._on_screen = step
        self._learn()

    def step_hidden(self, time_ns: int) -> None:
        """Note that the step on screen, if there is one, went off it."""
        if self._on_screen >= 0:
            self._assigner.step_hidden(self._on_screen, time_ns)
            self._on_screen = -1
            self._learn()

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on: no later press is about what was on screen
        before.
        """
        self._assigner.interrupted(last_ns)
        self._on_screen = -1
        self._learn()

    def learn_from_press(self, press: int, time_ns: int, value: float, participant: int = 0) -> CreditGiven:
        """Learn from a press, value > 0 good, < 0 bad, whichever participant made it; return how it was
        shared out.
        """
        given = self._assigner.add_press(press, time_ns, value)
        self._learn()
        return CreditGiven(
            press=press,
            steps=list(given.steps),
            shares=list(given.shares),
            before_first=given.before_first,
            in_gaps=given.in_gaps,
            too_late=given.too_late,
            merged_into=given.merged_into,
        )

    def learn_from_answer(self, question: Question, chosen: int, participant: int = 0) -> None:
        """Learn which of a question's options was chosen, by whichever participant
        (`core.combination.asking.samples_of`).

        Raises:
            ValueError: `chosen` is not an option.
        """
        samples = samples_of(question, chosen, number=self._n_answers)
        self._n_answers += 1
        self._answers.extend(samples)
        for sample in samples:
            self._now.learn_from(sample)

    def retract(self, press: int) -> None:
        """Make the model one that never saw the press."""
        self._assigner.retract(press)
        self._now = copy.deepcopy(self._settled)
        for sample in (*self._assigner.samples, *self._answers):
            self._now.learn_from(sample)

    def finish(self, time_ns: int) -> None:
        """Learn from the steps that still waited for presses: the session is over."""
        self._assigner.finish(time_ns)
        self._learn()

    def export(self) -> dict[str, list[float]]:
        """Return the model's weights by name, for a recording's last line."""
        return self._now.model.export()

    def state_bytes(self) -> bytes:
        """Return all that decides about what is learned later, for fingerprints."""
        account = self.account
        return self._now.model.state_bytes() + struct.pack(
            "<qqdddd",
            account.presses,
            account.merged,
            account.credited,
            account.before_first,
            account.in_gaps,
            account.too_late,
        )

    def consistency_bytes(self) -> bytes:
        """Return all that decides about later `consistency`, for fingerprints of agents whose trust goes by
        it.
        """
        return self._now.consistency.state_bytes()

    def _learn(self) -> None:
        for sample in self._assigner.take():
            self._now.learn_from(sample)


class _Learned:
    """A model, and how well it foresaw what it learned from."""

    def __init__(self, model: HumanRewardModel | HumanTileModel) -> None:
        self.model = model
        self.consistency = Consistency()

    def learn_from(self, sample: FeedbackSample) -> None:
        """Predict the sample, then learn from it."""
        if _tells(sample):
            prediction = self.model.predict(sample.features[None, :])[0]
            self.consistency.note(float(prediction), sample.label, sample.weight)
            self.model.add(sample)


def _tells(sample: FeedbackSample) -> bool:
    """Return whether the step's features are known: an imported log may not show what a step led to."""
    return bool(np.isfinite(sample.features).all())
