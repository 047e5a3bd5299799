"""Simulated participants: they judge by an oracle, late, seldom, and not always rightly.

A trainer knows no game: it is given the oracle's value of each action. Its properties follow the literature:
mistakes and skips as in B-Pref (Lee et al. 2021), delay, few presses and stopping as in DQN-TAMER (Arakawa et al.
2018), bursts as in TAMER's public logs, and the paper's own limits (section 4).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from core.clock import NS_PER_S
from core.feedback.config import TrainerConfig
from core.feedback.delays import Density, GammaDelay, UniformDelay
from core.streams import stream

__all__ = ["IntendedPress", "SimulatedTrainer", "TrainerConfig", "draw_delay_s", "judgement"]


@dataclass(frozen=True, slots=True)
class IntendedPress:
    """A key press that a simulated participant is going to make."""

    time_ns: int
    value: float
    """1.0 for the good key, -1.0 for the bad one."""
    step: int
    """The step it is about, which need not be on screen any more."""
    believed: float
    """What the participant thinks of the step; `value` has the other sign in a mistake or a deliberate error."""
    deliberate: bool
    """The press is wrong on purpose."""


def judgement(
    oracle_values: NDArray[np.float64], action: int, *, good_share: float, skip_margin: float = 0.0
) -> float | None:
    """Return 1.0 for one of the best actions, -1.0 for another, None for one too near the border.

    Args:
        oracle_values: the oracle's value of each action, shape (n,); -inf for a fatal one.
        action: the chosen one.
        good_share: an action is good if fewer than this share of the n actions are better.
        skip_margin: nothing is said if the share of better actions is less than this away from `good_share`.
    """
    if not 0 <= action < len(oracle_values):
        raise ValueError(f"action {action} is not one of {len(oracle_values)}")
    better = float(np.count_nonzero(oracle_values > oracle_values[action])) / len(oracle_values)
    if abs(better - good_share) < skip_margin:
        return None
    return 1.0 if better < good_share else -1.0


class SimulatedTrainer:
    """A participant without a screen: says what is pressed and when, given what is shown.

    All draws about a step follow from (seed, episode, step); only the budget of presses links the steps.
    """

    def __init__(self, config: TrainerConfig, *, root_seed: int) -> None:
        """Begin a session.

        Args:
            config: what kind of participant.
            root_seed: of the session; stream "trainer".
        """
        self.config = config
        self._root_seed = root_seed
        self._watched_episodes = 0
        self._episode = -1
        self._given = 0

    def begin_episode(self, episode: int) -> None:
        """Note that a watched episode begins; `episode` is its number in the session."""
        self._watched_episodes += self._episode >= 0
        self._episode = episode
        self._given = 0

    @property
    def press_probability(self) -> float:
        """Chance per step in this episode, after fatigue; 0 for somebody who has stopped."""
        config = self.config
        if config.stops_after_episodes is not None and self._watched_episodes >= config.stops_after_episodes:
            return 0.0
        if config.fatigue_half_life_episodes is None:
            return config.press_probability
        tired: float = 0.5 ** (self._watched_episodes / config.fatigue_half_life_episodes)
        return config.press_probability * tired

    def watch(
        self, step: int, oracle_values: NDArray[np.float64], action: int, *, shown_ns: int, hidden_ns: int
    ) -> tuple[IntendedPress, ...]:
        """Return the presses about one step, in order of time.

        Args:
            step: its number in the session.
            oracle_values: the oracle's value of each action, shape (n,); -inf for a fatal one.
            action: what the agent chose.
            shown_ns: when the step came on screen.
            hidden_ns: when its outcome is seen: the end of its time on screen.
        """
        if self._episode < 0:
            raise ValueError("begin_episode comes before the first step")
        config = self.config
        if self._given >= config.max_presses or self.press_probability == 0:
            return ()
        rng = stream(self._root_seed, "trainer", self._episode, step)
        # Always drawn, in this order: a change of one rate leaves the other draws as they were.
        speaks, mistakes, deliberates, anticipates, bursts, moment = rng.random(6)
        if speaks >= self.press_probability:
            return ()
        believed = judgement(
            oracle_values, action, good_share=config.good_share, skip_margin=config.skip_margin
        )
        if believed is None:
            return ()
        self._given += 1
        deliberate = bool(deliberates < config.deliberate_rate)
        value = -believed if deliberate or mistakes < config.mistake_rate else believed
        if anticipates < config.anticipation_rate:
            first_ns = shown_ns + round(moment * (hidden_ns - shown_ns))
        else:
            first_ns = hidden_ns + round(draw_delay_s(config.delay, rng=rng) * NS_PER_S)
        n_presses = config.burst_presses if bursts < config.burst_rate else 1
        interval_ns = round(config.burst_interval_s * NS_PER_S)
        return tuple(
            IntendedPress(first_ns + k * interval_ns, value, step, believed, deliberate)
            for k in range(n_presses)
        )


def draw_delay_s(delay: Density, *, rng: np.random.Generator) -> float:
    """Return one delay in seconds, drawn from its density."""
    match delay:
        case GammaDelay(shape=shape, scale_s=scale_s, offset_s=offset_s):
            return offset_s + float(rng.gamma(shape, scale_s))
        case UniformDelay(low_s=low_s, high_s=high_s):
            return float(rng.uniform(low_s, high_s))
