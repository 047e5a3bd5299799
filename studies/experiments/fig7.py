"""Figure 7: Sarsa, and ARL over it with and without credit by the gamma density (section 4)."""

from core.combination.config import Exponential
from core.feedback.delays import CurrentStep
from studies.experiments.keepaway_pages import Claim, report_page
from studies.experiments.keepaway_settings import BELIEVED, DEPARTURES, arl, sarsa_alone
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
        # Beyond the paper: the same with a w_h that nothing changes.
        Condition("linear-gamma-fixed", "ARL, linear, with gamma, w_h = 1", arl(trust=BELIEVED)),
        Condition(
            "linear-no-gamma-fixed",
            "ARL, linear, without gamma, w_h = 1",
            arl(trust=BELIEVED, delay=CurrentStep()),
        ),
        Condition(
            "exponential-gamma-fixed",
            "ARL, exponential, with gamma, w_h = 1",
            arl(Exponential(), trust=BELIEVED),
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
    ("linear-gamma-fixed", "sarsa", "(ours) with w_h fixed at 1: linear with gamma against Sarsa"),
    ("linear-gamma-fixed", "linear-no-gamma-fixed", "(ours) with w_h fixed at 1: gamma against none"),
    (
        "linear-gamma-fixed",
        "exponential-gamma-fixed",
        "(ours) with w_h fixed at 1: linear against exponential",
    ),
    ("linear-gamma-fixed", "linear-gamma", "(ours) w_h fixed at 1 against Eq. 4"),
)
"""Of the paper, section 4, and ours beside them."""
OTHERS = (("exponential-gamma-fixed", "sarsa"), ("linear-no-gamma-fixed", "sarsa"))
INTRODUCTION = """A simulated
person watches every episode, presses at most 2 keys in it, and errs in 1 of 10. The paper's figure has the first four conditions, whose
w_h is that of Eq. 4; in the others it is 1, whatever the person does."""  # noqa: E501


def report(results: Results) -> Page:
    """Return the page of Fig. 7."""
    return report_page(results, CLAIMS, OTHERS, INTRODUCTION)
