"""Figure 5: cross-entropy alone, ARL over it, the annealed combination, and the human alone (section 4)."""

from core.combination.config import Annealed, EnvironmentOnly, HumanOnly
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment
from studies.experiments.tetris_pages import (
    SCORE,
    SCORES_TEXT,
    curves_figure,
    last_block,
    person_table,
    scores,
)
from studies.experiments.tetris_settings import (
    DEPARTURES,
    EPISODES_PER_ITERATION,
    PIECE_CAP,
    quick,
    session,
    tetris_agent,
)
from studies.experiments.tetris_trial import run_trial

EXPERIMENT = Experiment(
    name="fig5",
    title="Figure 5: Tetris, cross-entropy",
    conditions=(
        Condition("ce", "CE", session(tetris_agent(scheme=EnvironmentOnly()))),
        Condition("arl-ce", "ARL + CE (Eqs. 3, 4)", session(tetris_agent())),
        Condition("annealed", "annealed, 0.98 per episode", session(tetris_agent(scheme=Annealed()))),
        Condition("human", "human only", session(tetris_agent(scheme=HumanOnly()))),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)

CLAIMS = (
    ("arl-ce", "ce", "ARL + CE clears more lines than CE"),
    ("arl-ce", "annealed", "ARL + CE clears more lines than the annealed combination"),
    ("arl-ce", "human", "ARL + CE clears many more lines than the human feedback alone"),
)
"""Of the paper, section 4: (better, worse, in words)."""


def report(results: Results) -> Page:
    """Return the page of Fig. 5."""
    whole, last = scores(results), last_block(results, EPISODES_PER_ITERATION)
    label = results.label
    verdicts = [page.verdict(label(better), label(worse), whole) for better, worse, _ in CLAIMS]
    verdicts.append(page.verdict(label("annealed"), label("ce"), whole))
    claims = page.table(
        ["the paper's claim (section 4)", "held", "ratio"],
        [
            [words, page.held(found), page.interval(found.ratio)]
            for (_, _, words), found in zip(CLAIMS, verdicts, strict=False)
        ],
    )
    text = f"""\
# {results.experiment.title}

{claims}
![Learning curves](../figures/fig5.png)

Means over {len(results.seeds)} trials with 95 % bootstrap bands, in blocks of one cross-entropy iteration (100 episodes). A simulated
person watches every episode, presses at most 5 keys in it, 2 on average where it is long enough, and errs in 1 of 10.

## Scores

{SCORES_TEXT}
{page.summary_table(whole, SCORE)}
Last 100 episodes:

{page.summary_table(last, "lines per episode")}
## Comparisons

{page.HOW_TO_READ}
{page.verdict_table(verdicts)}
## What the person did

{person_table(results, PIECE_CAP)}
{page.how_it_was_made(results, "arl experiment run fig5 && arl experiment report fig5 --into docs")}"""
    return Page("fig5", text, {"fig5": curves_figure(results, EPISODES_PER_ITERATION)})
