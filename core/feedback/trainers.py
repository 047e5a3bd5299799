"""Simulated participants: they judge by an oracle, late, seldom, and not always rightly.

A trainer knows no game: it is given the oracle's value of each action. Its properties follow the literature:
mistakes and skips as in B-Pref (Lee et al. 2021), delay, few presses and stopping as in DQN-TAMER (Arakawa et
al. 2018), bursts as in TAMER's public logs, and the paper's own limits (section 4).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.feedback.config import TrainerConfig
from core.feedback.delays import Density, GammaDelay, UniformDelay, rule_for
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream

__all__ = ["IntendedPress", "SimulatedTrainer", "TrainerConfig", "draw_delay_s", "judgement"]

_BLOCK = 64
"""Steps whose draws are made at once: setting up a stream takes longer than drawing from it."""
_N_DRAWS = 6
READING_S = 2.0
"""A simulated participant reads a question for so long before anything else, seconds. (Our choice.)"""


@dataclass(frozen=True, slots=True)
class IntendedPress:
    """A key press that a simulated participant is going to make."""

    time_ns: int
    value: float
    """1.0 for the good key, -1.0 for the bad one; -2.0 to 2.0 where feedback is graded."""
    step: int
    """The step it is about, which need not be on screen any more."""
    believed: float
    """What the participant thinks of the step; `value` has the other sign in a mistake or a deliberate
    error."""
    deliberate: bool
    """The press is wrong on purpose."""


def judgement(
    oracle_values: NDArray[np.float64],
    action: int,
    *,
    good_share: float,
    skip_margin: float = 0.0,
    equal_margin: float = 0.0,
) -> float | None:
    """Return 1.0 for one of the best actions, -1.0 for another, None for one too near the border.

    Args:
        oracle_values: the oracle's value of each action, shape (n,); -inf for a fatal one.
        action: the chosen one.
        good_share: an action is good if fewer than this fraction of the n actions are better.
        skip_margin: nothing is said if the fraction of better actions is less than this away from
            `good_share`.
        equal_margin: nothing is said of an action (not a fatal one) whose value is less than this many sd of
            the finite values away from the middle between the worst good and the best bad value; nor where
            all are alike.
    """
    if not 0 <= action < len(oracle_values):
        raise ValueError(f"action {action} is not one of {len(oracle_values)}")
    value = oracle_values[action]
    better = float(np.count_nonzero(oracle_values > value)) / len(oracle_values)
    if abs(better - good_share) < skip_margin:
        return None
    if equal_margin > 0 and np.isfinite(value) and _too_close(oracle_values, value, good_share, equal_margin):
        return None
    return 1.0 if better < good_share else -1.0


def graded_judgement(
    oracle_values: NDArray[np.float64],
    action: int,
    *,
    good_share: float,
    skip_margin: float = 0.0,
    equal_margin: float = 0.0,
) -> float:
    """Return the judgement on the scale from -2 to 2: 0 where `judgement` says nothing.

    2 is for the better half of the good actions, -2 for the worse half of the bad ones. Arguments as in
    `judgement`.
    """
    plain = judgement(
        oracle_values, action, good_share=good_share, skip_margin=skip_margin, equal_margin=equal_margin
    )
    if plain is None:
        return 0.0
    better = float(np.count_nonzero(oracle_values > oracle_values[action])) / len(oracle_values)
    sure = better < good_share / 2 if plain > 0 else better >= (1 + good_share) / 2
    return 2 * plain if sure else plain


def _too_close(values: NDArray[np.float64], value: float, good_share: float, margin: float) -> bool:
    known = np.sort(values[np.isfinite(values)])[::-1]
    if known[0] == known[-1]:
        return True
    # Of equal values the first has as many better ones as each: `searchsorted` counts them.
    better = np.searchsorted(-known, -known, side="left") / len(values)
    bad = np.flatnonzero(better >= good_share)
    if len(bad) == 0:
        return False
    border = (known[max(bad[0] - 1, 0)] + known[bad[0]]) / 2
    return bool(abs(value - border) < margin * known.std())


class SimulatedTrainer:
    """A participant without a screen: says what is pressed and when, given what is shown.

    All draws about a step follow from (seed, episode, step); only the budget of presses links the steps.
    """

    def __init__(self, config: TrainerConfig, *, root_seed: int, graded: bool = False) -> None:
        """Begin a session.

        Args:
            config: what kind of participant.
            root_seed: of the session; stream "trainer".
            graded: they judge on the scale from -2 to 2, and press 0 where they would say nothing.
        """
        self.config = config
        self._judge = graded_judgement if graded else judgement
        self._root_seed = root_seed
        self._watched_episodes = 0
        self._episode = -1
        self._given = 0
        self._budget = 0
        # Number of the block of steps whose draws are at hand, and these draws.
        self._block = -1
        self._draws = np.empty((0, _N_DRAWS))

    def watch_episode(self, episode: int) -> None:
        """Note that a watched episode begins; `episode` is its number in the session."""
        self._watched_episodes += self._episode >= 0
        self._episode = episode
        self._given = 0
        self._block = -1
        most, usual = self.config.max_presses, self.config.mean_presses
        self._budget = most
        if usual is not None and most:
            rng = stream(self._root_seed, "trainer budget", episode)
            self._budget = int(rng.binomial(most, usual / most))

    @property
    def press_probability(self) -> float:
        """Chance per step in this episode, after fatigue; 0 for a participant who has stopped."""
        config = self.config
        if config.stops_after_episodes is not None and self._watched_episodes >= config.stops_after_episodes:
            return 0.0
        if config.fatigue_half_life_episodes is None:
            return config.press_probability
        tired: float = 0.5 ** (self._watched_episodes / config.fatigue_half_life_episodes)
        return config.press_probability * tired

    @property
    def judgements_left(self) -> int:
        """How many more judgements there can be in this episode."""
        return self._budget - self._given

    def draws(self, step: int) -> NDArray[np.float64]:
        """Return the draws about `step` and some steps after it, shape (n, 6), n >= 1, for compiled play.

        They are, in order: speaks, mistakes, deliberates, anticipates, bursts, moment (see `watch`).
        """
        return self._drawn(step)

    def next_inclined(self, step: int, end: int) -> int:
        """Return the first of the steps from `step` to before `end` at which they feel like speaking; else
        `end`.

        `watch` says nothing at all other steps, so a player need not stop there.
        """
        probability = self.press_probability
        if self.judgements_left <= 0 or probability == 0:
            return end
        while step < end:
            speaks = self._drawn(step)
            inclined = np.flatnonzero(speaks[:, 0] < probability)
            if len(inclined):
                return min(step + int(inclined[0]), end)
            step += len(speaks)
        return end

    def _drawn(self, step: int) -> NDArray[np.float64]:
        """Return the draws about this step and the others of its block after it, shape (n, _N_DRAWS), n >=
        1.
        """
        block, place = divmod(step, _BLOCK)
        if block != self._block:
            rng = stream(self._root_seed, "trainer", self._episode, block)
            self._block, self._draws = block, rng.random((_BLOCK, _N_DRAWS))
        return self._draws[place:]

    def watch(
        self,
        step: int,
        oracle_values: NDArray[np.float64],
        action: int,
        *,
        shown_ns: int,
        hidden_ns: int,
        attention: float = 1.0,
    ) -> tuple[IntendedPress, ...]:
        """Return the presses about one step, in order of time.

        Args:
            step: its number in the session.
            oracle_values: the oracle's value of each action, shape (n,); -inf for a fatal one.
            action: what the agent chose.
            shown_ns: when the step came on screen.
            hidden_ns: when its outcome is seen: the end of its time on screen.
            attention: chance that this step is judged, as a fraction of `press_probability`, in [0, 1].
        """
        if self._episode < 0:
            raise ValueError("watch_episode comes before the first step")
        config = self.config
        if self.judgements_left <= 0 or self.press_probability == 0:
            return ()
        # Always drawn, in this order: a change of one rate leaves the other draws as they were.
        speaks, mistakes, deliberates, anticipates, bursts, moment = self._drawn(step)[0].tolist()
        if speaks >= self.press_probability * attention:
            return ()
        believed = self._judge(
            oracle_values,
            action,
            good_share=config.good_share,
            skip_margin=config.skip_margin,
            equal_margin=config.equal_margin,
        )
        if believed is None:
            return ()
        self._given += 1
        deliberate = bool(deliberates < config.deliberate_rate)
        value = -believed if deliberate or mistakes < config.mistake_rate else believed
        if anticipates < config.anticipation_rate:
            first_ns = shown_ns + round(moment * (hidden_ns - shown_ns))
        else:
            first_ns = hidden_ns + self._delay_ns(step, value)
        n_presses = config.burst_presses if bursts < config.burst_rate else 1
        interval_ns = round(config.burst_interval_s * NS_PER_S)
        return tuple(
            IntendedPress(first_ns + k * interval_ns, value, step, believed, deliberate)
            for k in range(n_presses)
        )

    def _delay_ns(self, step: int, value: float) -> int:
        """Return the time from the outcome of a step to the press about it."""
        rng = stream(self._root_seed, "trainer delay", self._episode, step)
        delay = rule_for(self.config.delay, value)
        assert isinstance(delay, Density), "a participant's delay is a density"
        return round(draw_delay_s(delay, rng=rng) * NS_PER_S)

    def answer(self, step: int, oracle_values: NDArray[np.float64], options: Sequence[int]) -> int | None:
        """Return which of the agent's options they choose; None where they do not say.

        The best option by the oracle, the first of equal ones; in a mistake another one, any as likely. They
        do not answer where the best two are too close to tell apart (`equal_margin`), or when they have left.

        Args:
            step: its number in the session.
            oracle_values: the oracle's value of each action, shape (n,); -inf for a fatal one.
            options: 2 or more different actions.
        """
        if len(set(options)) != len(options) or len(options) < 2:
            raise ValueError(f"a question has 2 or more different options, got {list(options)}")
        if self.press_probability == 0:
            return None
        config = self.config
        ranked = sorted(options, key=lambda action: -oracle_values[action])
        known = oracle_values[np.isfinite(oracle_values)]
        lead = oracle_values[ranked[0]] - oracle_values[ranked[1]]
        if config.equal_margin > 0 and not lead > config.equal_margin * known.std():
            return None
        mistakes, which = stream(self._root_seed, "trainer answer", self._episode, step).random(2)
        if mistakes >= config.mistake_rate:
            return ranked[0]
        return ranked[1 + int(which * (len(ranked) - 1))]

    def answer_delay_s(self, step: int) -> float:
        """Return after how long on screen they answer a question about a step, seconds: they read it first
        (`READING_S`), and then press as they do otherwise.
        """
        rng = stream(self._root_seed, "trainer answer delay", self._episode, step)
        delay = rule_for(self.config.delay, 1.0)
        assert isinstance(delay, Density), "a participant's delay is a density"
        return READING_S + draw_delay_s(delay, rng=rng)


def draw_delay_s(delay: Density, *, rng: np.random.Generator) -> float:
    """Return one delay in seconds, drawn from its density."""
    match delay:
        case GammaDelay(shape=shape, scale_s=scale_s, offset_s=offset_s):
            return offset_s + float(rng.gamma(shape, scale_s))
        case UniformDelay(low_s=low_s, high_s=high_s):
            return float(rng.uniform(low_s, high_s))
