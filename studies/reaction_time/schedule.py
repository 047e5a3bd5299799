"""Make a schedule from configuration and seed, and print it as text before a participant begins."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from core.numerics.streams import stream
from studies.reaction_time.protocol import BlockPlan, Foreperiod, Schedule, TaskConfig, TrialPlan
from studies.reaction_time.tasks import ALLOWED_KEYS, MAKERS, WORDS, Material


def make_schedule(config: TaskConfig, root_seed: int) -> Schedule:
    """Return the schedule of one task: a practice block (if any), then scored blocks.

    Args:
        config: the task.
        root_seed: seed of the session; equal seeds give equal schedules.
    """
    counts = [config.n_practice] if config.n_practice else []
    n_blocks = math.ceil(config.n_trials / config.trials_per_block)
    # Scored trials are spread evenly: 50 trials in blocks of at most 20 are 17, 17 and 16.
    counts += [len(part) for part in np.array_split(np.arange(config.n_trials), n_blocks)]
    blocks: list[BlockPlan] = []
    first = 0
    unstudied = [str(word) for word in stream(root_seed, "reaction-time words").permutation(WORDS)]
    for index, n in enumerate(counts):
        studied: tuple[str, ...] = ()
        if config.task == "recognition":  # each block has words of its own, as long as there are any
            start = index * config.n_studied % (len(unstudied) - config.n_studied + 1)
            studied = tuple(unstudied[start : start + config.n_studied])
        rng = stream(root_seed, "reaction-time trials", config.task, index)
        practice = bool(config.n_practice) and index == 0
        trials = _trials(config, n, first, studied, rng)
        blocks.append(BlockPlan(index=index, practice=practice, trials=trials, study_items=studied))
        first += n
    return Schedule(
        config=config, root_seed=root_seed, allowed_keys=ALLOWED_KEYS[config.task], blocks=tuple(blocks)
    )


def draw_foreperiods(foreperiod: Foreperiod, n: int, *, rng: np.random.Generator) -> np.ndarray:
    """Return n foreperiods in seconds: least_s plus an exponential truncated at most_s (inverse
    distribution).
    """
    room = (foreperiod.most_s - foreperiod.least_s) / foreperiod.mean_extra_s
    fraction = rng.random(n) * -np.expm1(-room)
    return np.asarray(foreperiod.least_s - foreperiod.mean_extra_s * np.log1p(-fraction))


def describe(schedule: Schedule) -> str:
    """Return the dry run: what would happen, trial by trial, and how long it takes."""
    config = schedule.config
    lines = [
        (
            f"{config.task}: {len(schedule.trials)} trials in {len(schedule.blocks)} blocks, "
            f"seed {schedule.root_seed}, keys {' '.join(schedule.allowed_keys)}, "
            f"about {expected_minutes(schedule):.1f} min"
        )
    ]
    for block in schedule.blocks:
        kinds = Counter("catch" if trial.catch else trial.condition for trial in block.trials)
        summary = ", ".join(f"{count} x {kind}" for kind, count in sorted(kinds.items()))
        lines.append(f"block {block.index}{' (practice)' if block.practice else ''}: {summary}")
        if block.study_items:
            lines.append(f"  study: {' '.join(block.study_items)}")
        lines += [f"  {_line(trial)}" for trial in block.trials]
        if block is not schedule.blocks[-1]:
            lines.append("  -- break --")
    return "\n".join(lines) + "\n"


def expected_minutes(schedule: Schedule) -> float:
    """Return the expected length in minutes without breaks: foreperiods, study, half a second per
    response.
    """
    config = schedule.config
    total = 0.0
    for block in schedule.blocks:
        total += config.study_item_s * len(block.study_items)
        for trial in block.trials:
            waiting = 0.5 if trial.expected_keys else config.time_out_s
            total += trial.foreperiod_s + waiting + config.study_item_s * len(trial.study_items)
    return total / 60.0


def _trials(
    config: TaskConfig, n: int, first: int, studied: Sequence[str], rng: np.random.Generator
) -> tuple[TrialPlan, ...]:
    make = MAKERS[config.task]
    n_catch = 0 if config.task == "go/no-go" else round(config.catch_rate * n)
    shown = [(material, False) for material in make(config, n - n_catch, studied, rng)]
    # A catch trial begins like any other (same items to remember), only its stimulus never comes.
    caught = [(material, True) for material in make(config, n_catch, studied, rng)]
    material = shown + caught
    order = rng.permutation(n)
    foreperiods = draw_foreperiods(config.foreperiod, n, rng=rng)
    return tuple(
        _plan(first + position, float(foreperiods[position]), *material[int(which)])
        for position, which in enumerate(order)
    )


def _plan(index: int, foreperiod_s: float, material: Material, catch: bool) -> TrialPlan:
    return TrialPlan(
        index=index,
        foreperiod_s=foreperiod_s,
        stimulus="" if catch else material.stimulus,
        condition="catch" if catch else material.condition,
        expected_keys=() if catch else material.expected_keys,
        study_items=material.study_items,
        catch=catch,
    )


def _line(trial: TrialPlan) -> str:
    shown = trial.stimulus.replace("\n", "|") if trial.stimulus else "(nothing)"
    items = f" after {' '.join(trial.study_items)}" if trial.study_items else ""
    keys = " or ".join(trial.expected_keys) or "no key"
    return f"{trial.index:3d}  {trial.foreperiod_s:5.3f} s  {shown}{items}  [{trial.condition}] -> {keys}"
