"""Figure 7: Sarsa, and ARL over it with and without credit by the gamma density (section 4)."""

from core.combination.config import Exponential
from core.feedback.delays import CurrentStep
from studies.experiments.keepaway_pages import Claim, report_page
from studies.experiments.keepaway_settings import DEPARTURES, TRUST, arl, sarsa_alone
from studies.experiments.keepaway_trial import quick, run_trial
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment

EXPERIMENT = Experiment(
    name="fig7",
    title="Figure 7: Keepaway, Sarsa",
    conditions=(
        Condition("sarsa", "Sarsa", sarsa_alone()),
        Condition("linear-no-gamma", "ARL, linear, without gamma", arl(delay=CurrentStep())),
        Condition("linear-gamma", "ARL, linear, with gamma", arl()),
        Condition("exponential-gamma", "ARL, exponential, with gamma", arl(Exponential())),
        # Beyond the paper: the same with another rule of trust.
        Condition("linear-gamma-trust", "ARL, linear, with gamma, trust by trial", arl(trust=TRUST)),
        Condition(
            "linear-no-gamma-trust",
            "ARL, linear, without gamma, trust by trial",
            arl(trust=TRUST, delay=CurrentStep()),
        ),
        Condition(
            "exponential-gamma-trust",
            "ARL, exponential, with gamma, trust by trial",
            arl(Exponential(), trust=TRUST),
        ),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)

CLAIMS: tuple[Claim, ...] = (
    ("linear-gamma", "sarsa", "ARL, linear with gamma, keeps the ball longer than Sarsa"),
    ("linear-no-gamma", "sarsa", "ARL, linear without gamma, keeps the ball longer than Sarsa"),
    ("exponential-gamma", "sarsa", "ARL, exponential with gamma, keeps the ball longer than Sarsa"),
    ("linear-gamma", "linear-no-gamma", "credit by the gamma density does better than without"),
    ("linear-gamma", "exponential-gamma", "the linear scheme does better than the exponential one"),
    ("linear-gamma-trust", "sarsa", "(ours) with trust by trial: linear with gamma against Sarsa"),
    ("linear-gamma-trust", "linear-no-gamma-trust", "(ours) with trust by trial: gamma against none"),
    ("linear-gamma-trust", "linear-gamma", "(ours) trust by trial against Eq. 4"),
)
"""Of the paper, section 4, and ours beside them."""
OTHERS = (("exponential-gamma-trust", "sarsa"), ("linear-no-gamma-trust", "sarsa"))
INTRODUCTION = """A simulated
person watches every episode, presses at most 2 keys in it, and errs in 1 of 10. The paper's figure has the first four conditions, whose
w_h is that of Eq. 4; the others have their w_h by trial."""


def report(results: Results) -> Page:
    """Return the page of Fig. 7."""
    return report_page(results, CLAIMS, OTHERS, INTRODUCTION)
