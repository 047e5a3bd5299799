"""Whole episodes of keepers that learn from their environment and from a simulated person, for experiments.

Cycles and decisions are compiled; what happens once per press or once per episode is done by the same classes and
functions as in a session: the gate of key presses, the credit of a press, bootstrap learning, the schemes.
"""

import hashlib
import heapq
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from core.clock import NS_PER_S
from core.combination.bootstrap_learning import BootstrapLearning, EpisodeReport
from core.combination.config import (
    ENVIRONMENT_WEIGHTS,
    AgentConfig,
    BootstrapConfig,
    Equation4,
    HumanOnly,
)
from core.combination.trust import Comparison
from core.combination.window import DecisionWindow
from core.compiled import specialised
from core.episode import KeyPressed
from core.feedback.config import CreditConfig
from core.feedback.credit import STILL_SHOWN_NS, credit
from core.feedback.delays import CurrentStep, Delay, GammaDelay, PreviousStep
from core.feedback.samples import MassAccount, PressCredit
from core.feedback.trainers import SimulatedTrainer
from core.keepaway.arl_cycles import (
    AGREED,
    AGREED_WORST,
    COMPARED,
    EPISODE_STEPS,
    PRESS_DUE,
    STEPS,
    STOPPED,
    Mix,
    learn_from_press,
    new_timeline,
    play_until_press,
)
from core.keepaway.autoplay import CYCLE_LIMIT, keepaway_tiles
from core.keepaway.match import CYCLE, END, new_match, open_streams
from core.keepaway.person import PLANNED, Watcher, new_watcher, watch_episode
from core.keepaway.person_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_NS, CYCLE_S, OUT, KeepawayConfig
from core.keys import KeyConfig, PressGate
from core.learners.human_config import TileModel
from core.learners.sarsa import SarsaConfig, new_sarsa
from core.learners.tiled_human import new_tiled_human
from core.streams import stream_seed

KEEPAWAY_AGENT = AgentConfig(credit=CreditConfig(delay=GammaDelay()), human_model=TileModel())
"""Eq. 3, Eq. 4, credit by the paper's density, and a human model over tiles."""


@dataclass(frozen=True, slots=True)
class ArlKeepawayConfig:
    """Keepers that learn from environment and person, and who the person is."""

    task: KeepawayConfig = KeepawayConfig()
    sarsa: SarsaConfig = SarsaConfig()
    agent: AgentConfig = KEEPAWAY_AGENT
    """`human_model` has to be a `TileModel`; credit is individual and merges no bursts; matches are measured as
    played."""
    person: KeepawayPersonConfig | None = KeepawayPersonConfig()
    """None: nobody watches."""
    keys: KeyConfig = KeyConfig(max_presses_per_episode=2)
    """At most two presses per episode (section 4)."""
    pause_s: float = 2.0
    """How long the last picture of an episode stays before the next kick-off; late presses still count then."""
    n_tilings: int = 32

    def __post_init__(self) -> None:
        if not isinstance(self.agent.human_model, TileModel):
            raise ValueError(f"compiled play needs human_model=TileModel(...), got {self.agent.human_model}")
        if self.agent.credit.scheme != "individual" or self.agent.credit.merge_within_s:
            raise ValueError(
                "compiled play credits each press by itself: scheme='individual' and merge_within_s=0, got "
                f"{self.agent.credit}; play a session for others"
            )
        trust = self.agent.bootstrap.trust
        if isinstance(trust, Equation4) and (
            trust.measured == "window" or (trust.match == "chance-corrected" and trust.chance is None)
        ):
            raise ValueError(
                f"compiled play keeps no window of decisions: measure as played and give chance, got {trust}"
            )
        if not (math.isfinite(self.pause_s) and self.pause_s >= 0):
            raise ValueError(f"pause_s is >= 0 seconds, got {self.pause_s}")
        self._check_bursts()

    def _check_bursts(self) -> None:
        """Refuse presses that the gate could take for a held key: learning is never undone here."""
        trainer = self.person.trainer if self.person else None
        shortest_ms = 2 * self.keys.repeat_interval_ms
        if trainer and trainer.burst_rate > 0 and trainer.burst_interval_s * 1000 < shortest_ms:
            raise ValueError(
                f"presses of a burst are at least {shortest_ms} ms apart, got {trainer.burst_interval_s} s"
            )


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
    w_h: float
    """Weight of the human with which it was played; the trust before it."""
    steps: int
    """Decisions of all keepers."""
    compared: int
    """Decisions made while the human model knew something."""
    agreed: int
    """Of these, those at which the environment's best option was the human model's best."""
    agreed_worst: int
    """Of these, those at which it was the human model's worst."""
    presses: tuple[KeyPressed, ...]
    """Presses made until the next kick-off, the refused ones too."""

    @property
    def duration_s(self) -> float:
        """Duration in seconds: the performance measure."""
        return self.cycles * CYCLE_S

    @property
    def accepted(self) -> int:
        """Presses that counted."""
        return sum(press.verdict == "accepted" for press in self.presses)


class ArlAutoplay:
    """A session of Keepaway without a screen, played in whole episodes. Time stands still but for the match."""

    def __init__(self, config: ArlKeepawayConfig, root_seed: int, *path: str | int) -> None:
        """Set up the match whose streams are named by `path`; the person's streams follow from it, too."""
        task = config.task
        self.config = config
        self.streams = open_streams(root_seed, *path)
        self.match = new_match(task, self.streams)
        coder = keepaway_tiles(task, config.n_tilings)
        self.sarsa = new_sarsa(config.sarsa, coder, task.n_keepers, task.n_actions)
        model = config.agent.human_model
        assert isinstance(model, TileModel), "checked by the configuration"
        self.human = new_tiled_human(model, coder, task.n_keepers, task.n_actions)
        self.account = MassAccount()
        self._seed = stream_seed(root_seed, *path, "session")
        self.bootstrap = _bootstrap(config.agent.bootstrap, self._seed)
        self._rules = task.rules()
        delay = config.agent.credit.delay
        self._reach_ns = _reach_ns(delay)
        places = (self._reach_ns // CYCLE_NS + 3) * task.n_keepers
        self._timeline = new_timeline(places, len(coder.low), task.n_actions)
        person = config.person or KeepawayPersonConfig()
        self._trainer = SimulatedTrainer(person.trainer, root_seed=self._seed)
        self._watcher = new_watcher(person, self.match)
        self._gate = PressGate(config.keys)
        self._due: list[tuple[int, int, float, bool]] = []
        self._planned = 0
        self._presses: list[KeyPressed] = []
        self._episode = 0
        self._start_ns = 0
        self._play = specialised(play_until_press, *self._cycle_arguments(self._mix(), self._watcher, False))
        self._teach = specialised(learn_from_press, self.human, self._timeline, 0, np.zeros(1), 1.0)

    @property
    def w_h(self) -> float:
        """Weight of the human by bootstrap learning; 0 while the human model knows nothing."""
        return self.bootstrap.w_h if self.human.samples[0] else 0.0

    def play_episode(self) -> ArlEpisode:
        """Play the next episode and the pause after it."""
        self._gate.episode_started()
        self._presses = []
        counts, status = self._timeline.counts, self.match.status
        counts[EPISODE_STEPS:] = 0
        mix, watcher = self._mix(), self._watch()
        start_ns, w_h, anew = self._start_ns, self.w_h, bool(status[CYCLE] > 0)
        while True:
            reason = self._play(*self._cycle_arguments(mix, watcher, anew))
            anew = False
            self._take_plans(watcher)
            now_ns = start_ns + int(status[CYCLE]) * CYCLE_NS
            if reason != PRESS_DUE:
                break
            self._press_until(now_ns)
        compared, agreed, agreed_worst = (int(counts[k]) for k in (COMPARED, AGREED, AGREED_WORST))
        comparison = Comparison(compared, agreed, agreed_worst) if compared else None
        self._revise(int(status[CYCLE]), reason == STOPPED, comparison)
        self._start_ns = now_ns + round(self.config.pause_s * NS_PER_S)
        self._press_until(self._start_ns)
        self._episode += 1
        return ArlEpisode(
            cycles=int(status[CYCLE]),
            out=bool(status[END] == OUT),
            truncated=reason == STOPPED,
            start_ns=start_ns,
            w_h=w_h,
            steps=int(counts[EPISODE_STEPS]),
            compared=compared,
            agreed=agreed,
            agreed_worst=agreed_worst,
            presses=tuple(self._presses),
        )

    def digest(self) -> str:
        """Return SHA-256 over everything learned, hex."""
        parts = (self.sarsa.weights.tobytes(), self.human.weights.tobytes(), self.bootstrap.state_bytes())
        return hashlib.sha256(b"".join(parts)).hexdigest()

    def _cycle_arguments(self, mix: Mix, watcher: Watcher, anew: bool) -> tuple[Any, ...]:
        """Return the arguments of `play_until_press`."""
        return (
            self.match,
            self._rules,
            self.sarsa,
            self.human,
            mix,
            watcher,
            self._timeline,
            self.streams,
            anew,
            self._start_ns,
            self._due[0][0] if self._due else STILL_SHOWN_NS,
            CYCLE_LIMIT,
        )

    def _mix(self) -> Mix:
        scheme = self.config.agent.scheme
        if self.human.samples[0] or isinstance(scheme, HumanOnly):
            weights = scheme.weights(self.w_h, self._episode)
        else:
            weights = ENVIRONMENT_WEIGHTS
        seed = stream_seed(self._seed, "share", self._episode) >> 1 if weights.share else 0
        return Mix(int(weights.form), float(weights.w_r), float(weights.w_h), float(weights.share), seed)

    def _watch(self) -> Watcher:
        if self.config.person is None:
            return self._watcher
        self._trainer.begin_episode(self._episode)
        return watch_episode(
            self._watcher,
            self.config.person,
            self._trainer.press_probability,
            root_seed=self._seed,
            episode=self._episode,
        )

    def _take_plans(self, watcher: Watcher) -> None:
        """Note the presses that were planned since the last call."""
        for k in range(watcher.tally[PLANNED]):
            plan = (float(watcher.planned_values[k]), bool(watcher.planned_deliberate[k]))
            # The counter keeps presses of equal times in order.
            heapq.heappush(self._due, (int(watcher.planned_ns[k]), self._planned, *plan))
            self._planned += 1
        watcher.tally[PLANNED] = 0

    def _press_until(self, now_ns: int) -> None:
        """Make the presses that are due, and learn from those that count."""
        keys = self.config.keys
        while self._due and self._due[0][0] <= now_ns:
            time_ns, _, value, deliberate = heapq.heappop(self._due)
            self._gate.wrong_asked = deliberate
            records = self._gate.press(keys.good if value > 0 else keys.bad, time_ns, source="simulated")
            for record in records:
                assert isinstance(record, KeyPressed), "no run of presses is a held key"
                self._presses.append(record)
                if record.verdict == "accepted":
                    self._learn(record, value)
            self._gate.wrong_asked = False

    def _learn(self, record: KeyPressed, value: float) -> None:
        """Share a press out among the steps it may be about, and let the keepers that made them learn."""
        timeline, n_steps = self._timeline, int(self._timeline.counts[STEPS])
        steps = np.arange(max(0, n_steps - len(timeline.option)), n_steps)
        places = steps % len(timeline.option)
        shown_ns = timeline.shown_ns[places]
        first = int(np.searchsorted(shown_ns, record.time_ns - self._reach_ns, side="right")) - 1
        if isinstance(self.config.agent.credit.delay, PreviousStep | CurrentStep):
            first -= 1
        first = max(first, 0)
        given = credit(
            record.time_ns,
            shown_ns[first:],
            timeline.hidden_ns[places[first:]],
            self.config.agent.credit.delay,
        )
        if len(steps):
            self._teach(self.human, timeline, int(steps[first]), given.shares, value)
        shared = given.shares > 0
        self.account = self.account.plus(
            PressCredit(
                record.press,
                tuple(steps[first:][shared].tolist()),
                tuple(given.shares[shared].tolist()),
                given.before_first,
                given.in_gaps,
            )
        )

    def _revise(self, cycles: int, truncated: bool, comparison: Comparison | None) -> None:
        """Let bootstrap learning hear of the episode: every episode is a policy of its own."""
        self.bootstrap.record(
            EpisodeReport(
                policy_id=self._episode,
                theta=np.empty(0),
                performance=cycles * CYCLE_S,
                truncated=truncated,
                comparison=comparison,
            ),
            self.human.weights[0, 0] if self.human.samples[0] else None,
        )


def _bootstrap(config: BootstrapConfig, seed: int) -> BootstrapLearning:
    """Return bootstrap learning that needs no window: matches are measured as played."""

    def nothing(rows: np.ndarray, weights: np.ndarray) -> np.ndarray:
        raise AssertionError("matches are measured as played")

    return BootstrapLearning(config, DecisionWindow(1, nothing, nothing), root_seed=seed)


def _reach_ns(delay: Delay) -> int:
    """Return how far back a press reaches; 0 for the rules, which need the last two steps."""
    if isinstance(delay, PreviousStep | CurrentStep):
        return 0
    return math.ceil(delay.horizon_s * NS_PER_S) + 1
