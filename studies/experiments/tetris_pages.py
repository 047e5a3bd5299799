"""What the pages of experiments in Tetris share: scores of trials, figures over iterations, how the
participant came through.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from core.numerics.arrays import Floats
from studies.comparison import Verdict
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results, equal_trials, read_beside
from studies.experiments.tetris_settings import EPISODES_PER_ITERATION, PIECE_CAP

if TYPE_CHECKING:
    from matplotlib.figure import Figure


CLAIM = "the paper's claim (section 4)"
SCORE = "lines per episode, over the whole trial"
SCORES_TEXT = """\
The score of a trial is the mean of lines cleared over all its episodes: the area under its learning curve. It was chosen before the
trials were played. The last block is given as well.
"""  # noqa: E501


def scores(results: Results) -> dict[str, Floats]:
    """Return the score of each trial, by the condition's label."""
    return {results.label(name): results.table(name, "lines").mean(axis=1) for name in results.conditions}


def last_block(results: Results) -> dict[str, Floats]:
    """Return mean lines of each trial's last block, by the condition's label."""
    return {
        results.label(name): results.blocks(name, "lines", EPISODES_PER_ITERATION)[:, -1]
        for name in results.conditions
    }


def report_page(
    results: Results,
    above: str,
    verdicts: Sequence[Verdict],
    *,
    introduction: str = "",
    last_verdicts: Sequence[Verdict] = (),
    others: Sequence[Results] = (),
) -> Page:
    """Return the page of an experiment in Tetris.

    Args:
        results: what was played.
        above: Markdown above the figure, the claims among it.
        verdicts: comparisons of the scores, claims first.
        introduction: sentences below the figure.
        last_verdicts: comparisons of the last block.
        others: results of other experiments that went into the page.
    """
    name = results.experiment.name
    last = f"\nLast 100 episodes:\n\n{page.verdict_table(last_verdicts)}" if last_verdicts else ""
    text = f"""\
# {results.experiment.title}

{above}
![Learning curves](../figures/{name}.png)

Means over {len(results.seeds)} trials with 95 % bootstrap bands, in blocks of {EPISODES_PER_ITERATION} episodes.{" " * bool(introduction)}{introduction}

## Scores

{SCORES_TEXT}
{page.summary_table(scores(results), SCORE)}
Last {EPISODES_PER_ITERATION} episodes:

{page.summary_table(last_block(results), "lines per episode")}
## Comparisons

{page.HOW_TO_READ}
{page.verdict_table(verdicts)}{last}
## What the person did

{_person_table(results)}
{page.how_it_was_made(results, others=others)}"""  # noqa: E501
    return Page(name, text, {name: _curves_figure(results)})


def same_trials(
    results: Results, other: str, title: str, pairs: Mapping[str, str]
) -> tuple[str, list[Results]]:
    """Say whether conditions with the settings of another experiment's have its trials, as far as its files
    tell.

    Args:
        results: what was played, or copied because it had been played before.
        other: name of the other experiment; its folder lies beside, or nothing can be said.
        title: what its page is called.
        pairs: condition of `results` -> condition of the other with equal settings.

    Returns:
        The sentences, and the other's results where they were compared.
    """
    pairs = {mine: theirs for mine, theirs in pairs.items() if mine in results.trials}
    names = " and ".join(f"*{results.label(mine)}*" for mine in pairs)
    link = f"[{title}]({other}.md)"
    found = read_beside(results, other, tuple(pairs.values()))
    if found is None:
        return f"{names}: settings and seeds are those of {link}; their rows were not compared.", []
    for mine, theirs in pairs.items():
        assert results.experiment.condition(mine).settings == found.experiment.condition(theirs).settings
    counts = [equal_trials(results, mine, found, theirs) for mine, theirs in pairs.items()]
    shared, equal = sum(n for n, _ in counts), sum(n for _, n in counts)
    if equal == shared:
        said = f"so are their trials: {shared} that both have were compared row by row, all are equal"
    else:
        said = (
            f"but of {shared} trials that both have **{shared - equal} differ**: other versions played them"
        )
    return f"{names}: settings and seeds are those of {link}, {said}.", [found]


def _curves_figure(results: Results) -> Figure:
    """Draw lines per episode, and beside them w_h, in blocks."""
    names, size = results.conditions, EPISODES_PER_ITERATION
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


def _person_table(results: Results) -> str:
    """Return how often the participant spoke, and how many games the piece cap stopped, by condition."""
    rows = []
    for name in results.conditions:
        presses, pieces = results.table(name, "presses"), results.table(name, "pieces")
        rows.append(
            [
                results.label(name),
                f"{presses.mean():.2f}",
                int(presses.max()),
                f"{100 * (pieces >= PIECE_CAP).mean():.1f} %",
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
