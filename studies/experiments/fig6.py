"""Figure 6: policy gradient alone, and ARL over it (section 4)."""

import msgspec

from core.combination.config import AgentConfig, EnvironmentOnly
from core.feedback.config import TrainerConfig
from core.learners.policy_gradient_config import PolicyGradientConfig
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
    PERSON,
    PIECE_CAP,
    quick,
    session,
    tetris_agent,
)
from studies.experiments.tetris_trial import GradientTrial, run_gradient_trial

GRADIENT = PolicyGradientConfig()
"""OLPOMDP with the constants of the library's default."""


def gradient_trial(agent: AgentConfig, person: TrainerConfig = PERSON) -> GradientTrial:
    """Return a trial of policy gradient: as many watched games as in Fig. 5."""
    return GradientTrial(session(agent, person), GRADIENT)


def quick_gradient(settings: GradientTrial) -> GradientTrial:
    """Return a trial of a second."""
    return msgspec.structs.replace(settings, protocol=quick(settings.protocol))


EXPERIMENT = Experiment(
    name="fig6",
    title="Figure 6: Tetris, policy gradient",
    conditions=(
        Condition("pg", "PG", gradient_trial(tetris_agent(scheme=EnvironmentOnly()))),
        Condition("arl-pg", "ARL + PG (Eqs. 3, 4)", gradient_trial(tetris_agent())),
    ),
    trial=run_gradient_trial,
    quick=quick_gradient,
    departures=(*DEPARTURES[:1], *DEPARTURES[2:], "the gradient is estimated by OLPOMDP, after every piece"),
)


def report(results: Results) -> Page:
    """Return the page of Fig. 6."""
    whole, last = scores(results), last_block(results, EPISODES_PER_ITERATION)
    label = results.label
    verdicts = [page.verdict(label("arl-pg"), label("pg"), whole)]
    claims = page.table(
        ["the paper's claim (section 4)", "held", "ratio"],
        [
            [
                "ARL + PG clears a much larger number of lines than PG",
                page.held(verdicts[0]),
                page.interval(verdicts[0].ratio),
            ]
        ],
    )
    text = f"""\
# {results.experiment.title}

{claims}
The paper's other claim here, that PG clears fewer lines than CE, did *not* hold: compare the scores of CE in [Fig. 5](fig5.md), of the same
rules, number of games and seeds. A gradient that learns after every piece makes more of 1,500 games than a search that learns after every
hundred of them.

![Learning curves](../figures/fig6.png)

Means over {len(results.seeds)} trials with 95 % bootstrap bands, in blocks of 100 episodes. The person is that of Fig. 5.

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
{page.how_it_was_made(results, "arl experiment run fig6 && arl experiment report fig6 --into docs")}"""
    return Page("fig6", text, {"fig6": curves_figure(results, EPISODES_PER_ITERATION)})
