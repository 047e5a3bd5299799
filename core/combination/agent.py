"""The agent of augmented reinforcement learning: an environment learner, human models, and how far these are
trusted.
"""

import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from core.combination.asking import Asker, Question
from core.combination.config import (
    ENVIRONMENT_WEIGHTS,
    AgentConfig,
    EpisodeWeights,
    TrustRule,
    waits_for_feedback,
)
from core.combination.environment import environment_sides
from core.combination.listeners import ListenersTrust, new_listeners
from core.combination.preference import best_action, choose, takes_control, worst_action
from core.combination.ranking import EpisodeReport
from core.combination.schedule import EpisodesSoFar, NextEpisode, next_episode
from core.combination.sides import (
    Decision,
    EpisodeEnd,
    EpisodeOutcome,
    EpisodePolicy,
    EpisodeStart,
    HumanPreference,
)
from core.combination.window import DecisionWindow, Values, exact_values
from core.domain import Choices, Features
from core.events import CreditGiven
from core.feedback.config import CreditConfig
from core.learners.contract import EnvironmentLearner, StepwiseLearner
from core.numerics.arrays import in_order
from core.numerics.streams import stream, stream_seed
from core.numerics.tile_coding import Tiling, tile_values

__all__ = ["ArlAgent", "Decision", "EpisodeOutcome", "EpisodePolicy"]


class ArlAgent:
    """Chooses actions by environment and participant (Fig. 1), and learns from both.

    The agent "initially assumes the absence of human feedback" (section 3.1): until the human model knows
    something, the environment policy is played alone, w_h is 0 and nothing is compared. (`HumanOnly` alone
    does not wait: without an environment it has nothing else to go by.)
    """

    def __init__(
        self,
        learner: EnvironmentLearner | StepwiseLearner,
        config: AgentConfig,
        *,
        n_feedback_features: int,
        root_seed: int,
        feedback_tiles: Tiling | None = None,
        n_participants: int = 1,
        credits: Sequence[CreditConfig] = (),
        environment_values: Values | None = None,
        human_values: Values | None = None,
    ) -> None:
        """Begin without human feedback.

        Args:
            learner: proposes policies and learns from their performance, or learns at every step.
            config: scheme, trust, credit, human model.
            n_feedback_features: G, length of psi(s, a).
            root_seed: of the session; streams "policy", "explore", "share", "softmax" and "chance".
            feedback_tiles: what psi(s, a) means where it lists active tiles; None for plain features.
            n_participants: who may press, >= 1; each has a human model and a weight.
            credits: how each participant's presses become samples, one per participant; left out, the same
                for all: `config.credit`.
            environment_values: R of each action from feature rows (n, F) and theta (F,). Default:
                `exact_values`.
            human_values: H of each action from feature rows (n, G) and v (G,); a constant does not matter.
                Default: `exact_values`.

        Raises:
            ValueError: the rule of trust, or the scheme, needs another learner; or there is no participant.
        """
        _check_trust(config.bootstrap.trust)
        environment_values = environment_values or exact_values
        self.config = config
        self.learner = learner
        """The environment's learner; what plays for it in compiled code lets it learn there."""
        human_values = human_values or (tile_values(feedback_tiles) if feedback_tiles else exact_values)
        credits = credits or (config.credit,) * n_participants
        self.human = new_listeners(config.human_model, credits, n_feedback_features, feedback_tiles)
        self.window = DecisionWindow(config.bootstrap.window_decisions, environment_values, human_values)
        self.bootstrap = ListenersTrust(config.bootstrap, self.window, self.human, root_seed=root_seed)
        self.so_far = EpisodesSoFar()
        """The episodes that have begun."""
        self._environment, self._taught_by_presses = environment_sides(
            learner, environment_values, config.scheme
        )
        self._asker = Asker(config.asking)
        self._root_seed = root_seed
        self._human_values = human_values
        self._policy_values = environment_values
        # Of the decision last made: how the sides were combined, and H of each action.
        self._decided: tuple[EpisodeWeights, NDArray[np.float64]] = (ENVIRONMENT_WEIGHTS, np.zeros(0))
        self.last_values: tuple[NDArray[np.float64], NDArray[np.float64]] = (np.zeros(0), np.zeros(0))
        """R and H of each action of the decision last made, shape (n,) each; H is 0 while there is no human
        policy."""

    @property
    def trust(self) -> float:
        """What the rule of trust says of the participant (Eq. 4, 5); 0 while the human model knows nothing.

        Of several participants the mean; each one's is in `trust_of_sources`. Which weight an episode is
        played with is up to the scheme: `EpisodePolicy.episode_weights`.
        """
        return in_order(self.trust_of_sources) / len(self.trust_of_sources)

    @property
    def trust_of_sources(self) -> list[float]:
        """What the rule of trust says of each participant; 0 for one whose model knows nothing."""
        return self.bootstrap.w_h

    @property
    def next_episode(self) -> NextEpisode:
        """Which episode comes next, and which number the scheme's schedule is asked about."""
        return next_episode(self.config.scheme, self.so_far)

    def begin_episode(self, *, exploring: bool, watched: bool) -> EpisodePolicy:
        """Begin the next episode and return its policy.

        Args:
            exploring: play the learner's next proposal; otherwise one of the top policies, drawn by
                performance (and match), or a proposal while there is none.
            watched: the episode is shown to a participant.
        """
        policy = self.next_policy(exploring=exploring)
        self.so_far = self.so_far.after(watched=watched)
        if watched:
            self.human.episode_begins()
        return policy

    def next_policy(self, *, exploring: bool) -> EpisodePolicy:
        """Return the policy of the next episode without counting that episode; `exploring` as in
        `begin_episode`.
        """
        episode = self.next_episode.number
        self._asker.reset()
        handover_seed = stream_seed(self._root_seed, "share", episode) >> 1

        def draw() -> tuple[int, NDArray[np.float64]]:
            drawn = self.bootstrap.draw(rng=stream(self._root_seed, "policy", episode))
            return drawn.policy_id, drawn.theta

        started = self._environment.start_policy(
            EpisodeStart(
                episode=episode,
                draw=None if exploring or not self.bootstrap.ranked else draw,
                rng=stream(self._root_seed, "explore", episode),
            )
        )
        weights = self._weights()
        return EpisodePolicy(
            episode=episode,
            policy_id=started.policy_id,
            theta=started.theta,
            human_weights=self.human.weights,
            trust=self.trust,
            episode_weights=weights,
            handover_seed=handover_seed,
            exploring=started.proposed,
            chance_seed=stream_seed(self._root_seed, "softmax", episode) >> 1,
        )

    def choose(self, choices: Choices, policy: EpisodePolicy, *, step: int) -> Decision:
        """Decide one step of a watched episode, with the human model as it is now.

        Args:
            choices: the actions.
            policy: from `begin_episode`; its scheme's weights hold for the whole episode.
            step: number of the decision in the episode, from 0.
        """
        n = len(choices.ruled_out)
        self.window.remember(choices)
        env_values = self._environment.values(choices, policy.theta)
        environment_action = best_action(env_values, choices.ruled_out, n)
        human_values, human_action, human_worst_action = np.zeros(n), -1, -1
        of_participants: tuple[tuple[int, int], ...] = ()
        handed_over = False
        if self.human.knows_something:
            human_values = self._human_values(choices.feedback_features, self.human.weights)
            human_action = best_action(human_values, choices.ruled_out, n)
            human_worst_action = worst_action(human_values, choices.ruled_out, n)
            of_participants = self.human.preferred_by_each(
                choices, self._human_values, (human_action, human_worst_action)
            )
            handed_over = takes_control(policy.handover_seed, step, policy.episode_weights.handover)
        preferred = human_action if handed_over else self._prefer(env_values, human_values, choices, policy)
        human = HumanPreference(human_values, policy.episode_weights, policy.chance_seed, step, handed_over)
        action = self._environment.act(env_values, choices, preferred, human)
        self._decided = (policy.episode_weights, human_values)
        self.last_values = (env_values, human_values)
        return Decision(action, environment_action, human_action, human_worst_action, of_participants)

    def learn_from_step(
        self, choices: Choices, action: int, reward: float, *, watched_step: int = -1
    ) -> None:
        """Take in the action of the decision last made, whichever side chose it, and the reward of its step.

        `watched_step` is the step's number among all watched ones of the session, by which presses name it;
        -1 of a step that is not watched.
        Reward shaping adds beta H(s, a) to the reward, H without its constant; Q augmentation gives the
        learner beta H.
        """
        weights, human_values = self._decided
        h = float(human_values[action])
        self._environment.took(
            choices,
            action,
            reward,
            shaping=weights.shaping * h,
            augmentation=weights.augmentation * h,
            watched_step=watched_step,
        )

    def learn_from_domain(self, policy: EpisodePolicy, played: EpisodeOutcome) -> None:
        """Take in how an episode went: the learner learns of its proposal, policies are ranked, w_h is
        revised.

        Args:
            policy: from `begin_episode`.
            played: the outcome, with the agreement that the player has counted.
        """
        self._environment.end_episode(
            EpisodeEnd(
                policy_id=policy.policy_id,
                proposed=policy.exploring,
                performance=played.performance,
                terminated=played.ended == "termination",
                time=played.time,
            )
        )
        report = EpisodeReport(
            policy_id=policy.policy_id,
            theta=policy.theta,
            performance=played.performance,
            truncated=played.ended == "truncation",
            agreement=played.agreement,
        )
        self.bootstrap.record(report, played.with_each)

    def step_shown(self, step: int, features: Features, time_ns: int) -> None:
        """Note that a watched step with feedback features psi, shape (G,), came on screen."""
        self.human.step_shown(step, features, time_ns)

    def step_hidden(self, time_ns: int) -> None:
        """Note that the step on screen went off it."""
        self.human.step_hidden(time_ns)

    def interrupted(self, last_ns: int) -> None:
        """Note that the program stood still from `last_ns` on: no later press is about what was on screen
        before.
        """
        self.human.interrupted(last_ns)

    def learn_from_press(self, press: int, time_ns: int, value: float, participant: int = 0) -> CreditGiven:
        """Learn from a participant's press, value > 0 good, < 0 bad; return how it was shared out."""
        given = self.human.learn_from_press(press, time_ns, value, participant)
        if self._taught_by_presses is not None:
            self._taught_by_presses.learn_from_credit(given, value)
        return given

    def question(self, choices: Choices) -> Question | None:
        """Return a choice to pose at this decision of a watched episode; None where there is nothing worth
        asking.

        The committee are the top policies. A learner that changes at every step has none, and asks by its
        values of now (`docs/decisions/asking.md`).
        """
        if self.config.asking.per_episode == 0:
            return None
        if self._environment.kind == "stepwise":
            values = self._environment.values(choices, np.empty(0))
            return self._asker.question_by_values(choices, values)
        committee = [policy.theta for policy in self.bootstrap.ranked if len(policy.theta)]
        if len(committee) < 2:
            return None
        actions = [
            best_action(
                self._policy_values(choices.features, theta), choices.ruled_out, len(choices.ruled_out)
            )
            for theta in committee
        ]
        return self._asker.question(choices, actions, self.bootstrap.probabilities())

    def learn_from_answer(self, question: Question, chosen: int, participant: int = 0) -> None:
        """Learn which of a question's options a participant has chosen."""
        self.human.learn_from_answer(question, chosen, participant)

    def retract(self, press: int) -> None:
        """Forget a press as if it had never been made."""
        self.human.retract(press)

    def finish(self, time_ns: int) -> None:
        """Learn from the steps that still waited for presses: the session is over, and none can follow."""
        self.human.finish(time_ns)

    def final_policy(self) -> EpisodePolicy:
        """Return what the agent would play to be judged, as its next episode (`next_episode`).

        That is its best policy, its human models, and the weights its scheme gives them in that episode.
        Without any policy the environment has no say (theta = 0).
        """
        episode = self.next_episode.number
        ranked = self.bootstrap.ranked
        best = ranked[0] if ranked else None
        weights = self._weights()
        return EpisodePolicy(
            episode=episode,
            policy_id=best.policy_id if best else -1,
            theta=best.theta if best else self._environment.no_policy(),
            human_weights=self.human.weights,
            trust=self.trust,
            episode_weights=weights,
            handover_seed=stream_seed(self._root_seed, "share", episode) >> 1,
            exploring=False,
        )

    def export(self) -> dict[str, list[float]]:
        """Return the weight vectors by name: the human model's, and those of the top policies, best first."""
        vectors = {**self.human.export(), "trust": self.trust_of_sources, **self._environment.export()}
        for place, policy in enumerate(self.bootstrap.ranked):
            if len(policy.theta):
                vectors[f"policy-{place}"] = policy.theta.tolist()
        return vectors

    def digest(self) -> str:
        """Return SHA-256 over everything learned, hex: learner, top policies, human model, w_h.

        How consistent the presses were is part of it where trust goes by it, and only there: sessions under
        other rules keep the fingerprints that they were recorded with.
        """
        parts = [self._environment.state_digest(), self.bootstrap.state_bytes(), self.human.state_bytes()]
        if self.config.bootstrap.trust.needs.consistency:
            parts.append(self.human.consistency_bytes())
        digest = hashlib.sha256()
        for part in parts:
            digest.update(len(part).to_bytes(8, "little"))
            digest.update(part)
        return digest.hexdigest()

    def _weights(self) -> EpisodeWeights:
        if not self.human.knows_something and waits_for_feedback(self.config.scheme):
            return ENVIRONMENT_WEIGHTS
        return self.bootstrap.combine(self.config.scheme, self.next_episode.scheduled)

    def _prefer(
        self,
        env_values: NDArray[np.float64],
        human_values: NDArray[np.float64],
        choices: Choices,
        policy: EpisodePolicy,
    ) -> int:
        """Return what both sides together prefer; -1 where the participant has no say."""
        weights = policy.episode_weights
        if weights.w_h == 0.0:
            return -1
        return choose(
            env_values,
            human_values,
            choices.ruled_out,
            len(env_values),
            weights.form,
            weights.w_r,
            weights.w_h,
        )


def _check_trust(rule: TrustRule) -> None:
    """Refuse a rule that needs several learners."""
    if rule.needs.side_by_side:
        raise ValueError(
            "this rule of trust needs learners side by side, and an agent has one: choose another one, or "
            f"play compiled Keepaway (core.keepaway.arl_autoplay); got {rule}"
        )
