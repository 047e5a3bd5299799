"""Compiled play of keepers that learn from their environment and from a participant: whole episodes, presses
included.

Steps, intervals and decisions are those of a session: a step is the decision of a keeper, on screen until the
next one by any keeper or the end of the episode; presses reach back over all of them.
"""

from typing import Final, NamedTuple

import numpy as np

from core.combination.preference import KernelWeights, choose, takes_control
from core.combination.tally import Tally, compare_choices, new_tally
from core.feedback.compiled_credit import CreditRule, share_out
from core.keepaway.participant import Judge, watch_step, would_choose
from core.keepaway.pitch import CYCLE_NS, Rules
from core.keepaway.presses import MADE, NEVER_NS, Presses, is_due, make
from core.keepaway.simulator.game import begin_cycle, finish_cycle
from core.keepaway.simulator.match import CYCLE, Match, Streams, start_episode
from core.learners.human_sets import HumanSet, human_values, learn_sample
from core.learners.sarsa import (
    NOT_YET,
    Sarsa,
    action_values,
    end_episode,
    forget_episode,
    greedy_or_random,
    last_value,
    learn_beside,
    take_action,
)
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.compiled import called_kernel, inner_kernel, kernel
from core.numerics.tile_coding import find_windows

# What `play` returns.
ENDED: Final = 0
STOPPED: Final = 1
"""The episode reached the limit of cycles."""
NEEDS_DRAWS: Final = 2
"""The participant has no draws for the next cycle's steps: give more, and call again."""

# Entries of `Timeline.counts`.
STEPS: Final = 0
"""Steps since the session began."""
EPISODE_STEPS: Final = 1
"""Steps of this episode."""
_COUNTS: Final = 2

# Entries of `Timeline.masses`: where the mass of the session's presses went.
PRESSES: Final = 0
"""Presses that counted."""
CREDITED: Final = 1
BEFORE_FIRST: Final = 2
IN_GAPS: Final = 3
_MASSES: Final = 4


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
    """STEPS, EPISODE_STEPS, shape (2,)."""
    tally: Tally
    """Agreement in the decisions of this episode made while the human model knew something
    (`core.combination.tally`)."""
    masses: Floats
    """PRESSES, CREDITED, BEFORE_FIRST, IN_GAPS, shape (4,)."""
    shares: Floats
    """Scratch: share of each step of a press, by place, shape (n,)."""
    h_values: Floats
    """Scratch: H of each option, shape (a,)."""
    available: Bools
    """Scratch: which options are ruled out: none, shape (a,)."""


class Mix(NamedTuple):
    """How environment and participant are combined during one episode
    (`core.combination.config.EpisodeWeights`).
    """

    weights: KernelWeights
    handover_seed: int
    sets: int
    """How many sets of learners there are, one learner per keeper each: 1, or one set per attitude
    (`SideBySide`)."""
    playing: int
    """The set that chooses; the others look on."""
    w_h_of: tuple[float, ...]
    """w_h of each set; three numbers also where there is one set."""


class Span(NamedTuple):
    """When an episode is played."""

    start_ns: int
    """Time at which it started."""
    pause_ns: int
    """How long its last picture is shown."""
    limit: int
    """Cycles after which it is stopped."""


def new_timeline(places: int, n_variables: int, n_options: int) -> Timeline:
    """Return a time line without steps that remembers the last `places` ones."""
    return Timeline(
        shown_ns=np.zeros(places, np.int64),
        hidden_ns=np.zeros(places, np.int64),
        keeper=np.zeros(places, np.int64),
        option=np.zeros(places, np.int64),
        windows=np.zeros((places, n_variables), np.int64),
        counts=np.zeros(_COUNTS, np.int64),
        tally=new_tally(),
        masses=np.zeros(_MASSES),
        shares=np.zeros(places),
        h_values=np.zeros(n_options),
        available=np.zeros(n_options, np.bool_),
    )


@kernel
def play(
    match: Match,
    rules: Rules,
    sarsa: Sarsa,
    human: HumanSet,
    mix: Mix,
    judge: Judge,
    presses: Presses,
    rule: CreditRule,
    timeline: Timeline,
    streams: Streams,
    span: Span,
    anew: bool,
) -> int:
    """Play to the end of the episode and of the pause after it.

    Args:
        match: the match, in place.
        rules: size of the game.
        sarsa: the keepers' learners, in place.
        human: the keepers' human models, in place.
        mix: how the two are combined.
        judge: the simulated participant.
        presses: of the participant, in place.
        rule: how presses are credited.
        timeline: the steps, in place.
        streams: of the match.
        span: when the episode is played.
        anew: set up the next episode first.

    Returns:
        ENDED or STOPPED: the episode is over. NEEDS_DRAWS: it is not.
    """
    if anew:
        start_episode(match, rules, streams.placement)
    counts = timeline.counts
    while True:
        if counts[EPISODE_STEPS] + rules.n_keepers > len(judge.draws) and len(judge.delays_ns) > 0:
            return NEEDS_DRAWS
        now_ns = span.start_ns + match.status[CYCLE] * CYCLE_NS
        while is_due(presses, now_ns):
            _press(human, presses, rule, timeline)
        if begin_cycle(match, rules, streams):
            for i in range(rules.n_keepers):
                if match.deciding[i]:
                    _decide(match, sarsa, human, mix, timeline, i, streams.policy)
                    _show(match, timeline, i, now_ns)
                    _watch(match, rules, judge, presses, counts, i, now_ns)
        ended = finish_cycle(match, rules, streams)
        if ended or match.status[CYCLE] >= span.limit:
            break
    if ended:
        end_episode(sarsa, match.status[CYCLE])
    else:
        forget_episode(sarsa)
    end_ns = span.start_ns + match.status[CYCLE] * CYCLE_NS
    if counts[EPISODE_STEPS] > 0:
        timeline.hidden_ns[(counts[STEPS] - 1) % len(timeline.option)] = end_ns
    while is_due(presses, end_ns + span.pause_ns):
        _press(human, presses, rule, timeline)
    return ENDED if ended else STOPPED


@inner_kernel
def _watch(
    match: Match, rules: Rules, judge: Judge, presses: Presses, counts: Ints, i: int, now_ns: int
) -> None:
    """Let the participant watch keeper i's decision, which has just come on screen."""
    wanted = would_choose(judge, match, rules, i)
    step_of_episode, step = counts[EPISODE_STEPS] - 1, counts[STEPS] - 1
    watch_step(judge, presses, wanted, match.actions[i], step_of_episode, step, now_ns)


@called_kernel
def _decide(
    match: Match,
    sarsa: Sarsa,
    human: HumanSet,
    mix: Mix,
    timeline: Timeline,
    i: int,
    rng: np.random.Generator,
) -> None:
    """Choose keeper i's option by environment and participant, and let Sarsa learn from the option that
    ended.
    """
    windows = timeline.windows[timeline.counts[STEPS] % len(timeline.option)]
    find_windows(sarsa.coder, match.variables[i], windows)
    n_keepers = len(match.deciding)
    k = mix.playing * n_keepers + i
    before = _value_before(sarsa, k, windows)
    preferred = _prefer(sarsa.values[k], human, mix, timeline, i, windows)
    if preferred < 0:
        option = greedy_or_random(sarsa.values[k], sarsa.exploration, rng)
    else:
        explore, pick = rng.random() < sarsa.exploration, rng.random()
        option = int(pick * len(timeline.h_values)) if explore else preferred
    time = match.status[CYCLE]
    take_action(sarsa, k, windows, option, time, before)
    for looking_on in range(mix.sets):
        if looking_on != mix.playing:
            other = looking_on * n_keepers + i
            before = _value_before(sarsa, other, windows)
            own = choose(
                sarsa.values[other],
                timeline.h_values,
                timeline.available,
                len(timeline.h_values),
                mix.weights.form,
                mix.weights.w_r,
                mix.w_h_of[looking_on],
            )
            learn_beside(sarsa, other, windows, option, own, time, before)
    match.actions[i] = option


@inner_kernel
def _value_before(sarsa: Sarsa, k: int, windows: Ints) -> float:
    """Write learner k's values of the present state; return that of its ended option, 0 where there is
    none.
    """
    before = 0.0
    if sarsa.last_time[k] != NOT_YET:
        before = last_value(sarsa, k)
    action_values(sarsa, k, windows, sarsa.values[k])
    return before


@inner_kernel
def _prefer(values: Floats, human: HumanSet, mix: Mix, timeline: Timeline, i: int, windows: Ints) -> int:
    """Return the option that environment and participant together prefer; -1 where the participant has no
    say.
    """
    weights, h_values, n = mix.weights, timeline.h_values, len(timeline.h_values)
    h_values[:] = 0.0
    if human.samples[0] > 0:
        human_values(human, i, windows, h_values)
        human_best = compare_choices(values, h_values, timeline.available, n, timeline.tally)
        if takes_control(mix.handover_seed, timeline.counts[EPISODE_STEPS], weights.handover):
            return human_best
    if weights.w_h == 0.0:
        return -1
    return choose(values, h_values, timeline.available, n, weights.form, weights.w_r, weights.w_h)


@inner_kernel
def _show(match: Match, timeline: Timeline, i: int, now_ns: int) -> None:
    """Bring keeper i's decision on screen in place of the step before."""
    step = timeline.counts[STEPS]
    if timeline.counts[EPISODE_STEPS] > 0:
        timeline.hidden_ns[(step - 1) % len(timeline.option)] = now_ns
    place = step % len(timeline.option)
    timeline.shown_ns[place], timeline.hidden_ns[place] = now_ns, NEVER_NS
    timeline.keeper[place], timeline.option[place] = i, match.actions[i]
    timeline.counts[STEPS] += 1
    timeline.counts[EPISODE_STEPS] += 1


@called_kernel
def _press(human: HumanSet, presses: Presses, rule: CreditRule, timeline: Timeline) -> None:
    """Make the press that is due; if it counts, every keeper learns from its steps' shares of it."""
    if not make(presses):
        return
    made = presses.counts[MADE] - 1
    n_steps, shares, masses = timeline.counts[STEPS], timeline.shares, timeline.masses
    first, before_first, in_gaps = share_out(
        rule, presses.made_ns[made], timeline.shown_ns, timeline.hidden_ns, n_steps, shares
    )
    masses[PRESSES] += 1.0
    masses[BEFORE_FIRST] += before_first
    masses[IN_GAPS] += in_gaps
    for step in range(first, n_steps):
        place = step % len(timeline.option)
        if shares[place] > 0.0:
            masses[CREDITED] += shares[place]
            learn_sample(
                human,
                timeline.keeper[place],
                timeline.windows[place],
                timeline.option[place],
                presses.made_value[made],
                min(shares[place], 1.0),
            )
