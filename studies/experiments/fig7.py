"""Figure 7: Sarsa, and ARL over it with and without credit by the gamma density (section 4)."""

from core.combination.config import Exponential
from core.feedback.delays import CurrentStep
from studies.experiments.keepaway_settings import DEPARTURES, TRUST, arl, sarsa_alone
from studies.experiments.keepaway_trial import quick, run_trial
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
        Condition("linear-gamma-trust", "ARL, linear, with gamma, signed trust", arl(trust=TRUST)),
        Condition(
            "linear-no-gamma-trust",
            "ARL, linear, without gamma, signed trust",
            arl(trust=TRUST, delay=CurrentStep()),
        ),
        Condition(
            "exponential-gamma-trust",
            "ARL, exponential, with gamma, signed trust",
            arl(Exponential(), trust=TRUST),
        ),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)
