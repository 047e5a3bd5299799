"""Measures with core, writes files, draws. Never a screen.

What users import stands here; a name is loaded when it is asked for, because compiled code comes with some.
Modules may be imported by their own names, too, but what is not in `__all__` may change without notice.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from studies.demo import SessionSummary, simulate_session, summarise
    from studies.experiments.page import Page
    from studies.experiments.results import Results, read_results
    from studies.experiments.run import SweepError, run_sweep
    from studies.experiments.sweep import Condition, Experiment, load_experiment
    from studies.reaction_time.fit import (
        DelayEstimate,
        FitSettings,
        GroupFit,
        ParticipantFit,
        fit_group,
        fit_participant,
    )
    from studies.reaction_time.read import read_files
    from studies.reaction_time.report import Result, read_result
    from studies.reaction_time.sample import FitError, Sample, sample
    from studies.statistics import Interval, mean_interval, paired_difference, paired_ratio
    from studies.what_if import WhatIfRow, WhatIfSettings

__all__ = [
    "Condition",
    "DelayEstimate",
    "Experiment",
    "FitError",
    "FitSettings",
    "GroupFit",
    "Interval",
    "Page",
    "ParticipantFit",
    "Result",
    "Results",
    "Sample",
    "SessionSummary",
    "SweepError",
    "WhatIfRow",
    "WhatIfSettings",
    "fit_group",
    "fit_participant",
    "load_experiment",
    "mean_interval",
    "paired_difference",
    "paired_ratio",
    "read_files",
    "read_result",
    "read_results",
    "run_sweep",
    "sample",
    "simulate_session",
    "summarise",
]

_PLACES = {
    "Condition": "studies.experiments.sweep",
    "DelayEstimate": "studies.reaction_time.fit",
    "Experiment": "studies.experiments.sweep",
    "FitError": "studies.reaction_time.sample",
    "FitSettings": "studies.reaction_time.fit",
    "GroupFit": "studies.reaction_time.fit",
    "Interval": "studies.statistics",
    "Page": "studies.experiments.page",
    "ParticipantFit": "studies.reaction_time.fit",
    "Result": "studies.reaction_time.report",
    "Results": "studies.experiments.results",
    "Sample": "studies.reaction_time.sample",
    "SessionSummary": "studies.demo",
    "SweepError": "studies.experiments.run",
    "WhatIfRow": "studies.what_if",
    "WhatIfSettings": "studies.what_if",
    "fit_group": "studies.reaction_time.fit",
    "fit_participant": "studies.reaction_time.fit",
    "load_experiment": "studies.experiments.sweep",
    "mean_interval": "studies.statistics",
    "paired_difference": "studies.statistics",
    "paired_ratio": "studies.statistics",
    "read_files": "studies.reaction_time.read",
    "read_result": "studies.reaction_time.report",
    "read_results": "studies.experiments.results",
    "run_sweep": "studies.experiments.run",
    "sample": "studies.reaction_time.sample",
    "simulate_session": "studies.demo",
    "summarise": "studies.demo",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it offers {', '.join(__all__)}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
