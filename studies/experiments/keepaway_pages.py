"""What the pages of experiments in Keepaway share: scores of trials, figures over simulated time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from core.combination.config import Scheme
from core.combination.schedule import EpisodesSoFar, next_episode
from core.numerics.arrays import Floats
from studies.experiments import page
from studies.experiments.keepaway_trial import mean_by_time
from studies.experiments.page import Page
from studies.experiments.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Claim = tuple[str, str, str]
"""(better condition, worse condition, in words)."""

BINS = 40
"""Points of a curve."""
WINDOW = 5
"""Points of a curve over which its running mean goes: published curves are smoothed as well."""
SCORE = "seconds per episode, over the whole trial"
SCORES_TEXT = """\
The score of a trial is the mean over simulated time of how long episodes lasted: the area under its learning curve (40 equal parts). It
was chosen before the trials were played. The last tenth of the time is given as well.
"""  # noqa: E501


def by_time(results: Results, condition: str, column: str, bins: int = BINS) -> Floats:
    """Return a column's means over equal parts of the shortest trial's simulated time, shape (trials,
    bins).
    """
    hours = _hours(results)
    return np.array([mean_by_time(trial, column, hours, bins) for trial in results.trials[condition]])


def by_episode(results: Results, condition: str, column: str, bins: int = BINS) -> tuple[Floats, Floats]:
    """Return a column's means over equal blocks of episodes, up to the fewest episodes that any trial has.

    Returns:
        The last episode of each block, shape (bins,), and the means, shape (trials, bins); fewer bins than
        asked for where there are fewer episodes.
    """
    fewest = min(len(trial[column]) for trials in results.trials.values() for trial in trials)
    bins = min(bins, fewest)
    block = fewest // bins
    means = [
        trial[column][: bins * block].reshape(bins, block).mean(axis=1) for trial in results.trials[condition]
    ]
    return np.asarray(block * (np.arange(bins) + 1.0), np.float64), np.array(means)


def weights_used(results: Results, condition: str, bins: int = 10) -> Floats:
    """Return the mean w_h that choices were made with over equal parts of simulated time, shape (trials,
    bins).

    Files hold the trust of bootstrap learning, which some schemes do not go by. (Of a scheme that never asks
    about trust, episodes before the first press count as well, when there was nobody to listen to.)
    """
    scheme = results.experiment.condition(condition).settings.play.agent.scheme
    hours = _hours(results)
    return np.array(
        [
            mean_by_time({**trial, "used": _used(scheme, trial["w_h"])}, "used", hours, bins)
            for trial in results.trials[condition]
        ]
    )


def _used(scheme: Scheme, trust: Floats) -> Floats:
    scheduled = [
        next_episode(scheme, EpisodesSoFar(k, k)).scheduled for k in range(len(trust))
    ]  # all are watched
    return np.array([scheme.episode_weights(float(t), k).w_h for t, k in zip(trust, scheduled, strict=True)])


def scores(results: Results) -> dict[str, Floats]:
    """Return the score of each trial, by the condition's label."""
    return {
        results.label(name): by_time(results, name, "seconds").mean(axis=1) for name in results.conditions
    }


def last_tenth(results: Results) -> dict[str, Floats]:
    """Return mean durations at the end of each trial, by the condition's label."""
    return {results.label(name): by_time(results, name, "seconds", 10)[:, -1] for name in results.conditions}


def smooth(curves: Floats, window: int = WINDOW) -> Floats:
    """Return running means over up to `window` points up to each point, shape (trials, n)."""
    sums = np.cumsum(np.pad(curves, ((0, 0), (1, 0))), axis=1)
    ends = np.arange(1, curves.shape[1] + 1)
    starts = np.maximum(ends - window, 0)
    return np.asarray((sums[:, ends] - sums[:, starts]) / (ends - starts))


def curves_figure(results: Results) -> Figure:
    """Draw durations against simulated time and against episodes, and w_h against simulated time."""
    figure = page.new_figure(7.2, 6.0)
    (by_hours, by_episodes), (weights, words) = figure.subplots(2, 2)
    hours = _hours(results) * (np.arange(BINS) + 1.0) / BINS
    for axes, column in ((by_hours, "seconds"), (weights, "w_h")):
        curves = {results.label(n): smooth(by_time(results, n, column)) for n in results.conditions}
        page.draw_curves(axes, hours, curves)
        axes.set_xlabel("simulated hours")
    blocks = {n: by_episode(results, n, "seconds") for n in results.conditions}
    episodes = next(iter(blocks.values()))[0]
    page.draw_curves(
        by_episodes, episodes, {results.label(n): smooth(block[1]) for n, block in blocks.items()}
    )
    by_episodes.set_xlabel("episodes")
    for axes in (by_hours, by_episodes):
        axes.set_ylabel("seconds per episode")
        axes.set_ylim(bottom=0.0)
    weights.set_ylabel("weight of the human, $w_h$")
    words.axis("off")
    words.legend(*by_hours.get_legend_handles_labels(), loc="center", frameon=False, fontsize="small")
    return figure


def report_page(
    results: Results, claims: Sequence[Claim], others: Sequence[tuple[str, str]], introduction: str
) -> Page:
    """Return the page of an experiment in Keepaway.

    Args:
        results: what was played.
        claims: what is claimed, tested in this order.
        others: further comparisons (treated, control).
        introduction: sentences below the figure.
    """
    whole, last, label = scores(results), last_tenth(results), results.label
    there = set(results.conditions)
    claimed = [claim for claim in claims if {claim[0], claim[1]} <= there]
    verdicts = [page.verdict(label(better), label(worse), whole) for better, worse, _ in claimed]
    verdicts += [page.verdict(label(a), label(b), whole) for a, b in others if {a, b} <= there]
    name = results.experiment.name
    text = f"""\
# {results.experiment.title}

{page.claims_table("claim", [words for *_, words in claimed], verdicts[: len(claimed)])}
![Learning curves](../figures/{name}.png)

Means over {len(results.seeds)} trials with 95 % bootstrap bands, running means over an eighth of the time, or of the
episodes that every trial has. {introduction}

## Scores

{SCORES_TEXT}
{page.summary_table(whole, SCORE)}
Last tenth of the time:

{page.summary_table(last, "seconds per episode")}
## Comparisons

{page.HOW_TO_READ}
{page.verdict_table(verdicts)}
{page.how_it_was_made(results)}"""  # noqa: E501
    return Page(name, text, {name: curves_figure(results)})


def _hours(results: Results) -> float:
    return min(float(trial["hours"][-1]) for trials in results.trials.values() for trial in trials)
