"""What a wrong delay density costs in Keepaway, where feedback is late: the participant's own fit, the
paper's, uniform, none.
"""

from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from studies.experiments.keepaway_pages import Claim, report_page
from studies.experiments.keepaway_settings import BELIEVED, DEPARTURES, arl, person, sarsa_alone
from studies.experiments.keepaway_trial import own_fit, quick, run_trial
from studies.experiments.page import Page
from studies.experiments.results import Results
from studies.experiments.sweep import Condition, Experiment

SLOW = GammaDelay(shape=4.0, scale_s=0.3, offset_s=0.3)
"""True delay of the participant: mean 1.5 s, twice the paper's density; nobody presses within 0.3 s. (Judging
an event takes longer than reacting to one: means from 0.75 to 2.2 s have been reported.)"""
SLOW_PERSON = person(delay=SLOW)

EXPERIMENT = Experiment(
    name="credit",
    title="Credit with the right and with wrong delays in Keepaway",
    conditions=(
        Condition("sarsa", "Sarsa", sarsa_alone()),
        Condition("true", "the true density", arl(trust=BELIEVED, delay=SLOW, watched_by=SLOW_PERSON)),
        Condition(
            "own-fit", "own fit of 60 reactions", own_fit(arl(trust=BELIEVED, watched_by=SLOW_PERSON), 60)
        ),
        Condition("paper", "the paper's gamma(2.5, 0.3)", arl(trust=BELIEVED, watched_by=SLOW_PERSON)),
        Condition(
            "uniform",
            "uniform 0.2-0.8 s (TAMER)",
            arl(trust=BELIEVED, delay=UniformDelay(), watched_by=SLOW_PERSON),
        ),
        Condition(
            "on-screen",
            "no delay: the option on screen",
            arl(trust=BELIEVED, delay=CurrentStep(), watched_by=SLOW_PERSON),
        ),
        Condition(
            "previous",
            "no delay: the option before",
            arl(trust=BELIEVED, delay=PreviousStep(), watched_by=SLOW_PERSON),
        ),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)

CLAIMS: tuple[Claim, ...] = (
    ("own-fit", "paper", "the person's own fit does better than the paper's density"),
    ("own-fit", "uniform", "the person's own fit does better than a uniform density"),
    ("own-fit", "on-screen", "the person's own fit does better than no delay at all"),
    ("paper", "on-screen", "the paper's density, though wrong, does better than no delay at all"),
)
OTHERS = (
    ("true", "own-fit"),
    ("own-fit", "sarsa"),
    ("paper", "sarsa"),
    ("previous", "sarsa"),
    ("on-screen", "sarsa"),
)
INTRODUCTION = """A simulated
person watches every episode, presses at most 2 keys in it, errs in 1 of 10, and presses 1.5 s after an option was chosen on average (gamma
of shape 4 and scale 0.3 s, 0.3 s at least). Their own fit is a shifted gamma density of 60 reactions drawn beforehand, anew in each trial.
w_h is 1 throughout: this is about credit, not about trust."""  # noqa: E501


def report(results: Results) -> Page:
    """Return the page of `credit`."""
    return report_page(results, CLAIMS, OTHERS, INTRODUCTION)
