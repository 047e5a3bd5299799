"""Several sources of human feedback as one: a human model and a weight per source (section 3.1).

f(R, H) of the paper is of one H. Several are folded into one: H = sum of w_s H_s / sd_s over the sources, w_s being what trust (or the scheme)
gives source s, and sd_s the spread of H_s among the actions of recent decisions, so that who presses more has no more say. The weight of
the folded H is its own spread. With one source that is the weight and the choice of one source, exactly (`docs/decisions/several-sources.md`).
"""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from core.combination.bootstrap_learning import BootstrapLearning, EpisodeReport, RankedPolicy
from core.combination.config import BootstrapConfig, EpisodeWeights, Scheme
from core.combination.human_learner import HumanLearner
from core.combination.schemes import best_action, worst_action
from core.combination.trust import Comparison, selection_probabilities
from core.combination.window import DecisionWindow, Values
from core.domain import Choices
from core.episode import CreditGiven
from core.feedback.samples import MassAccount, Sample

Floats = NDArray[np.float64]


class Crowd:
    """The human models of several sources, in the place of one `HumanLearner`."""

    def __init__(self, learners: list[HumanLearner], n_weights: int) -> None:
        """Begin without any press; `n_weights` is the length of v."""
        self.learners = learners
        self.factors = np.zeros(len(learners))
        """What each source's v is multiplied by in the folded one, shape (S,)."""
        self._n_weights = n_weights
        self._source_of: dict[int, int] = {}

    @property
    def knows_something(self) -> bool:
        """Whether any source prefers any action to another."""
        return any(learner.knows_something for learner in self.learners)

    @property
    def weights(self) -> Floats:
        """The folded v, shape (G,)."""
        folded = np.zeros(self._n_weights)
        for factor, learner in zip(self.factors, self.learners, strict=True):
            if learner.knows_something:
                folded += factor * learner.weights
        return folded

    @property
    def consistency(self) -> float:
        """How many standard errors better than chance the source that is foreseen best is foreseen."""
        return max(learner.consistency for learner in self.learners)

    @property
    def account(self) -> MassAccount:
        """Where the mass of everybody's presses went."""
        accounts = [dataclasses.astuple(learner.account) for learner in self.learners]
        return MassAccount(*(sum(column) for column in zip(*accounts, strict=True)))

    def fold(self, weights: list[float], window: DecisionWindow) -> float:
        """Set how the sources are folded, by their weights; return the weight of the folded H.

        Args:
            weights: w_s of each source; a source that knows nothing has no say.
            window: recent decisions, by which spreads are measured. Before there is any, each source counts by its own v.
        """
        for s, (weight, learner) in enumerate(zip(weights, self.learners, strict=True)):
            spread = 0.0
            if learner.knows_something:
                spread = window.spread(learner.weights) if len(window) else 1.0
            self.factors[s] = weight / spread if spread > 0 else 0.0
        return window.spread(self.weights) if len(window) else float(np.abs(self.factors).sum())

    def step_shown(self, step: int, features: Floats, time_ns: int) -> None:
        """Note that a step came on screen: everybody sees it."""
        for learner in self.learners:
            learner.step_shown(step, features, time_ns)

    def step_hidden(self, time_ns: int) -> None:
        """Note that the step on screen went off it."""
        for learner in self.learners:
            learner.step_hidden(time_ns)

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on, for everybody."""
        for learner in self.learners:
            learner.interrupted(last_ns)

    def learn_from_press(self, press: int, time_ns: int, value: float, person: int = 0) -> CreditGiven:
        """Learn from a press of one person; return how it was shared out.

        Raises:
            ValueError: nobody has this number.
        """
        if not 0 <= person < len(self.learners):
            raise ValueError(
                f"press {press} is by person {person}, but this agent listens to {len(self.learners)}: "
                "name the others in the protocol"
            )
        self._source_of[press] = person
        return self.learners[person].learn_from_press(press, time_ns, value)

    def learn_from_answer(self, samples: list[Sample], person: int = 0) -> None:
        """Learn what a person's answer to a question says."""
        self.learners[person].learn_from_answer(samples)

    def retract(self, press: int) -> None:
        """Forget a press as if it had never been made."""
        self.learners[self._source_of[press]].retract(press)

    def finish(self, time_ns: int) -> None:
        """Learn from the steps that still waited for presses."""
        for learner in self.learners:
            learner.finish(time_ns)

    def export(self) -> dict[str, list[float]]:
        """Return each source's model, its names ending in the person's number after the first."""
        return {
            name if person == 0 else f"{name}-{person}": values
            for person, learner in enumerate(self.learners)
            for name, values in learner.export().items()
        }

    def state_bytes(self) -> bytes:
        """Return all that decides about what is learned later, for fingerprints."""
        return self.factors.tobytes() + b"".join(learner.state_bytes() for learner in self.learners)

    def consistency_bytes(self) -> bytes:
        """Return all that decides about everybody's later consistency, for fingerprints."""
        return b"".join(learner.consistency_bytes() for learner in self.learners)


class CrowdTrust:
    """Bootstrap learning with a weight per source: the same rule for each, over the same top policies."""

    def __init__(
        self,
        config: BootstrapConfig,
        window: DecisionWindow,
        crowd: Crowd,
        human_values: Values,
        *,
        root_seed: int,
    ) -> None:
        """Begin without policies and without trust; arguments as in `BootstrapLearning`."""
        self.rules = [BootstrapLearning(config, window, root_seed=root_seed) for _ in crowd.learners]
        self._config = config
        self._window = window
        self._crowd = crowd
        self._human_values = human_values
        # Of the episode being watched, per source: decisions, agreed, agreed with the worst.
        self._counts = np.zeros((len(crowd.learners), 3), dtype=np.int64)

    @property
    def w_h(self) -> list[float]:
        """Weight of each source; 0 for one that knows nothing."""
        return [
            rule.w_h if learner.knows_something else 0.0
            for rule, learner in zip(self.rules, self._crowd.learners, strict=True)
        ]

    @property
    def ranked(self) -> list[RankedPolicy]:
        """The top policies, best first."""
        return self.rules[0].ranked

    def count(self, environment_action: int, choices: Choices) -> None:
        """Hold the environment's choice in a decision against every source."""
        n = len(choices.ruled_out)
        for s, learner in enumerate(self._crowd.learners):
            if learner.knows_something:
                values = self._human_values(choices.feedback_features, learner.weights)
                self._counts[s, 0] += 1
                self._counts[s, 1] += environment_action == best_action(values, choices.ruled_out, n)
                self._counts[s, 2] += environment_action == worst_action(values, choices.ruled_out, n)

    def record(self, report: EpisodeReport) -> None:
        """Take in an episode: rank its policy, revise every weight.

        Where nobody counted decision by decision, the policy is held against each source in the recent decisions.
        """
        for s, (rule, learner) in enumerate(zip(self.rules, self._crowd.learners, strict=True)):
            known = learner.weights if learner.knows_something else None
            comparison = None
            if self._counts[s, 0]:
                comparison = Comparison(*(int(count) for count in self._counts[s]))
            elif known is not None and len(self._window) and len(report.theta):
                comparison = self._window.compare(report.theta, known)
            rule.record(
                dataclasses.replace(report, comparison=comparison, consistency=learner.consistency), known
            )
        self._counts[:] = 0

    def probabilities(self) -> list[float]:
        """Return the probability of each top policy being played: by performance, and by its match to every source.

        p_i is proportional to pm_i max(0, 1 + sum over sources of w_s m_is).
        """
        ranked = self.ranked
        pulls = np.zeros(len(ranked))
        if self._config.symmetric:
            for rule, learner, w_s in zip(self.rules, self._crowd.learners, self.w_h, strict=True):
                if w_s:
                    known = [m for m in rule.matches(learner.weights) if m is not None]
                    usual = sum(known) / len(known) if known else 0.0
                    matches = [usual if m is None else m for m in rule.matches(learner.weights)]
                    pulls += w_s * np.array(matches)
        return selection_probabilities(
            [policy.performance for policy in ranked], [float(pull) for pull in pulls], 1.0
        )

    def draw(self, *, rng: np.random.Generator) -> RankedPolicy:
        """Return one of the top policies (there must be one), drawn by `probabilities`."""
        ranked, probabilities = self.ranked, self.probabilities()
        at = int(np.searchsorted(np.cumsum(probabilities), float(rng.random()), side="right"))
        return ranked[min(at, len(ranked) - 1)]

    def combine(self, scheme: Scheme, episode: int) -> EpisodeWeights:
        """Fold the sources by what the scheme gives each of them; return how the folded H is combined with R.

        Schemes that give H no weight in the choice (control sharing, reward shaping) hear all sources alike.
        """
        each = [scheme.weights(w_s, episode) for w_s in self.w_h]
        weights = [single.w_h for single in each]
        silent = not (any(weights) and self._crowd.knows_something)
        folded = self._crowd.fold([1.0] * len(each) if silent else weights, self._window)
        return each[0] if silent else dataclasses.replace(each[0], w_h=folded)

    def state_bytes(self) -> bytes:
        """Return all that decides about later choices, for fingerprints."""
        return b"".join(rule.state_bytes() for rule in self.rules)
