"""Features: does the paper's set of 12 suffice (section 3.2)? Cross-entropy and ARL over it with 21 and with 12 features."""

from core.combination.config import EnvironmentOnly
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

ALONE = tetris_agent(scheme=EnvironmentOnly())

EXPERIMENT = Experiment(
    name="features",
    title="Features: 21 against 12",
    conditions=(
        Condition("ce-21", "CE, 21 features", session(ALONE)),
        Condition("ce-12", "CE, 12 features", session(ALONE, features="paper-12")),
        Condition("arl-21", "ARL + CE, 21 features", session(tetris_agent())),
        Condition("arl-12", "ARL + CE, 12 features", session(tetris_agent(), features="paper-12")),
    ),
    trial=run_trial,
    quick=quick,
    departures=(
        *DEPARTURES,
        "the human model sees the differences of the 21 features in every condition",
    ),
)


def report(results: Results) -> Page:
    """Return the page of the comparison."""
    whole, last = scores(results), last_block(results, EPISODES_PER_ITERATION)
    label = results.label
    pairs = (("ce-12", "ce-21"), ("arl-12", "arl-21"), ("arl-12", "ce-12"), ("arl-21", "ce-21"))
    verdicts = [page.verdict(label(first), label(second), whole) for first, second in pairs]
    last_verdicts = [page.verdict(label(first), label(second), last) for first, second in pairs[:2]]
    suffice = "yes" if all(found.ratio.high >= 1.0 for found in verdicts[:2]) else "no"
    claims = page.table(
        ["the paper's claim (section 3.2)", "held", "12 / 21 features, CE", "12 / 21 features, ARL + CE"],
        [
            [
                "12 features suffice: performance does not fall significantly",
                suffice,
                page.interval(verdicts[0].ratio),
                page.interval(verdicts[1].ratio),
            ]
        ],
    )
    text = f"""\
# {results.experiment.title}

21: heights of the 10 columns, their 9 differences, maximum, holes (Bertsekas & Ioffe 1996). 12, which the paper says suffice: maximum and
mean height, holes, 9 differences. (Settings and seeds of the conditions with 21 features are those of Fig. 5, and so are their trials, byte
for byte.)

{claims}
![Learning curves](../figures/features.png)

Means over {len(results.seeds)} trials with 95 % bootstrap bands, in blocks of one cross-entropy iteration (100 episodes).

## Scores

{SCORES_TEXT}
{page.summary_table(whole, SCORE)}
Last 100 episodes:

{page.summary_table(last, "lines per episode")}
## Comparisons

{page.HOW_TO_READ}
{page.verdict_table(verdicts)}
Last 100 episodes:

{page.verdict_table(last_verdicts)}
## What the person did

{person_table(results, PIECE_CAP)}
{page.how_it_was_made(results, "arl experiment run features && arl experiment report features --into docs")}"""
    return Page("features", text, {"features": curves_figure(results, EPISODES_PER_ITERATION)})
