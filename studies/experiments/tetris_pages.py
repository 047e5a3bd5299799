"""What the pages of experiments in Tetris share: scores of trials, figures over iterations, how the person came through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from studies.experiments import page
from studies.experiments.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

SCORE = "lines per episode, over the whole trial"
SCORES_TEXT = """\
The score of a trial is the mean of lines cleared over all its episodes: the area under its learning curve. It was chosen before the
trials were played. The last block is given as well.
"""


def scores(results: Results) -> dict[str, Floats]:
    """Return the score of each trial, by the condition's label."""
    return {results.label(name): results.table(name, "lines").mean(axis=1) for name in results.conditions}


def last_block(results: Results, size: int) -> dict[str, Floats]:
    """Return mean lines of the last `size` episodes of each trial, by the condition's label."""
    return {results.label(name): results.blocks(name, "lines", size)[:, -1] for name in results.conditions}


def curves_figure(results: Results, size: int, *, conditions: Sequence[str] = ()) -> Figure:
    """Draw lines per episode, and beside them w_h, in blocks of `size` episodes."""
    names = conditions or results.conditions
    figure = page.new_figure(7.2, 3.4)
    left, right = figure.subplots(1, 2)
    blocks = {results.label(name): results.blocks(name, "lines", size) for name in names}
    x = np.arange(1, next(iter(blocks.values())).shape[1] + 1) * float(size)
    page.draw_curves(left, x, blocks)
    # Curves start at a fraction of a line and end at thousands.
    left.set(xlabel="episodes", ylabel="lines per episode", yscale="symlog")
    left.set_ylim(bottom=0.0)
    left.legend(frameon=False, fontsize="small")
    page.draw_curves(right, x, {results.label(name): results.blocks(name, "w_h", size) for name in names})
    right.set(xlabel="episodes", ylabel="weight of the human, $w_h$")
    return figure


def person_table(results: Results, cap: int) -> str:
    """Return how often the person spoke, and how many games the piece cap stopped, by condition."""
    rows = []
    for name in results.conditions:
        presses, pieces = results.table(name, "presses"), results.table(name, "pieces")
        rows.append(
            [
                results.label(name),
                f"{presses.mean():.2f}",
                int(presses.max()),
                f"{100 * (pieces >= cap).mean():.1f} %",
                page.number(float(pieces.sum(axis=1).mean() / 1e6)),
            ]
        )
    header = [
        "condition",
        "presses per episode",
        "most in one",
        "games stopped by the cap",
        "pieces per trial, millions",
    ]
    return page.table(header, rows)
