"""A simulated participant of Keepaway in compiled code: `core.feedback.trainers` for steps of a match.

The arithmetic is that of `SimulatedTrainer.watch`. Only the streams differ: there every step has a Generator of
its own, which costs more than the step; here the draws of an episode come from one, six for each step whether
they are needed or not, and its delays from another. So what is drawn for the n-th step of an episode does not depend on
the play.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from core.clock import NS_PER_S
from core.compiled import kernel
from core.feedback.config import TrainerConfig
from core.feedback.trainers import draw_delay_s
from core.keepaway.match import Match
from core.keepaway.person_config import KeepawayPersonConfig, Knowledge
from core.keepaway.pitch import CYCLE_NS, CYCLE_S, Rules
from core.keepaway.policies import hand_coded
from core.keepaway.variables import observe
from core.streams import stream

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

AS_SEEN: Final = 0
EXACT: Final = 1
LAY: Final = 2
_KNOWLEDGE: Final[dict[Knowledge, int]] = {"as-seen": AS_SEEN, "exact": EXACT, "lay": LAY}
LAY_DANGER_M: Final = 4.0
"""A lay person passes when a taker is nearer than this."""
NEVER_NS: Final = (1 << 63) - 1
"""Time of a press that nobody plans."""

# Entries of `Watcher.tally`.
JUDGED: Final = 0
"""Judgements in this episode."""
PLANNED: Final = 1
"""Presses in the `planned_` arrays."""


class Watcher(NamedTuple):
    """A participant during one episode, as kernels see it; p presses at most can be planned in an episode."""

    rng: np.random.Generator
    knowledge: int
    """AS_SEEN, EXACT or LAY."""
    pass_chance: float
    """Chance to judge a pass."""
    hold_chance: float
    """Chance to judge one cycle of holding."""
    good_share: float
    skip_margin: float
    mistake_rate: float
    deliberate_rate: float
    anticipation_rate: float
    burst_rate: float
    burst_presses: int
    burst_interval_ns: int
    delays_ns: Ints
    """Delay of each judgement of the episode: its length is the episode's budget of judgements."""
    tally: Ints
    """JUDGED, PLANNED, shape (2,)."""
    planned_ns: Ints
    """When presses will be made, in the order of planning, shape (p,)."""
    planned_values: Floats
    """1.0 good, -1.0 bad, shape (p,)."""
    planned_steps: Ints
    """Which step each is about, shape (p,)."""
    planned_deliberate: Bools
    """Whether it is wrong on purpose, shape (p,)."""
    variables: Floats
    """Scratch, shape (v,)."""
    order: Ints
    """Scratch, shape (n,)."""


def new_watcher(config: KeepawayPersonConfig, match: Match) -> Watcher:
    """Return a participant who has not seen an episode yet; `watch_episode` lets one begin."""
    trainer = config.trainer
    most = trainer.max_presses * trainer.burst_presses
    return Watcher(
        rng=stream(0, "nobody watches"),
        knowledge=_KNOWLEDGE[config.knowledge],
        pass_chance=0.0,
        hold_chance=0.0,
        good_share=float(trainer.good_share),
        skip_margin=float(trainer.skip_margin),
        mistake_rate=float(trainer.mistake_rate),
        deliberate_rate=float(trainer.deliberate_rate),
        anticipation_rate=float(trainer.anticipation_rate),
        burst_rate=float(trainer.burst_rate),
        burst_presses=int(trainer.burst_presses),
        burst_interval_ns=round(trainer.burst_interval_s * NS_PER_S),
        delays_ns=np.zeros(trainer.max_presses, np.int64),
        tally=np.zeros(2, np.int64),
        planned_ns=np.zeros(most, np.int64),
        planned_values=np.zeros(most),
        planned_steps=np.zeros(most, np.int64),
        planned_deliberate=np.zeros(most, np.bool_),
        variables=np.zeros(match.variables.shape[1]),
        order=np.zeros(len(match.players), np.int64),
    )


def watch_episode(
    watcher: Watcher, config: KeepawayPersonConfig, press_probability: float, *, root_seed: int, episode: int
) -> Watcher:
    """Return the participant at the beginning of an episode, with its budget and its draws.

    Args:
        watcher: before; its arrays are used on.
        config: what kind of participant.
        press_probability: chance to judge a pass in this episode, after fatigue
            (`SimulatedTrainer.press_probability`).
        root_seed: of the session; streams "trainer" and "trainer delays".
        episode: its number, >= 0.
    """
    watcher.tally[:] = 0
    watcher.delays_ns[:] = delays_of_episode(config.trainer, root_seed=root_seed, episode=episode)
    return watcher._replace(
        rng=stream(root_seed, "trainer", episode),
        pass_chance=float(press_probability),
        hold_chance=float(press_probability * noticed_per_cycle(config.holds_noticed_per_s)),
    )


def delays_of_episode(config: TrainerConfig, *, root_seed: int, episode: int) -> list[int]:
    """Return the delays of an episode's judgements in nanoseconds, shape (max_presses,)."""
    rng = stream(root_seed, "trainer delays", episode)
    return [round(draw_delay_s(config.delay, rng=rng) * NS_PER_S) for _ in range(config.max_presses)]


def noticed_per_cycle(per_s: float) -> float:
    """Return the chance per cycle that makes up a chance per second."""
    return float(1.0 - (1.0 - per_s) ** CYCLE_S)


@kernel
def would_choose(watcher: Watcher, match: Match, rules: Rules, i: int) -> int:
    """Return the option the participant would have chosen in place of keeper i, which decides."""
    variables = match.variables[i]
    if watcher.knowledge == EXACT:
        observe(i, match.players, rules.n_keepers, watcher.order, watcher.variables)
        variables = watcher.variables
    if watcher.knowledge == LAY:
        return _lay_choice(variables, rules.n_keepers, rules.n_takers)
    wanted = hand_coded(variables, rules.n_keepers, rules.n_takers)
    if watcher.knowledge == EXACT and wanted > 0:
        # Options count mates by the keeper's own order, which may differ from the true one.
        for option in range(1, rules.n_keepers):
            if match.order[i, option] == watcher.order[wanted]:
                return option
    return wanted


@kernel
def _lay_choice(variables: Floats, n_keepers: int, n_takers: int) -> int:
    if variables[n_keepers] > LAY_DANGER_M:
        return 0
    base = 1 + 2 * (n_keepers - 1 + n_takers)
    best = 1
    for option in range(2, n_keepers):
        if variables[base + option - 1] > variables[base + best - 1]:
            best = option
    return best


@kernel
def watch_step(watcher: Watcher, wanted: int, option: int, n_options: int, step: int, shown_ns: int) -> int:
    """Let the participant see a step; presses it plans are appended to the `planned_` arrays.

    Args:
        watcher: the participant, in place; six draws.
        wanted: the option it would have chosen.
        option: the one chosen.
        n_options: how many there are.
        step: number of the step.
        shown_ns: when it came on screen.

    Returns:
        Time of the first press planned; NEVER_NS for none.
    """
    rng = watcher.rng
    speaks, mistakes, deliberates = rng.random(), rng.random(), rng.random()
    anticipates, bursts, moment = rng.random(), rng.random(), rng.random()
    judged = watcher.tally[JUDGED]
    if judged >= len(watcher.delays_ns):
        return NEVER_NS
    if speaks >= (watcher.pass_chance if option > 0 else watcher.hold_chance):
        return NEVER_NS
    better = 0.0 if option == wanted else 1.0 / n_options
    if abs(better - watcher.good_share) < watcher.skip_margin:
        return NEVER_NS
    value = 1.0 if better < watcher.good_share else -1.0
    deliberate = deliberates < watcher.deliberate_rate
    if deliberate or mistakes < watcher.mistake_rate:
        value = -value
    if anticipates < watcher.anticipation_rate:
        first_ns = shown_ns + int(np.rint(moment * CYCLE_NS))
    else:
        first_ns = shown_ns + CYCLE_NS + watcher.delays_ns[judged]
    watcher.tally[JUDGED] += 1
    for k in range(watcher.burst_presses if bursts < watcher.burst_rate else 1):
        place = watcher.tally[PLANNED]
        watcher.planned_ns[place] = first_ns + k * watcher.burst_interval_ns
        watcher.planned_values[place] = value
        watcher.planned_steps[place] = step
        watcher.planned_deliberate[place] = deliberate
        watcher.tally[PLANNED] += 1
    return int(first_ns)
