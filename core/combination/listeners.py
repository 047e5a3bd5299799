"""The participants whom an agent listens to, one or several: a human model and a weight for each (section
3.1).

f(R, H) of the paper is of one H. With one participant that is their model's. Those of several are folded into
one: H = sum of w_s H_s / sd_s over the participants, w_s being what trust (or the scheme) gives participant
s, and sd_s the spread of H_s among the actions of recent decisions, so that who presses more has no more say.
The weight of the folded H is its own spread. If only one of several presses, choices are those of that one
(`docs/decisions/several-sources.md`).
"""

import dataclasses
from collections.abc import Sequence
from functools import reduce
from operator import add

import numpy as np

from core.combination.agreement import Agreement
from core.combination.asking import Question
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import BootstrapConfig, EpisodeWeights, Scheme
from core.combination.human_learner import HumanLearner
from core.combination.preference import best_action, worst_action
from core.combination.ranking import EpisodeReport, RankedPolicy, draw_policy
from core.combination.trust.measures import selection_probabilities
from core.combination.window import DecisionWindow, Values
from core.domain import Choices, Features
from core.events import CreditGiven
from core.feedback.config import CreditConfig
from core.feedback.samples import MassAccount
from core.learners.human_config import HumanModelConfig
from core.numerics.arrays import Floats, in_order
from core.numerics.tile_coding import Tiling


class Listeners:
    """The human models of one or several participants, and the one H that they make together."""

    def __init__(self, learners: Sequence[HumanLearner], n_weights: int) -> None:
        """Begin without any press.

        Args:
            learners: one per participant, at least one; participants count from 0.
            n_weights: length of v.
        """
        if not learners:
            raise ValueError("an agent listens to at least one participant, got 0")
        self.learners = tuple(learners)
        self.factors = np.zeros(0 if self.alone else len(learners))
        """What each participant's v is multiplied by in the folded one, shape (n,); of one alone nothing is
        folded, shape (0,)."""
        self._n_weights = n_weights
        # Who made a press of this episode, and of the last one: others cannot be taken back.
        self._participant_of: dict[int, int] = {}
        self._participant_before: dict[int, int] = {}

    @property
    def alone(self) -> bool:
        """Whether there is one participant, whose model is H as it stands."""
        return len(self.learners) == 1

    @property
    def knows_something(self) -> bool:
        """Whether any participant's model prefers any action to another."""
        return any(learner.knows_something for learner in self.learners)

    @property
    def weights(self) -> Floats:
        """V of H, shape (G,); zeros while nothing is known."""
        if self.alone:
            return self.learners[0].weights
        folded = np.zeros(self._n_weights)
        for factor, learner in zip(self.factors, self.learners, strict=True):
            if learner.knows_something:
                folded += factor * learner.weights
        return folded

    @property
    def consistency(self) -> float:
        """How many standard errors better than chance the participant who is foreseen best is foreseen."""
        return max(learner.consistency for learner in self.learners)

    @property
    def account(self) -> MassAccount:
        """Where the mass of all participants' presses went."""
        # One by one, as `in_order` does, and counts stay whole numbers.
        accounts = [dataclasses.astuple(learner.account) for learner in self.learners]
        return MassAccount(*(reduce(add, column) for column in zip(*accounts, strict=True)))

    def fold(self, weights: Sequence[float], window: DecisionWindow) -> float:
        """Set how several participants are folded, by their weights; return the weight of the folded H.

        Args:
            weights: w_s of each participant; one whose model knows nothing has no say.
            window: recent decisions, by which spreads are measured. Before there is any, each counts by its
                own v.
        """
        if self.alone:
            return weights[0]
        for s, (weight, learner) in enumerate(zip(weights, self.learners, strict=True)):
            spread = 0.0
            if learner.knows_something:
                spread = window.spread(learner.weights) if len(window) else 1.0
            self.factors[s] = weight / spread if spread > 0 else 0.0
        return window.spread(self.weights) if len(window) else float(np.abs(self.factors).sum())

    def preferred_by_each(
        self, choices: Choices, values: Values, together: tuple[int, int]
    ) -> tuple[tuple[int, int], ...]:
        """Return each participant's best and worst action of a decision; -1 for one whose model knows
        nothing.

        Args:
            choices: the decision.
            values: H of each action from feature rows and v.
            together: best and worst action by the H of all: of one participant, their own.
        """
        if self.alone:
            return (together,)
        n = len(choices.ruled_out)
        preferred = []
        for learner in self.learners:
            best, worst = -1, -1
            if learner.knows_something:
                human = values(choices.feedback_features, learner.weights)
                best, worst = (
                    best_action(human, choices.ruled_out, n),
                    worst_action(human, choices.ruled_out, n),
                )
            preferred.append((best, worst))
        return tuple(preferred)

    def episode_begins(self) -> None:
        """Note that another watched episode begins: earlier presses than the last one's are settled."""
        self._participant_before, self._participant_of = self._participant_of, {}
        for learner in self.learners:
            learner.episode_begins()

    def step_shown(self, step: int, features: Features, time_ns: int) -> None:
        """Note that a step came on screen: all participants see it."""
        for learner in self.learners:
            learner.step_shown(step, features, time_ns)

    def step_hidden(self, time_ns: int) -> None:
        """Note that the step on screen went off it."""
        for learner in self.learners:
            learner.step_hidden(time_ns)

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on, for all participants."""
        for learner in self.learners:
            learner.interrupted(last_ns)

    def learn_from_press(self, press: int, time_ns: int, value: float, participant: int = 0) -> CreditGiven:
        """Learn from a press of one participant; return how it was shared out.

        Raises:
            ValueError: there is no participant of this number.
        """
        if not 0 <= participant < len(self.learners):
            raise ValueError(
                f"press {press} is by participant {participant}, but this agent listens to "
                f"{len(self.learners)}, counted from 0: name the people in the protocol"
            )
        self._participant_of[press] = participant
        return self.learners[participant].learn_from_press(press, time_ns, value)

    def learn_from_answer(self, question: Question, chosen: int, participant: int = 0) -> None:
        """Learn which of a question's options a participant has chosen."""
        self.learners[participant].learn_from_answer(question, chosen)

    def retract(self, press: int) -> None:
        """Forget a press as if it had never been made.

        Raises:
            ValueError: it was never made, taken back before, or made before the last episode.
        """
        participant = self._participant_of.get(press, self._participant_before.get(press, 0))
        self.learners[participant].retract(press)

    def finish(self, time_ns: int) -> None:
        """Learn from the steps that still waited for presses."""
        for learner in self.learners:
            learner.finish(time_ns)

    def export(self) -> dict[str, list[float]]:
        """Return each participant's model, its names ending in the participant's number after the first."""
        return {
            name if participant == 0 else f"{name}-{participant}": values
            for participant, learner in enumerate(self.learners)
            for name, values in learner.export().items()
        }

    def state_bytes(self) -> bytes:
        """Return all that decides about what is learned later, for fingerprints."""
        return self.factors.tobytes() + b"".join(learner.state_bytes() for learner in self.learners)

    def consistency_bytes(self) -> bytes:
        """Return all that decides about all participants' later consistency, for fingerprints."""
        return b"".join(learner.consistency_bytes() for learner in self.learners)


def new_listeners(
    model: HumanModelConfig, credits: Sequence[CreditConfig], n_features: int, tiles: Tiling | None
) -> Listeners:
    """Return the human models of participants who have not pressed yet.

    Args:
        model: the same for all.
        credits: how each participant's presses become samples, one per participant.
        n_features: G, length of psi(s, a).
        tiles: what psi(s, a) means where it lists active tiles; None for plain features.
    """
    models = [HumanLearner(credit, model, n_features, tiles=tiles) for credit in credits]
    return Listeners(models, tiles.n_weights if tiles else n_features)


class ListenersTrust:
    """Bootstrap learning with a weight per participant: the same rule for each, over the same top
    policies.
    """

    def __init__(
        self,
        config: BootstrapConfig,
        window: DecisionWindow,
        listeners: Listeners,
        *,
        root_seed: int,
    ) -> None:
        """Begin without policies and without trust; arguments as in `BootstrapLearning`."""
        self.rules = [BootstrapLearning(config, window, root_seed=root_seed) for _ in listeners.learners]
        self._window = window
        self._listeners = listeners

    @property
    def w_h(self) -> list[float]:
        """Weight of each participant; 0 for one whose model knows nothing."""
        return [
            rule.w_h if learner.knows_something else 0.0
            for rule, learner in zip(self.rules, self._listeners.learners, strict=True)
        ]

    @property
    def ranked(self) -> list[RankedPolicy]:
        """The top policies, best first."""
        return self.rules[0].ranked

    def record(self, report: EpisodeReport, with_each: Sequence[Agreement | None]) -> None:
        """Take in an episode: rank its policy, revise every weight.

        Args:
            report: the episode, with the agreement of its policy with H.
            with_each: agreement with each participant's own model; empty where nobody counted it. With one
                participant that is the report's. With several a policy that was not compared with a
                participant's model while it was played is compared with it in recent decisions.
        """
        several = not self._listeners.alone
        for s, (rule, learner) in enumerate(zip(self.rules, self._listeners.learners, strict=True)):
            known = learner.weights if learner.knows_something else None
            agreement = report.agreement
            if several:
                agreement = with_each[s] if with_each else None
                if agreement is None and known is not None and len(self._window) and len(report.theta):
                    agreement = self._window.compare(report.theta, known)
            rule.record(
                dataclasses.replace(report, agreement=agreement, consistency=learner.consistency), known
            )

    def probabilities(self) -> list[float]:
        """Return the probability of each top policy being played: by performance, and by its match to every
        participant.

        p_i is proportional to pm_i max(0, 1 + sum over participants of w_s m_is).
        """
        ranked = self.ranked
        pull = np.zeros(len(ranked))
        for rule, learner in zip(self.rules, self._listeners.learners, strict=True):
            known = learner.weights if learner.knows_something else None
            # One of several who has taken every press back has no say. (One alone keeps it: recorded sessions
            # go by that.)
            if known is not None or self._listeners.alone:
                pull += rule.pulls(known)
        return selection_probabilities([policy.performance for policy in ranked], pull.tolist())

    def draw(self, *, rng: np.random.Generator) -> RankedPolicy:
        """Return one of the top policies (there must be one), drawn by `probabilities`."""
        return draw_policy(self.ranked, self.probabilities(), rng=rng)

    def combine(self, scheme: Scheme, episode: int) -> EpisodeWeights:
        """Fold the participants by what the scheme gives each of them; return how H is combined with R.

        Schemes that give H no weight in the choice (control sharing, reward shaping) listen to all
        participants alike.
        """
        # Of one alone -0.0 is 0.0, as it stands in recordings.
        w_h = [in_order(self.w_h)] if self._listeners.alone else self.w_h
        each = [scheme.episode_weights(w_s, episode) for w_s in w_h]
        weights = [single.w_h for single in each]
        silent = not (any(weights) and self._listeners.knows_something)
        folded = self._listeners.fold([1.0] * len(each) if silent else weights, self._window)
        return each[0] if silent else dataclasses.replace(each[0], w_h=folded)

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        return b"".join(rule.state_bytes() for rule in self.rules)
