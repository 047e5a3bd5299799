"""Whole episodes of keepers that learn from their environment and from a simulated participant, for
experiments.

An episode is one call of compiled code, presses included; what happens once per episode is done by the
classes of a session: bootstrap learning, the weights of the scheme, the participant's budget and fatigue.
"""

import hashlib
import math
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import (
    ENVIRONMENT_WEIGHTS,
    AgentConfig,
    Exponential,
    Linear,
    waits_for_feedback,
)
from core.combination.preference import kernel_weights
from core.combination.ranking import EpisodeReport
from core.combination.schedule import EpisodesSoFar, NextEpisode, next_episode
from core.combination.tally import agreement_of
from core.feedback.compiled_credit import credit_rule
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import GammaDelay
from core.feedback.keys import KeyConfig
from core.feedback.samples import MassAccount
from core.feedback.trainers import SimulatedTrainer
from core.keepaway.arl_cycles import (
    BEFORE_FIRST,
    CREDITED,
    EPISODE_STEPS,
    IN_GAPS,
    NEEDS_DRAWS,
    PRESSES,
    STOPPED,
    Mix,
    Span,
    new_timeline,
    play,
)
from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.participant import Judge, new_judge, watch_episode, with_more_draws
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_NS, CYCLE_S, OUT, SESSION_CYCLE_LIMIT, KeepawayConfig
from core.keepaway.presses import LOST, MADE, new_presses, renew_budget
from core.keepaway.simulator.match import CYCLE, END, new_match, open_streams
from core.learners.human_config import TileModel
from core.learners.human_sets import consistency, new_human_set
from core.learners.sarsa import SarsaConfig, new_sarsa
from core.numerics.clock import NS_PER_S
from core.numerics.compiled import specialised
from core.numerics.streams import stream_seed

KEEPAWAY_AGENT = AgentConfig(credit=CreditConfig(delay=GammaDelay()), human_model=TileModel())
"""Eq. 3, Eq. 4, credit by the paper's density, and a human model over tiles."""

NO_PRESSES = KeepawayPersonConfig(trainer=TrainerConfig(press_probability=0.0, max_presses=0))
"""A participant who never presses a key."""
NO_WEIGHTS: tuple[float, ...] = (0.0, 0.0, 0.0)
"""w_h of the sets of learners side by side while nothing is known, and where there is one set."""
SHORTEST_EPISODE_S = 0.5
"""Takers need longer than this to reach the ball."""


class ArlKeepawayConfig(msgspec.Struct, frozen=True, kw_only=True):
    """Keepers that learn from environment and person, and who the person is."""

    task: KeepawayConfig = KeepawayConfig()
    sarsa: SarsaConfig = SarsaConfig()
    agent: AgentConfig = KEEPAWAY_AGENT
    """`human_model` has to be a `TileModel`; credit is individual and merges no bursts; matches are measured
    as played."""
    person: KeepawayPersonConfig | None = KeepawayPersonConfig()
    """None: nobody watches."""
    keys: KeyConfig = KeyConfig(max_presses_per_episode=2)
    """At most two presses per episode (section 4)."""
    pause_s: float = 2.0
    """How long the last picture of an episode stays before the next kick-off; late presses still count
    then."""
    n_tilings: int = 32

    def __post_init__(self) -> None:
        if not isinstance(self.agent.human_model, TileModel):
            raise TypeError(f"compiled play needs human_model=TileModel(...), got {self.agent.human_model}")
        if self.agent.credit.scheme != "individual" or self.agent.credit.merge_within_s:
            raise ValueError(
                "compiled play credits each press by itself: scheme='individual' and merge_within_s=0, got "
                f"{self.agent.credit}; play a session for others"
            )
        if self.agent.scheme.acts_on != "choice":
            raise ValueError(
                f"compiled play lets the participant act on choices, not on Sarsa's learning: got "
                f"{self.agent.scheme}"
            )
        trust = self.agent.bootstrap.trust
        if trust.needs.window:
            raise ValueError(
                f"compiled play keeps no window of decisions: measure as played and give chance, got {trust}"
            )
        if trust.needs.side_by_side:
            self._check_side_by_side()
        if not (math.isfinite(self.pause_s) and self.pause_s >= 0):
            raise ValueError(f"pause_s is >= 0 seconds, got {self.pause_s}")
        self._check_bursts()

    def _check_side_by_side(self) -> None:
        """Refuse what learners side by side cannot do."""
        if not isinstance(self.agent.scheme, Linear | Exponential):
            raise TypeError(
                f"learners side by side need a scheme that goes by trust, linear or exponential: got "
                f"{self.agent.scheme}"
            )
        if self.sarsa.trace_decay or self.sarsa.shared_weights:
            raise ValueError(
                "learners side by side learn without traces (trace_decay=0), each with weights of its own "
                f"(shared_weights=False): got {self.sarsa}"
            )

    def _check_bursts(self) -> None:
        """Refuse presses that the gate could take for a held key: learning is never undone here."""
        trainer = self.person.trainer if self.person else None
        shortest_ms = 2 * self.keys.repeat_interval_ms
        if trainer and trainer.burst_rate > 0 and trainer.burst_interval_s * 1000 < shortest_ms:
            raise ValueError(
                f"presses of a burst are at least {shortest_ms} ms apart, got {trainer.burst_interval_s} s"
            )


@dataclass(frozen=True, slots=True)
class MadePress:
    """A press of the simulated participant."""

    time_ns: int
    value: float
    """1.0 good, -1.0 bad."""
    step: int
    """The step it was meant for."""
    deliberate: bool
    """Wrong on purpose."""
    accepted: bool
    """Whether it counted."""


@dataclass(frozen=True, slots=True, eq=False)
class ArlEpisode:
    """What became of an episode."""

    cycles: int
    """Duration in cycles of 100 ms."""
    out: bool
    """The ball left the region (else a taker took it)."""
    truncated: bool
    """The episode was stopped at the limit of cycles."""
    start_ns: int
    """When it started, in the session's time (pauses included)."""
    trust: float
    """What the rule of trust said of the participant before the episode: what the scheme was given."""
    weight: float
    """Weight w_h of the participant's values that the scheme used in this episode."""
    steps: int
    """Decisions of all keepers."""
    agreement: Agreement | None
    """Of the environment's best options with the human model's, in the decisions made while it knew
    something; None where there was none."""
    presses: tuple[MadePress, ...]
    """Presses made until the next kick-off, the refused ones too."""

    @property
    def duration_s(self) -> float:
        """Duration in seconds: the performance measure."""
        return self.cycles * CYCLE_S

    @property
    def accepted(self) -> int:
        """Presses that counted."""
        return sum(press.accepted for press in self.presses)


class ArlAutoplay:
    """A session of Keepaway without a screen, played in whole episodes. Its clock is that of the match."""

    def __init__(self, config: ArlKeepawayConfig, root_seed: int, *path: str | int) -> None:
        """Set up the match whose streams are named by `path`; the participant's streams follow from it,
        too.
        """
        task, delay = config.task, config.agent.credit.delay
        self.config = config
        self.streams = open_streams(root_seed, *path)
        self.match = new_match(task, self.streams)
        coder = keepaway_tiles(task, config.n_tilings)
        self._w_h_of = config.agent.bootstrap.trust.needs.side_by_side
        """w_h of each set of learners side by side; empty: one set."""
        n_learners = task.n_keepers * max(1, len(self._w_h_of))
        self.sarsa = new_sarsa(config.sarsa, coder, n_learners, task.n_actions)
        """One learner per keeper; where they learn side by side one set of them after the other, in the order
        of the rule."""
        model = config.agent.human_model
        assert isinstance(model, TileModel), "checked by the configuration"
        self.human = new_human_set(model, coder, task.n_keepers, task.n_actions)
        self._seed = stream_seed(root_seed, *path, "session")
        self.bootstrap = BootstrapLearning(config.agent.bootstrap, None, root_seed=self._seed)
        self._rules = task.rules()
        self._rule = credit_rule(delay)
        places = (math.ceil(self._rule.horizon_s / CYCLE_S) + 3) * task.n_keepers
        self._timeline = new_timeline(places, len(coder.low), task.n_actions)
        person = config.person or NO_PRESSES
        self._trainer = SimulatedTrainer(person.trainer, root_seed=self._seed)
        self._judge = new_judge(person, self.match)
        self._presses = new_presses(config.keys, _room(config))
        self._so_far = EpisodesSoFar()
        self._start_ns = 0
        self._play = specialised(play, *self._arguments(self._mix(), self._judge, False))

    @property
    def trust(self) -> float:
        """What the rule of trust says of the participant; 0 while the human model knows nothing."""
        return self.bootstrap.w_h if self.human.samples[0] else 0.0

    @property
    def account(self) -> MassAccount:
        """Where the mass of all presses went."""
        masses = self._timeline.masses
        return MassAccount(
            presses=int(masses[PRESSES]),
            credited=float(masses[CREDITED]),
            before_first=float(masses[BEFORE_FIRST]),
            in_gaps=float(masses[IN_GAPS]),
        )

    def play_episode(self) -> ArlEpisode:
        """Play the next episode and the pause after it."""
        mix, trust, judge, start_ns = self._mix(), self.trust, self._watch(), self._start_ns
        counts, status = self._timeline.counts, self.match.status
        counts[EPISODE_STEPS] = 0
        self._timeline.tally[:] = 0
        anew = bool(status[CYCLE] > 0)
        reason = self._play(*self._arguments(mix, judge, anew))
        while reason == NEEDS_DRAWS:
            judge = with_more_draws(judge, self._trainer)
            reason = self._play(*self._arguments(mix, judge, False))
        if self._presses.counts[LOST]:
            raise ValueError(f"too many presses wait at once: shorten the delay of {self.config.person}")
        episode = ArlEpisode(
            cycles=int(status[CYCLE]),
            out=bool(status[END] == OUT),
            truncated=reason == STOPPED,
            start_ns=start_ns,
            trust=trust,
            weight=mix.weights.w_h,
            steps=int(counts[EPISODE_STEPS]),
            agreement=agreement_of(self._timeline.tally),
            presses=self._made(),
        )
        self._revise(episode)
        self._start_ns = start_ns + episode.cycles * CYCLE_NS + self._pause_ns
        self._so_far = self._so_far.after(watched=self.config.person is not None)
        return episode

    def digest(self) -> str:
        """Return SHA-256 over everything learned, hex: two sessions with the same one have learned the same.

        Of the human model that is all that decides about trust later: how many samples it is made of and how
        well it foresaw the presses, beside its weights.
        """
        human = self.human
        arrays = (self.sarsa.weights, human.weights, human.samples, human.foreseen, self._timeline.masses)
        digest = hashlib.sha256()
        for part in (*(array.tobytes() for array in arrays), self.bootstrap.state_bytes()):
            digest.update(len(part).to_bytes(8, "little"))
            digest.update(part)
        return digest.hexdigest()

    @property
    def _pause_ns(self) -> int:
        return round(self.config.pause_s * NS_PER_S)

    def _arguments(self, mix: Mix, judge: Judge, anew: bool) -> tuple[Any, ...]:
        """Return the arguments of `play`."""
        return (
            self.match,
            self._rules,
            self.sarsa,
            self.human,
            mix,
            judge,
            self._presses,
            self._rule,
            self._timeline,
            self.streams,
            Span(self._start_ns, self._pause_ns, SESSION_CYCLE_LIMIT),
            anew,
        )

    @property
    def _next(self) -> NextEpisode:
        """The episode to come; while one is being played, that one."""
        return next_episode(self.config.agent.scheme, self._so_far)

    def _mix(self) -> Mix:
        scheme = self.config.agent.scheme
        if self.human.samples[0] or not waits_for_feedback(scheme):
            weights = scheme.episode_weights(self.trust, self._next.scheduled)
        else:
            weights = ENVIRONMENT_WEIGHTS
        seed = stream_seed(self._seed, "share", self._next.number) >> 1 if weights.handover else 0
        playing, w_h_of = 0, NO_WEIGHTS
        if self._w_h_of and self.human.samples[0]:
            playing, w_h_of = self._w_h_of.index(self.bootstrap.w_h), self._w_h_of
        return Mix(
            weights=kernel_weights(weights),
            handover_seed=seed,
            sets=max(1, len(self._w_h_of)),
            playing=playing,
            w_h_of=w_h_of,
        )

    def _watch(self) -> Judge:
        """Let the participant begin an episode."""
        renew_budget(self._presses)
        if self.config.person is None:
            return self._judge
        self._trainer.watch_episode(self._next.number)
        return watch_episode(
            self._judge, self.config.person, self._trainer, root_seed=self._seed, episode=self._next.number
        )

    def _made(self) -> tuple[MadePress, ...]:
        presses = self._presses
        return tuple(
            MadePress(
                int(presses.made_ns[k]),
                float(presses.made_value[k]),
                int(presses.made_step[k]),
                bool(presses.made_deliberate[k]),
                bool(presses.made_accepted[k]),
            )
            for k in range(presses.counts[MADE])
        )

    def _revise(self, episode: ArlEpisode) -> None:
        """Let bootstrap learning hear of the episode: every episode is a policy of its own."""
        self.bootstrap.record(
            EpisodeReport(
                policy_id=self._next.number,
                theta=np.empty(0),
                performance=episode.duration_s,
                truncated=episode.truncated,
                agreement=episode.agreement,
                consistency=consistency(self.human),
            ),
            self.human.weights[0, 0] if self.human.samples[0] else None,
        )


def _room(config: ArlKeepawayConfig) -> int:
    """Return how many presses can wait, or be made in one episode: those of all episodes within a delay's
    reach.
    """
    person = config.person or NO_PRESSES
    trainer = person.trainer
    most = trainer.max_presses * trainer.burst_presses
    reach_s = trainer.delay.horizon_s + trainer.burst_presses * trainer.burst_interval_s
    return most * (2 + math.ceil(reach_s / (config.pause_s + SHORTEST_EPISODE_S)))
