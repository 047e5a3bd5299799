"""What an experiment is: conditions, seeds, and a function from both to rows. Data only; `run` plays, `results` reads."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

Rows = Mapping[str, NDArray[np.float64]]
"""Columns by name, one entry per episode, all of one length >= 1."""

TRIALS = 20
"""Trials per condition (paper, section 4)."""
PILOT_SEEDS = 900_000
"""Root seeds from here on are for finding constants; below they are for reporting."""


@dataclass(frozen=True, slots=True)
class Condition:
    """One arm of an experiment. Trial t of every condition has the same root seed, so trials pair."""

    name: str
    """Of its folder: lower-case letters, digits and hyphens."""
    label: str
    """In figures and tables."""
    settings: Any
    """All that decides a trial but its root seed; msgspec turns it to JSON."""

    def __post_init__(self) -> None:
        if not self.name or not all(c.islower() or c.isdigit() or c == "-" for c in self.name):
            raise ValueError(f"a condition's name is a-z, 0-9 and hyphens, got {self.name!r}")


@dataclass(frozen=True, slots=True)
class Experiment:
    """A sweep over conditions."""

    name: str
    """As in `arl experiment run NAME`."""
    title: str
    conditions: tuple[Condition, ...]
    trial: Callable[[Any, int], Rows]
    """(settings, root seed) -> rows; a pure function, the same in any process."""
    quick: Callable[[Any], Any]
    """Returns settings for a trial of a second or so, to see that everything works."""
    departures: tuple[str, ...] = ()
    """Where this differs from the paper, or fills its silence, in sentences for the report."""

    def __post_init__(self) -> None:
        names = [condition.name for condition in self.conditions]
        if not names or len(set(names)) != len(names):
            raise ValueError(f"{self.name}: conditions need names of their own, got {names}")

    def condition(self, name: str) -> Condition:
        """Return the condition of that name."""
        for condition in self.conditions:
            if condition.name == name:
                return condition
        raise ValueError(
            f"{self.name} has no condition {name!r}: there are {', '.join(c.name for c in self.conditions)}"
        )


MODULES: dict[str, str] = {
    "fig4": "studies.experiments.fig4",
    "fig5": "studies.experiments.fig5",
    "fig6": "studies.experiments.fig6",
    "fig7": "studies.experiments.fig7",
    "features": "studies.experiments.features",
    "robustness": "studies.experiments.robustness",
    "robustness-keepaway": "studies.experiments.keepaway_robustness",
    "credit": "studies.experiments.credit",
}
"""Where each experiment is: a module with `EXPERIMENT` and `report(results) -> Page`. Imported when asked for."""


def load_experiment(name: str) -> Experiment:
    """Return the experiment called `name`: one of ours, or a module of one's own, as "my_package.my_experiment"."""
    experiment: Experiment = experiment_module(name).EXPERIMENT
    return experiment


def experiment_module(name: str) -> Any:
    """Return the module of an experiment: it has `EXPERIMENT` and, to be reported, `report`."""
    if name not in MODULES and "." not in name:
        raise ValueError(
            f"no experiment {name!r}: there are {', '.join(MODULES)}; one of your own is named by its module"
        )
    module = import_module(MODULES.get(name, name))
    if not hasattr(module, "EXPERIMENT"):
        raise ValueError(f"{module.__name__} has no EXPERIMENT")
    return module


def root_seeds(trials: int, first: int = 0) -> range:
    """Return the root seeds of the trials: first, first + 1, ..."""
    if trials < 1 or first < 0:
        raise ValueError(f"need trials >= 1 and a first seed >= 0, got {trials} and {first}")
    return range(first, first + trials)


def run_unit(experiment: str, condition: str, root_seed: int, quick: bool) -> str:
    """Play one trial of one condition: what a worker is asked for. All arguments are plain.

    Returns:
        The trial's rows as CSV text; equal arguments give equal text, wherever this runs.
    """
    found = load_experiment(experiment)
    settings = found.condition(condition).settings
    return csv_text(found.trial(found.quick(settings) if quick else settings, root_seed))


def csv_text(rows: Rows) -> str:
    """Return rows as CSV: the episode's number first, floats so that they read back exactly."""
    lengths = {name: len(column) for name, column in rows.items()}
    if not lengths or min(lengths.values()) != max(lengths.values()):
        raise ValueError(f"rows need columns of one length, got {lengths}")
    lines = [",".join(["episode", *rows])]
    columns = [np.asarray(column, dtype=np.float64).tolist() for column in rows.values()]
    for episode, row in enumerate(zip(*columns, strict=True)):
        lines.append(",".join([str(episode), *map(_plain, row)]))
    return "\n".join(lines) + "\n"


def describe_settings(conditions: Sequence[Condition]) -> dict[str, Any]:
    """Return the settings of each condition as they read back from JSON, by name."""
    settings = {condition.name: condition.settings for condition in conditions}
    plain: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(settings))
    return plain


def _plain(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
