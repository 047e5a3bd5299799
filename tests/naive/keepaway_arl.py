"""Keepers that hear a person, written for reading: every cycle in Python, every part that of a session.

Presses go through `PressGate`, credit through `CreditAssigner`, the human model is the dense
`HumanRewardModel`, the participant a `SimulatedTrainer` of which only the stream of delays is replaced.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, field

import numpy as np

from core.combination.agreement import Agreement
from core.combination.bootstrap_learning import BootstrapLearning
from core.combination.config import ENVIRONMENT_WEIGHTS, HumanOnly, SideBySide
from core.combination.preference import best_action, choose, takes_control, worst_action
from core.combination.ranking import EpisodeReport
from core.feedback import trainers
from core.feedback.assigner import CreditAssigner
from core.feedback.keys import PressGate
from core.keepaway.arl_autoplay import ArlKeepawayConfig
from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.simulator.game import begin_cycle, finish_cycle
from core.keepaway.simulator.match import CYCLE, new_match, open_streams, start_episode
from core.keepaway.simulator.policies import hand_coded
from core.keepaway.simulator.variables import observe
from core.learners.consistency import Consistency
from core.learners.human_config import SgdModel
from core.learners.human_reward import HumanRewardModel
from core.learners.sarsa import (
    NOT_YET,
    action_values,
    end_episode,
    greedy_or_random,
    last_value,
    new_sarsa,
    take_action,
)
from core.numerics.streams import stream, stream_seed
from core.numerics.tile_coding import find_windows

CYCLE_NS = 100_000_000


class Participant(trainers.SimulatedTrainer):
    """A trainer with the delays of compiled play."""

    def watch_episode(self, episode):
        super().watch_episode(episode)
        rng = stream(self._root_seed, "trainer delays", episode)
        self._delays_s = [
            trainers.draw_delay_s(self.config.delay, rng=rng) for _ in range(self.judgements_left)
        ]

    def see(self, n_in_episode, values, option, shown_ns, attention):
        """Return what `watch` would, with the n-th delay of the episode for the n-th judgement."""
        delays_s, judged, drawn_delay_s = self._delays_s, self._given, trainers.draw_delay_s
        trainers.draw_delay_s = lambda delay, rng: delays_s[judged]
        try:
            return self.watch(
                n_in_episode,
                values,
                option,
                shown_ns=shown_ns,
                hidden_ns=shown_ns + CYCLE_NS,
                attention=attention,
            )
        finally:
            trainers.draw_delay_s = drawn_delay_s


@dataclass
class Episode:
    cycles: int
    w_h: float
    agreement: tuple[int, int, int]
    presses: list[tuple[int, float, bool, bool]] = field(default_factory=list)


class ArlKeepaway:
    def __init__(self, config: ArlKeepawayConfig, root_seed: int, *path):
        self.config, task = config, config.task
        self.streams = open_streams(root_seed, *path)
        self.match, self.rules = new_match(task, self.streams), task.rules()
        self.coder = keepaway_tiles(task, config.n_tilings)
        sets = 3 if isinstance(config.agent.bootstrap.trust, SideBySide) else 1
        self.learners = [
            new_sarsa(config.sarsa, self.coder, task.n_keepers, task.n_actions) for _ in range(sets)
        ]
        self.sarsa = self.learners[0]
        self.active = len(self.coder.low) * self.coder.n_tilings
        model = config.agent.human_model
        self.sets = 1 if model.shared else task.n_keepers
        self.n = task.n_actions
        self.human = HumanRewardModel(
            SgdModel(step_size=model.step_size / self.active, intercept=False),
            self.sets * self.n * self.coder.n_tiles,
        )
        self.consistency = Consistency()
        self.assigner = CreditAssigner(config.agent.credit)
        self.seed = stream_seed(root_seed, *path, "session")
        self.bootstrap = BootstrapLearning(config.agent.bootstrap, None, root_seed=self.seed)
        self.person = Participant(config.person.trainer, root_seed=self.seed) if config.person else None
        self.gate = PressGate(config.keys)
        self.due: list = []
        self.now_ns = self.steps = self.planned = self.episode = 0

    @property
    def w_h(self):
        return self.bootstrap.w_h if self.human.knows_something else 0.0

    def features(self, keeper, option, windows):
        psi = np.zeros((self.sets, self.n, self.coder.n_tiles))
        for first in windows:
            psi[min(keeper, self.sets - 1), option, first : first + self.coder.n_tilings] = 1.0
        return psi.ravel()

    def play_episode(self) -> Episode:
        scheme, heard = self.config.agent.scheme, self.human.knows_something
        waits = not heard and not isinstance(scheme, HumanOnly)
        self.weights = ENVIRONMENT_WEIGHTS if waits else scheme.episode_weights(self.w_h, self.episode)
        trust = self.config.agent.bootstrap.trust
        self.w_h_of = {0: 0.0, 1: 0.0, 2: 0.0}
        if isinstance(trust, SideBySide) and heard:
            self.w_h_of = {0: 0.0, 1: trust.weight, 2: -trust.weight}
            playing = {0.0: 0, 1.0: 1, -1.0: 2}[self.w_h / trust.weight]
            self.sarsa = self.learners[playing]
        self.handover_seed = stream_seed(self.seed, "share", self.episode) >> 1
        self.record = Episode(0, self.w_h, (0, 0, 0))
        self.in_episode = 0
        self.gate.episode_started()
        if self.person:
            self.person.watch_episode(self.episode)
        if self.match.status[CYCLE]:
            start_episode(self.match, self.rules, self.streams.placement)
        ended = False
        while not ended:
            self.press_until(self.now_ns)
            if begin_cycle(self.match, self.rules, self.streams):
                for keeper in np.flatnonzero(self.match.deciding):
                    self.decide(int(keeper))
            ended = finish_cycle(self.match, self.rules, self.streams)
            self.now_ns += CYCLE_NS
        self.record.cycles = int(self.match.status[CYCLE])
        for learner in self.learners:
            end_episode(learner, self.record.cycles)
        if self.in_episode:
            self.assigner.step_hidden(self.steps - 1, self.now_ns)
        self.now_ns += round(self.config.pause_s * 1e9)
        self.press_until(self.now_ns)
        counts = self.record.agreement
        self.bootstrap.record(
            EpisodeReport(
                policy_id=self.episode,
                theta=np.empty(0),
                performance=self.record.cycles * 0.1,
                truncated=False,
                agreement=Agreement(*counts) if counts[0] else None,
                consistency=self.consistency.score,
            ),
            self.human.weights if self.human.knows_something else None,
        )
        self.episode += 1
        return self.record

    def decide(self, keeper):
        windows = np.zeros(len(self.coder.low), np.int64)
        find_windows(self.coder, self.match.variables[keeper], windows)
        before = last_value(self.sarsa, keeper) if self.sarsa.last_time[keeper] != NOT_YET else 0.0
        action_values(self.sarsa, keeper, windows, self.sarsa.values[keeper])
        option = self.choose(self.sarsa.values[keeper], keeper, windows)
        take_action(self.sarsa, keeper, windows, option, self.match.status[CYCLE], before)
        for attitude, learner in enumerate(self.learners):
            if learner is not self.sarsa:
                self.look_on(learner, self.w_h_of[attitude], keeper, windows, option)
        self.match.actions[keeper] = option
        self.assigner.step_shown(self.steps, self.now_ns, self.features(keeper, option, windows))
        self.watch(keeper, option)
        self.steps += 1
        self.in_episode += 1

    def look_on(self, learner, w_h, keeper, windows, option):
        """Learn what the options are worth to a policy that did not choose them: Q-learning, written out."""
        now = int(self.match.status[CYCLE])
        tiles = np.concatenate([np.arange(w, w + self.coder.n_tilings) for w in windows])
        values = np.array([learner.weights[keeper, o, tiles].sum() for o in range(self.n)])
        own = choose(values, self.heard, np.zeros(self.n, np.bool_), self.n, 0, 1.0, w_h)
        if learner.last_time[keeper] != NOT_YET:
            ended = np.concatenate([np.arange(w, w + self.coder.n_tilings) for w in learner.windows[keeper]])
            weights = learner.weights[keeper, learner.last_action[keeper]]
            target = now - learner.last_time[keeper] + values[own]
            weights[ended] += self.config.sarsa.step_size / self.active * (target - weights[ended].sum())
        learner.windows[keeper], learner.last_action[keeper] = windows, option
        learner.last_time[keeper] = now

    def choose(self, values, keeper, windows):
        none, weights, rng = np.zeros(self.n, np.bool_), self.weights, self.streams.policy
        preferred = -1
        heard = self.heard = np.zeros(self.n)
        if self.human.knows_something:
            heard = self.heard = self.human.predict(
                np.stack([self.features(keeper, o, windows) for o in range(self.n)])
            )
            own, liked = best_action(values, none, self.n), best_action(heard, none, self.n)
            n, agreed, worst = self.record.agreement
            disliked = worst_action(heard, none, self.n)
            self.record.agreement = (n + 1, agreed + (own == liked), worst + (own == disliked))
            if takes_control(self.handover_seed, self.in_episode, weights.handover):
                preferred = liked
        if preferred < 0 and weights.w_h:
            preferred = choose(values, heard, none, self.n, weights.form, weights.w_r, weights.w_h)
        if preferred < 0:
            return greedy_or_random(values, self.sarsa.exploration, rng)
        explore, pick = rng.random() < self.sarsa.exploration, rng.random()
        return int(pick * self.n) if explore else preferred

    def wanted(self, keeper):
        variables, order = self.match.variables[keeper], self.match.order[keeper]
        k, t = self.rules.n_keepers, self.rules.n_takers
        person = self.config.person
        true_order = order
        if person.sees == "everything":
            variables, true_order = np.zeros_like(variables), np.zeros_like(order)
            observe(keeper, self.match.players, k, true_order, variables)
        if person.trainer.knowledge == "expert":
            wanted = hand_coded(variables, k, t)
        elif variables[k] > 4.0:
            wanted = 0
        else:
            wanted = 1 + int(np.argmax(variables[1 + 2 * (k - 1 + t) :][: k - 1]))
        return order[:k].tolist().index(true_order[wanted])

    def watch(self, keeper, option):
        if not self.person:
            return
        noticed = 1 - (1 - self.config.person.holds_noticed_per_s) ** 0.1
        attention = noticed if option == 0 else 1.0
        values = np.zeros(self.n)
        values[self.wanted(keeper)] = 1.0
        for press in self.person.see(self.in_episode, values, option, self.now_ns, attention):
            heapq.heappush(self.due, (press.time_ns, self.planned, press))
            self.planned += 1

    def press_until(self, now_ns):
        while self.due and self.due[0][0] <= now_ns:
            time_ns, number, press = heapq.heappop(self.due)
            key = self.config.keys.good if press.value > 0 else self.config.keys.bad
            (made,) = self.gate.judge(key, time_ns, source="simulated")
            accepted = made.verdict == "accepted"
            self.record.presses.append((time_ns, press.value, press.deliberate, accepted))
            if accepted:
                self.assigner.add_press(number, time_ns, press.value)
                for sample in self.assigner.take():
                    expected = float(self.human.predict(sample.features[None, :])[0])
                    self.consistency.note(expected, sample.label, sample.weight)
                    self.human.add(sample)
