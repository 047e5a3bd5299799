"""A simulated participant of Keepaway in compiled code: `core.feedback.trainers` for the steps of a match.

The arithmetic and the draws of a step are those of `SimulatedTrainer.watch`, the number of a step being that
in its episode. Only delays come from another stream: one per episode, for its judgements in turn, since
setting up a Generator for each judgement would take longer than the step.
"""

from typing import Final, NamedTuple

import numpy as np

from core.feedback.config import TrainerConfig
from core.feedback.delays import one_density
from core.feedback.trainers import SimulatedTrainer, draw_delay_s, judgement
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_NS, CYCLE_S, Rules
from core.keepaway.presses import JUDGED, Presses, plan
from core.keepaway.simulator.match import Match
from core.keepaway.simulator.policies import hand_coded
from core.keepaway.simulator.variables import observe
from core.numerics.arrays import Floats, Ints
from core.numerics.clock import NS_PER_S
from core.numerics.compiled import inner_kernel
from core.numerics.streams import stream

LAY_DANGER_M: Final = 4.0
"""A lay participant passes when a taker is nearer than this."""
N_DRAWS: Final = 6
"""Draws about a step."""


class Judge(NamedTuple):
    """A participant during one episode, as kernels see it."""

    lay: bool
    """Whether the lay choice is what they would choose, not the hand-coded policy's."""
    exact: bool
    """Whether they go by the exact state, not by what the keeper sees."""
    pass_chance: float
    """Chance to judge a pass."""
    hold_chance: float
    """Chance to judge one cycle of holding."""
    if_wanted: float
    """What they think of the option they would have chosen: 1.0 good, -1.0 bad, 0.0 nothing to say."""
    if_not: float
    """What they think of any other."""
    mistake_rate: float
    deliberate_rate: float
    anticipation_rate: float
    burst_rate: float
    burst_presses: int
    burst_interval_ns: int
    delays_ns: Ints
    """Delay of each judgement of the episode: as many as there can be."""
    draws: Floats
    """Draws about the first m steps of the episode (`SimulatedTrainer.draws`), shape (m, 6)."""
    variables: Floats
    """Scratch, shape (v,)."""
    order: Ints
    """Scratch, shape (n,)."""


def new_judge(config: KeepawayPersonConfig, match: Match) -> Judge:
    """Return a participant who sees nothing yet; `watch_episode` lets an episode begin."""
    trainer, n_options = config.trainer, len(match.deciding)
    return Judge(
        lay=trainer.knowledge == "lay",
        exact=config.sees == "everything",
        pass_chance=0.0,
        hold_chance=0.0,
        if_wanted=_opinion(trainer, n_options, 0),
        if_not=_opinion(trainer, n_options, 1),
        mistake_rate=float(trainer.mistake_rate),
        deliberate_rate=float(trainer.deliberate_rate),
        anticipation_rate=float(trainer.anticipation_rate),
        burst_rate=float(trainer.burst_rate),
        burst_presses=int(trainer.burst_presses),
        burst_interval_ns=round(trainer.burst_interval_s * NS_PER_S),
        delays_ns=np.zeros(0, np.int64),
        draws=np.zeros((0, N_DRAWS)),
        variables=np.zeros(match.variables.shape[1]),
        order=np.zeros(len(match.players), np.int64),
    )


def watch_episode(
    judge: Judge, config: KeepawayPersonConfig, trainer: SimulatedTrainer, *, root_seed: int, episode: int
) -> Judge:
    """Return the participant at the beginning of an episode, which `trainer` has begun, too.

    Args:
        judge: before.
        config: what kind of participant.
        trainer: gives chances, budget and the draws about steps.
        root_seed: of the session; stream "trainer delays".
        episode: its number, >= 0.
    """
    rng = stream(root_seed, "trainer delays", episode)
    delay = one_density(config.trainer.delay)
    delays_s = [draw_delay_s(delay, rng=rng) for _ in range(trainer.judgements_left)]
    probability = trainer.press_probability
    return judge._replace(
        pass_chance=float(probability),
        hold_chance=float(probability * noticed_per_cycle(config.holds_noticed_per_s)),
        delays_ns=np.array([round(delay_s * NS_PER_S) for delay_s in delays_s], np.int64),
        draws=np.ascontiguousarray(trainer.draws(0)),
    )


def with_more_draws(judge: Judge, trainer: SimulatedTrainer) -> Judge:
    """Return the participant with the draws about some more steps."""
    return judge._replace(draws=np.concatenate([judge.draws, trainer.draws(len(judge.draws))]))


def _opinion(trainer: TrainerConfig, n_options: int, option: int) -> float:
    """Return what they think of an option where option 0 is the one they would have chosen; 0.0 for
    nothing.
    """
    values = np.zeros(n_options)
    values[0] = 1.0
    believed = judgement(
        values,
        option,
        good_share=trainer.good_share,
        skip_margin=trainer.skip_margin,
        equal_margin=trainer.equal_margin,
    )
    return 0.0 if believed is None else believed


def noticed_per_cycle(per_s: float) -> float:
    """Return the chance per cycle that makes up a chance per second."""
    return float(1.0 - (1.0 - per_s) ** CYCLE_S)


@inner_kernel
def would_choose(judge: Judge, match: Match, rules: Rules, i: int) -> int:
    """Return the option the participant would have chosen in place of keeper i, which decides."""
    variables = match.variables[i]
    if judge.exact:
        observe(i, match.players, rules.n_keepers, judge.order, judge.variables)
        variables = judge.variables
    if judge.lay:
        wanted = lay_choice(variables, rules.n_keepers, rules.n_takers)
    else:
        wanted = hand_coded(variables, rules.n_keepers, rules.n_takers)
    if judge.exact and wanted > 0:
        # Options count mates by the keeper's own order, which may differ from the true one.
        for option in range(1, rules.n_keepers):
            if match.order[i, option] == judge.order[wanted]:
                return option
    return wanted


@inner_kernel
def lay_choice(variables: Floats, n_keepers: int, n_takers: int) -> int:
    """Return what a lay participant would do: pass to the mate farthest from all takers when one is near,
    else hold.
    """
    if variables[n_keepers] > LAY_DANGER_M:
        return 0
    base = 1 + 2 * (n_keepers - 1 + n_takers)
    best = 1
    for option in range(2, n_keepers):
        if variables[base + option - 1] > variables[base + best - 1]:
            best = option
    return best


@inner_kernel
def watch_step(
    judge: Judge,
    presses: Presses,
    wanted: int,
    option: int,
    episode_step: int,
    step: int,
    shown_ns: int,
) -> None:
    """Let the participant see a step, and plan to press keys if it has something to say.

    Args:
        judge: the participant.
        presses: where plans are put.
        wanted: the option it would have chosen.
        option: the one chosen.
        episode_step: number of the step in its episode; there must be draws for it.
        step: number of the step in the session.
        shown_ns: when it came on screen. What was chosen is seen one cycle later.
    """
    judged = presses.counts[JUDGED]
    if judged >= len(judge.delays_ns):
        return
    draws = judge.draws[episode_step]
    if draws[0] >= (judge.pass_chance if option > 0 else judge.hold_chance):
        return
    value = judge.if_wanted if option == wanted else judge.if_not
    if value == 0.0:
        return
    deliberate = draws[2] < judge.deliberate_rate
    if deliberate or draws[1] < judge.mistake_rate:
        value = -value
    if draws[3] < judge.anticipation_rate:
        first_ns = shown_ns + int(np.rint(draws[5] * CYCLE_NS))
    else:
        first_ns = shown_ns + CYCLE_NS + judge.delays_ns[judged]
    presses.counts[JUDGED] += 1
    for k in range(judge.burst_presses if draws[4] < judge.burst_rate else 1):
        plan(presses, first_ns + k * judge.burst_interval_ns, value, step, deliberate)
