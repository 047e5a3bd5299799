"""Figure 5: cross-entropy alone, ARL over it, the annealed combination, and the participant alone (section
4).
"""

from core.combination.config import Annealed, EnvironmentOnly, HumanOnly
from studies.experiments import page
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment
from studies.experiments.tetris_pages import CLAIM, report_page, scores
from studies.experiments.tetris_settings import DEPARTURES, quick, session, tetris_agent
from studies.experiments.tetris_trial import run_trial

EXPERIMENT = Experiment(
    name="fig5",
    title="Figure 5: Tetris, cross-entropy",
    conditions=(
        Condition("ce", "CE", session(tetris_agent(scheme=EnvironmentOnly()))),
        Condition("arl-ce", "ARL + CE (Eqs. 3, 4)", session(tetris_agent())),
        Condition(
            "annealed", "annealed, 0.98 per episode", session(tetris_agent(scheme=Annealed(per="episode")))
        ),
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
    results.require("ce", "arl-ce", "annealed", "human")
    whole, label = scores(results), results.label
    verdicts = [page.verdict(label(better), label(worse), whole) for better, worse, _ in CLAIMS]
    claims = page.claims_table(CLAIM, [words for *_, words in CLAIMS], verdicts)
    return report_page(
        results,
        claims,
        [*verdicts, page.verdict(label("annealed"), label("ce"), whole)],
        introduction="A block is one iteration of the cross-entropy method. A simulated person watches every "
        "episode, "
        "presses at most 5 keys in it, 2 on average where it is long enough, and errs in 1 of 10.",
    )
