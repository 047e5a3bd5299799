"""Features: does the paper's set of 12 suffice (section 3.2)? Cross-entropy and ARL over it with 21 and with
12 features.
"""

from core.combination.config import EnvironmentOnly
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment
from studies.experiments.tetris_pages import last_block, report_page, same_trials, scores
from studies.experiments.tetris_settings import DEPARTURES, quick, session, tetris_agent
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


FEATURES_TEXT = """\
21: heights of the 10 columns, their 9 differences, maximum, holes (Bertsekas & Ioffe 1996). 12, which the paper says suffice: maximum and
mean height, holes, 9 differences.
"""  # noqa: E501


def report(results: Results) -> Page:
    """Return the page of the comparison."""
    results.require("ce-21", "ce-12", "arl-21", "arl-12")
    whole, last, label = scores(results), last_block(results), results.label
    pairs = (("ce-12", "ce-21"), ("arl-12", "arl-21"), ("arl-12", "ce-12"), ("arl-21", "ce-21"))
    verdicts = [page.verdict(label(first), label(second), whole) for first, second in pairs]
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
    answer = page.in_short(
        [
            (f"12 features do better than 21 with {learner}", page.held(found), page.interval(found.ratio))
            for learner, found in zip(("CE", "ARL + CE"), verdicts[:2], strict=True)
        ]
    )
    shared, others = same_trials(results, "fig5", "Fig. 5", {"ce-21": "ce", "arl-21": "arl-ce"})
    return report_page(
        results,
        f"{answer}\n{FEATURES_TEXT}\n{shared}\n\n{claims}",
        verdicts,
        last_verdicts=[page.verdict(label(first), label(second), last) for first, second in pairs[:2]],
        others=others,
    )
