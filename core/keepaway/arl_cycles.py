"""Compiled play of keepers that learn from their environment and from a person: cycles up to the next key press.

Steps, intervals and the decision are those of sessions (`docs/decisions/keepaway-steps-in-compiled-play.md`); what
a press teaches is worked out by the caller between two calls (`core.keepaway.arl_autoplay`).
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.combination.schemes import best_action, choose, takes_control, worst_action
from core.compiled import kernel
from core.keepaway.game import begin_cycle, finish_cycle
from core.keepaway.match import CYCLE, Match, Streams, start_episode
from core.keepaway.person import NEVER_NS, Watcher, watch_step, would_choose
from core.keepaway.pitch import CYCLE_NS, Rules
from core.learners.sarsa import (
    NOT_YET,
    Sarsa,
    action_values,
    end_episode,
    greedy_or_random,
    last_value,
    take_action,
)
from core.learners.tiled_human import TiledHuman, human_values, learn_sample
from core.tile_coding import find_windows

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# What `play_until_press` returns.
PRESS_DUE: Final = 0
ENDED: Final = 1
STOPPED: Final = 2
"""The episode reached the limit of cycles."""

# Entries of `Timeline.counts`.
STEPS: Final = 0
"""Steps since the session began."""
EPISODE_STEPS: Final = 1
"""Steps of this episode."""
COMPARED: Final = 2
"""Decisions of this episode made while the human model knew something."""
AGREED: Final = 3
"""Of these, how often the environment's best was the human model's best option."""
AGREED_WORST: Final = 4
"""Of these, how often it was the human model's worst."""
_COUNTS: Final = 5


class Timeline(NamedTuple):
    """The last steps of a session, in a ring of n places; step number s is at place s % n."""

    shown_ns: Ints
    """When the step came on screen, shape (n,)."""
    hidden_ns: Ints
    """When it went off; NEVER_NS while it is on, shape (n,)."""
    keeper: Ints
    """Who decided, shape (n,)."""
    option: Ints
    """What, shape (n,)."""
    windows: Ints
    """In which state: first active tile per variable, shape (n, v)."""
    counts: Ints
    """STEPS, EPISODE_STEPS, COMPARED, AGREED, AGREED_WORST, shape (5,)."""
    heard: Floats
    """Scratch: H of each option, shape (a,)."""
    available: Bools
    """Scratch: which options are ruled out: none, shape (a,)."""


class Mix(NamedTuple):
    """How environment and human are combined during one episode (`core.combination.config.EpisodeWeights`)."""

    form: int
    w_r: float
    w_h: float
    share: float
    share_seed: int


def new_timeline(places: int, n_variables: int, n_options: int) -> Timeline:
    """Return a time line without steps that remembers the last `places` ones."""
    return Timeline(
        shown_ns=np.zeros(places, np.int64),
        hidden_ns=np.zeros(places, np.int64),
        keeper=np.zeros(places, np.int64),
        option=np.zeros(places, np.int64),
        windows=np.zeros((places, n_variables), np.int64),
        counts=np.zeros(_COUNTS, np.int64),
        heard=np.zeros(n_options),
        available=np.zeros(n_options, np.bool_),
    )


@kernel
def play_until_press(
    match: Match,
    rules: Rules,
    sarsa: Sarsa,
    human: TiledHuman,
    mix: Mix,
    watcher: Watcher,
    timeline: Timeline,
    streams: Streams,
    anew: bool,
    start_ns: int,
    due_ns: int,
    limit: int,
) -> int:
    """Play until a press falls due or the episode ends.

    Args:
        match: the match, in place.
        rules: size of the game.
        sarsa: the keepers' learners, in place.
        human: the keepers' human models.
        mix: how the two are combined.
        watcher: who watches, in place.
        timeline: the steps, in place.
        streams: of the match.
        anew: set up the next episode first.
        start_ns: time at which the episode started.
        due_ns: when the next press falls due; NEVER_NS for none.
        limit: cycles after which the episode is stopped.

    Returns:
        PRESS_DUE: a press falls due before the cycle that comes next. ENDED, STOPPED: the episode is over.
    """
    if anew:
        start_episode(match, rules, streams.placement)
    while True:
        now_ns = start_ns + match.status[CYCLE] * CYCLE_NS
        if due_ns <= now_ns:
            return PRESS_DUE
        if begin_cycle(match, rules, streams):
            for i in range(rules.n_keepers):
                if match.deciding[i]:
                    _decide(match, sarsa, human, mix, timeline, i, streams.policy)
                    wanted = would_choose(watcher, match, rules, i)
                    step = _show(match, sarsa, timeline, i, now_ns)
                    planned_ns = watch_step(
                        watcher, wanted, match.actions[i], rules.n_keepers, step, now_ns
                    )
                    due_ns = min(due_ns, planned_ns)
        ended = finish_cycle(match, rules, streams)
        if ended or match.status[CYCLE] >= limit:
            end_episode(sarsa, match.status[CYCLE])
            _hide(timeline, start_ns + match.status[CYCLE] * CYCLE_NS)
            return ENDED if ended else STOPPED


@kernel
def _decide(
    match: Match,
    sarsa: Sarsa,
    human: TiledHuman,
    mix: Mix,
    timeline: Timeline,
    i: int,
    rng: np.random.Generator,
) -> None:
    """Choose keeper i's option by environment and human, and let Sarsa learn from the option that ended."""
    windows = timeline.windows[timeline.counts[STEPS] % len(timeline.option)]
    find_windows(sarsa.coder, match.variables[i], windows)
    before = 0.0
    if sarsa.last_time[i] != NOT_YET:
        before = last_value(sarsa, i)
    action_values(sarsa, i, windows, sarsa.values[i])
    preferred = _prefer(sarsa, human, mix, timeline, i, windows)
    if preferred < 0:
        option = greedy_or_random(sarsa.values[i], sarsa.exploration, rng)
    else:
        explore, pick = rng.random() < sarsa.exploration, rng.random()
        option = int(pick * len(timeline.heard)) if explore else preferred
    take_action(sarsa, i, windows, option, match.status[CYCLE], before)
    match.actions[i] = option


@kernel
def _prefer(sarsa: Sarsa, human: TiledHuman, mix: Mix, timeline: Timeline, i: int, windows: Ints) -> int:
    """Return the option that environment and human together prefer; -1 where the human has no say."""
    heard, n = timeline.heard, len(timeline.heard)
    heard[:] = 0.0
    if human.samples[0] > 0:
        human_values(human, i, windows, heard)
        liked = _compare(sarsa.values[i], timeline)
        if takes_control(mix.share_seed, timeline.counts[EPISODE_STEPS], mix.share):
            return liked
    if mix.w_h == 0.0:
        return -1
    return choose(sarsa.values[i], heard, timeline.available, n, mix.form, mix.w_r, mix.w_h)


@kernel
def _compare(values: Floats, timeline: Timeline) -> int:
    """Hold the environment's choice against the human model's; return the option that the latter likes best."""
    n = len(values)
    own = best_action(values, timeline.available, n)
    liked = best_action(timeline.heard, timeline.available, n)
    timeline.counts[COMPARED] += 1
    timeline.counts[AGREED] += own == liked
    timeline.counts[AGREED_WORST] += own == worst_action(timeline.heard, timeline.available, n)
    return liked


@kernel
def _show(match: Match, sarsa: Sarsa, timeline: Timeline, i: int, now_ns: int) -> int:
    """Bring keeper i's decision on screen in place of the step before; return its number."""
    step = timeline.counts[STEPS]
    if timeline.counts[EPISODE_STEPS] > 0:
        timeline.hidden_ns[(step - 1) % len(timeline.option)] = now_ns
    place = step % len(timeline.option)
    timeline.shown_ns[place], timeline.hidden_ns[place] = now_ns, NEVER_NS
    timeline.keeper[place], timeline.option[place] = i, match.actions[i]
    timeline.counts[STEPS] += 1
    timeline.counts[EPISODE_STEPS] += 1
    return int(step)


@kernel
def _hide(timeline: Timeline, now_ns: int) -> None:
    if timeline.counts[EPISODE_STEPS] > 0:
        timeline.hidden_ns[(timeline.counts[STEPS] - 1) % len(timeline.option)] = now_ns


@kernel
def learn_from_press(
    human: TiledHuman, timeline: Timeline, first: int, shares: Floats, value: float
) -> None:
    """Let every keeper learn from its steps' shares of a press.

    Args:
        human: the models, in place.
        timeline: the steps.
        first: number of the first step that may have a share.
        shares: share of that step and of those after it, shape (m,).
        value: what the press says.
    """
    for k in range(len(shares)):
        if shares[k] > 0.0:
            place = (first + k) % len(timeline.option)
            learn_sample(
                human,
                timeline.keeper[place],
                timeline.windows[place],
                timeline.option[place],
                value,
                min(shares[k], 1.0),
            )
