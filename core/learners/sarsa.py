"""SMDP Sarsa(lambda) on tile-coded variables (Stone, Sutton & Kuhlmann 2005; UT Austin keepaway 0.6).

Several learners can learn side by side, each from its own decisions: they have weights of their own or share
them. A decision is an integer per variable (`core.numerics.tile_coding`) and an action.
"""

import math
from typing import NamedTuple

import numpy as np

from core.learners.sarsa_config import SarsaConfig
from core.numerics.arrays import Floats, Ints
from core.numerics.compiled import called_kernel, inner_kernel
from core.numerics.tile_coding import TileCoder, add_to_windows, window_sum

__all__ = [
    "NOT_YET",
    "Sarsa",
    "SarsaConfig",
    "action_values",
    "best_or_tied",
    "decide",
    "end_episode",
    "forget_episode",
    "frozen",
    "greedy_or_random",
    "last_value",
    "learn_beside",
    "new_sarsa",
    "observe_action",
    "reward_of",
    "take_action",
]

NOT_YET = -1
"""Last decision time of a learner that has not decided in this episode."""


class Sarsa(NamedTuple):
    """State of n learners of a actions over v variables with t tiles; kernels change the arrays in place."""

    weights: Floats
    """Shape (n, a, t), or (1, a, t) where shared."""
    traces: Floats
    """Eligibility, shape (n, a, t); without traces (lambda 0) shape (n, a, 0)."""
    windows: Ints
    """Active tiles of each learner's last decision, shape (n, v)."""
    last_action: Ints
    """Shape (n,)."""
    last_time: Ints
    """Cycle of the last decision; NOT_YET at the start of an episode, shape (n,)."""
    values: Floats
    """Action values at each learner's last decision, before the update it caused, shape (n, a)."""
    extra: Floats
    """What is added to the reward of time of each learner's last option, shape (n,): shaping, Q augmentation,
    and the domain's rewards where time brings none."""
    coder: TileCoder
    step_size: float
    """alpha / number of active tiles."""
    discount: float
    trace_decay: float
    exploration: float
    replacing: bool
    least_trace: float
    reward_is_time: bool
    """Each unit of time brings a reward of 1 (Keepaway); otherwise rewards are given, in `extra`."""


def new_sarsa(
    config: SarsaConfig, coder: TileCoder, n_learners: int, n_actions: int, *, reward_is_time: bool = True
) -> Sarsa:
    """Return learners that have not learned yet.

    Args:
        config: of all of them.
        coder: of the variables that they see.
        n_learners: >= 1.
        n_actions: of each decision, >= 1.
        reward_is_time: each unit of time brings a reward of 1, as in Keepaway; False: rewards are added to
            `extra`.
    """
    n_variables = len(coder.low)
    n_active = n_variables * coder.n_tilings
    n_sets = 1 if config.shared_weights else n_learners
    with_traces = config.trace_decay > 0
    return Sarsa(
        weights=np.full((n_sets, n_actions, coder.n_tiles), config.initial_value / n_active),
        traces=np.zeros((n_learners, n_actions, coder.n_tiles if with_traces else 0)),
        windows=np.zeros((n_learners, n_variables), np.int64),
        last_action=np.zeros(n_learners, np.int64),
        last_time=np.full(n_learners, NOT_YET, np.int64),
        values=np.zeros((n_learners, n_actions)),
        extra=np.zeros(n_learners),
        coder=coder,
        step_size=float(config.step_size) / n_active,
        discount=float(config.discount),
        trace_decay=float(config.trace_decay),
        exploration=float(config.exploration),
        replacing=bool(config.replacing_traces),
        least_trace=float(config.least_trace),
        reward_is_time=reward_is_time,
    )


def frozen(sarsa: Sarsa, exploration: float = 0.0) -> Sarsa:
    """Return the same learners, sharing their weights, that act but no longer learn."""
    return sarsa._replace(
        step_size=0.0,
        exploration=float(exploration),
        windows=sarsa.windows.copy(),
        last_action=sarsa.last_action.copy(),
        last_time=np.full_like(sarsa.last_time, NOT_YET),
        values=sarsa.values.copy(),
        extra=np.zeros_like(sarsa.extra),
    )


@inner_kernel
def reward_of(cycles: int, discount: float) -> float:
    """Return the reward of `cycles` cycles of play, 1 for each, discounted from the option's start."""
    if discount == 1.0:
        return float(cycles)
    return (1.0 - math.pow(discount, float(cycles))) / (1.0 - discount)


@inner_kernel
def greedy_or_random(values: Floats, exploration: float, rng: np.random.Generator) -> int:
    """Return the best action, ties broken at random; with probability `exploration` any. Draws twice."""
    explore, pick = rng.random() < exploration, rng.random()
    if explore:
        return int(pick * len(values))
    return best_or_tied(values, pick)


@inner_kernel
def best_or_tied(values: Floats, pick: float) -> int:
    """Return the best action; of equally good ones that at the fraction `pick`, in [0, 1), of them."""
    n = len(values)
    best = values[0]
    for a in range(1, n):
        best = max(best, values[a])
    n_best = 0
    for a in range(n):
        n_best += values[a] == best
    wanted = int(pick * n_best)
    for a in range(n):
        if values[a] == best:
            if wanted == 0:
                return a
            wanted -= 1
    return 0


@inner_kernel
def action_values(sarsa: Sarsa, k: int, windows: Ints, out: Floats) -> None:
    """Write Q(s, a) of learner k for every action, in cycles still to come."""
    weights = sarsa.weights[min(k, sarsa.weights.shape[0] - 1)]
    for a in range(len(out)):
        out[a] = window_sum(weights[a], windows, sarsa.coder.n_tilings)


@called_kernel
def decide(sarsa: Sarsa, k: int, windows: Ints, time: int, rng: np.random.Generator) -> int:
    """Choose learner k's action in the state with these active tiles, and learn from the option that ended.

    Args:
        sarsa: learners, in place.
        k: which learner.
        windows: first active tile per variable, shape (v,) (`core.numerics.tile_coding.find_windows`).
        time: cycle of the decision, within the episode.
        rng: policy stream; two draws.

    Returns:
        The action, as `greedy_or_random`.
    """
    values = sarsa.values[k]
    before = 0.0
    if sarsa.last_time[k] != NOT_YET:
        before = last_value(sarsa, k)
    action_values(sarsa, k, windows, values)
    action = greedy_or_random(values, sarsa.exploration, rng)
    take_action(sarsa, k, windows, action, time, before)
    return action


@inner_kernel
def take_action(sarsa: Sarsa, k: int, windows: Ints, action: int, time: int, before: float) -> None:
    """Learn from learner k's ended option, now that `action` is chosen, and remember the new decision.

    `before` is the value of the ended option (`last_value`), unused before the first decision. The values of
    the present state have been written to `sarsa.values[k]`. Use this where another agent chooses the action.
    """
    _learn_from_ended(sarsa, k, sarsa.values[k, action], time, before)
    _begin_option(sarsa, k, windows, action, time)


@inner_kernel
def learn_beside(
    sarsa: Sarsa, k: int, windows: Ints, action: int, own: int, time: int, before: float
) -> None:
    """`take_action` for a learner that looks on: another one chose `action`, it would have chosen `own`.

    What follows the ended option is worth what its own choice is worth to it, so it learns about its own
    policy (off-policy, as Watkins' Q-learning 1989). Without traces: those of choices that are not its own
    would have to be cut.
    """
    _learn_from_ended(sarsa, k, sarsa.values[k, own], time, before)
    _begin_option(sarsa, k, windows, action, time)


@inner_kernel
def _learn_from_ended(sarsa: Sarsa, k: int, value: float, time: int, before: float) -> None:
    """Learn from learner k's ended option, `value` being that of the present state to its policy."""
    last = sarsa.last_time[k]
    if last != NOT_YET and sarsa.step_size > 0.0:
        passed = math.pow(sarsa.discount, float(time - last))
        target = _earned(sarsa, time - last) + sarsa.extra[k] + passed * value
        _learn(sarsa, k, target - before)
        _decay_traces(sarsa, k, passed * sarsa.trace_decay)
    sarsa.extra[k] = 0.0


@inner_kernel
def _earned(sarsa: Sarsa, duration: int) -> float:
    """Return the reward of time itself."""
    return reward_of(duration, sarsa.discount) if sarsa.reward_is_time else 0.0


@inner_kernel
def _begin_option(sarsa: Sarsa, k: int, windows: Ints, action: int, time: int) -> None:
    """Remember learner k's new decision."""
    for v in range(len(windows)):
        sarsa.windows[k, v] = windows[v]
    sarsa.last_action[k] = action
    sarsa.last_time[k] = time
    if sarsa.step_size > 0.0:
        _mark(sarsa, k)


@inner_kernel
def observe_action(sarsa: Sarsa, k: int, windows: Ints, action: int, time: int) -> None:
    """Learn from learner k's ended option and note the new decision: `decide` where another agent has chosen.

    Args:
        sarsa: learners, in place.
        k: which learner.
        windows: first active tile per variable, shape (v,).
        action: what was chosen.
        time: cycle of the decision, within the episode.
    """
    before = 0.0
    if sarsa.last_time[k] != NOT_YET:
        before = last_value(sarsa, k)
    action_values(sarsa, k, windows, sarsa.values[k])
    take_action(sarsa, k, windows, action, time, before)


@called_kernel
def end_episode(sarsa: Sarsa, time: int) -> None:
    """Give every learner that decided the reward up to the episode's end, and forget traces and decisions."""
    for k in range(len(sarsa.last_time)):
        last = sarsa.last_time[k]
        if last != NOT_YET and sarsa.step_size > 0.0:
            reward = _earned(sarsa, time - last) + sarsa.extra[k]
            _learn(sarsa, k, reward - last_value(sarsa, k))
        sarsa.last_time[k] = NOT_YET
        sarsa.extra[k] = 0.0
    if sarsa.step_size > 0.0:
        sarsa.traces[:] = 0.0


@inner_kernel
def forget_episode(sarsa: Sarsa) -> None:
    """Forget traces and decisions of an episode that was broken off: nobody knows what came of its last
    options.
    """
    sarsa.last_time[:] = NOT_YET
    sarsa.extra[:] = 0.0
    if sarsa.step_size > 0.0:
        sarsa.traces[:] = 0.0


@inner_kernel
def last_value(sarsa: Sarsa, k: int) -> float:
    """Return the value that learner k's last decision has now, in cycles; it must have decided in this
    episode.
    """
    weights = sarsa.weights[min(k, sarsa.weights.shape[0] - 1)]
    return window_sum(weights[sarsa.last_action[k]], sarsa.windows[k], sarsa.coder.n_tilings)


@inner_kernel
def _learn(sarsa: Sarsa, k: int, error: float) -> None:
    """W += alpha * error * trace; without traces only the last decision's tiles have one."""
    weights = sarsa.weights[min(k, sarsa.weights.shape[0] - 1)]
    amount = sarsa.step_size * error
    if sarsa.traces.shape[2] == 0:
        add_to_windows(weights[sarsa.last_action[k]], sarsa.windows[k], sarsa.coder.n_tilings, amount)
        return
    for a in range(weights.shape[0]):
        for t in range(weights.shape[1]):
            weights[a, t] += amount * sarsa.traces[k, a, t]


@inner_kernel
def _decay_traces(sarsa: Sarsa, k: int, decay: float) -> None:
    for a in range(sarsa.traces.shape[1]):
        for t in range(sarsa.traces.shape[2]):
            trace = sarsa.traces[k, a, t] * decay
            sarsa.traces[k, a, t] = trace if trace >= sarsa.least_trace else 0.0


@inner_kernel
def _mark(sarsa: Sarsa, k: int) -> None:
    """Make the tiles of the last decision eligible."""
    if sarsa.traces.shape[2] == 0:
        return
    n_tilings = sarsa.coder.n_tilings
    for v in range(sarsa.windows.shape[1]):
        first = sarsa.windows[k, v]
        for t in range(first, first + n_tilings):
            if sarsa.replacing:
                sarsa.traces[k, :, t] = 0.0
                sarsa.traces[k, sarsa.last_action[k], t] = 1.0
            else:
                sarsa.traces[k, sarsa.last_action[k], t] += 1.0
