"""What a wrong delay density costs in Keepaway, where feedback is late: the person's own fit, the paper's, uniform, none."""

from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from studies.experiments.keepaway_settings import DEPARTURES, TRUST, arl, person, sarsa_alone
from studies.experiments.keepaway_trial import own_fit, quick, run_trial
from studies.experiments.sweep import Condition, Experiment

SLOW = GammaDelay(shape=4.0, scale_s=0.3, offset_s=0.3)
"""True delay of the participant: mean 1.5 s, twice the paper's density; nobody presses within 0.3 s. (Judging an event
takes longer than reacting to one: means from 0.75 to 2.2 s have been reported.)"""
SLOW_PERSON = person(delay=SLOW)

EXPERIMENT = Experiment(
    name="credit",
    title="Credit with the right and with wrong delays in Keepaway",
    conditions=(
        Condition("sarsa", "Sarsa", sarsa_alone()),
        Condition("true", "the true density", arl(trust=TRUST, delay=SLOW, watched_by=SLOW_PERSON)),
        Condition(
            "own-fit", "own fit of 60 reactions", own_fit(arl(trust=TRUST, watched_by=SLOW_PERSON), 60)
        ),
        Condition("paper", "the paper's gamma(2.5, 0.3)", arl(trust=TRUST, watched_by=SLOW_PERSON)),
        Condition(
            "uniform",
            "uniform 0.2-0.8 s (TAMER)",
            arl(trust=TRUST, delay=UniformDelay(), watched_by=SLOW_PERSON),
        ),
        Condition(
            "on-screen",
            "no delay: the option on screen",
            arl(trust=TRUST, delay=CurrentStep(), watched_by=SLOW_PERSON),
        ),
        Condition(
            "previous",
            "no delay: the option before",
            arl(trust=TRUST, delay=PreviousStep(), watched_by=SLOW_PERSON),
        ),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)
