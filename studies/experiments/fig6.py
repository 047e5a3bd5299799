"""Figure 6: policy gradient alone, and ARL over it (section 4)."""

import msgspec
import numpy as np

from core.combination.config import AgentConfig, EnvironmentOnly
from core.feedback.config import TrainerConfig
from core.learners.policy_gradient_config import PolicyGradientConfig
from studies.comparison import Verdict
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results, read_beside
from studies.experiments.sweep import Condition, Experiment
from studies.experiments.tetris_pages import CLAIM, report_page, scores
from studies.experiments.tetris_settings import DEPARTURES, PERSON, quick, session, tetris_agent
from studies.experiments.tetris_trial import run_trial

GRADIENT = PolicyGradientConfig()
"""OLPOMDP with the constants of the library's default."""


NOT_TESTED = """\
The paper's other claim here, that PG clears fewer lines than CE, is not tested on this page: that needs trials of
[Fig. 5](fig5.md) beside these.
"""  # noqa: E501
PERSON_TEXT = "The person is that of Fig. 5."


def gradient_condition(
    name: str, label: str, agent: AgentConfig, participant: TrainerConfig = PERSON
) -> Condition:
    """Return a condition of policy gradient: as many watched games as in Fig. 5.

    Its published trials name the session of Fig. 5, and the learner beside it.
    """
    of_fig5 = session(agent, participant)
    return Condition(
        name,
        label,
        msgspec.structs.replace(of_fig5, learner=GRADIENT),
        written={"protocol": of_fig5, "gradient": GRADIENT},
    )


EXPERIMENT = Experiment(
    name="fig6",
    title="Figure 6: Tetris, policy gradient",
    conditions=(
        gradient_condition("pg", "PG", tetris_agent(scheme=EnvironmentOnly())),
        gradient_condition("arl-pg", "ARL + PG (Eqs. 3, 4)", tetris_agent()),
    ),
    trial=run_trial,
    quick=quick,
    departures=(*DEPARTURES[:1], *DEPARTURES[2:], "the gradient is estimated by OLPOMDP, after every piece"),
)


def report(results: Results) -> Page:
    """Return the page of Fig. 6; the claim about CE is tested where trials of Fig. 5 lie beside."""
    results.require("pg", "arl-pg")
    whole, label = scores(results), results.label
    found = page.verdict(label("arl-pg"), label("pg"), whole)
    claims = ["ARL + PG clears a much larger number of lines than PG"]
    against_ce = read_beside(results, "fig5", ("ce",))
    tested = None if against_ce is None else _against_ce(results, against_ce)
    if against_ce is None or tested is None:
        above = page.claims_table(CLAIM, claims, [found])
        return report_page(results, f"{above}\n{NOT_TESTED}", [found], introduction=PERSON_TEXT)
    above = page.claims_table(
        CLAIM, [*claims, "PG clears fewer lines than CE (ratio: CE / PG)"], [found, tested]
    )
    n_pairs = len(set(results.seeds) & set(against_ce.seeds))
    compared = (
        f"CE is that of [Fig. 5](fig5.md): the same rules, number of games and person; {n_pairs} trials pair "
        f"by seed."
    )
    return report_page(
        results, f"{above}\n{compared}\n", [found, tested], introduction=PERSON_TEXT, others=[against_ce]
    )


def _against_ce(results: Results, against: Results) -> Verdict | None:
    """Compare CE with PG over the seeds that both have; None where there are none, or the games were
    others.
    """
    pg, ce = results.experiment.condition("pg").settings, against.experiment.condition("ce").settings
    both = sorted(set(results.seeds) & set(against.seeds))
    if msgspec.structs.replace(pg, learner=ce.learner) != ce or not both:
        return None
    values = {}
    for found, name in ((against, "ce"), (results, "pg")):
        trials = dict(zip(found.seeds, found.trials[name], strict=True))
        values[found.label(name)] = np.array([trials[seed]["lines"].mean() for seed in both])
    return page.verdict(against.label("ce"), results.label("pg"), values)
