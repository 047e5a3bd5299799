"""Figure 5: cross-entropy alone, ARL over it, the annealed combination, and the human alone (section 4)."""

from core.combination.config import AgentConfig, Annealed, EnvironmentOnly, HumanOnly
from studies.experiments.sweep import Condition, Experiment
from studies.experiments.tetris_settings import DEPARTURES, quick, session
from studies.experiments.tetris_trial import run_trial

EXPERIMENT = Experiment(
    name="fig5",
    title="Figure 5: Tetris, cross-entropy",
    conditions=(
        Condition("ce", "CE", session(AgentConfig(scheme=EnvironmentOnly()))),
        Condition("arl-ce", "ARL + CE (Eqs. 3, 4)", session(AgentConfig())),
        Condition("annealed", "annealed, 0.98 per episode", session(AgentConfig(scheme=Annealed()))),
        Condition("human", "human only", session(AgentConfig(scheme=HumanOnly()))),
    ),
    trial=run_trial,
    quick=quick,
    departures=DEPARTURES,
)
