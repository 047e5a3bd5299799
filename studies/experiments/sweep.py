"""What an experiment is: conditions, seeds, and a function from both to rows. Data only; `run` plays,
`results` reads.
"""

import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.recording.schema import leave_out_later

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
    written: Any = None
    """The settings as results name them, where an earlier version gave them another form; None: as
    `settings`. Seals of published trials go by it."""

    def __post_init__(self) -> None:
        if not self.name or not all(c.islower() or c.isdigit() or c == "-" for c in self.name):
            raise ValueError(f"a condition's name is a-z, 0-9 and hyphens, got {self.name!r}")


@dataclass(frozen=True, slots=True)
class Experiment:
    """A sweep over conditions."""

    title: str
    conditions: tuple[Condition, ...]
    trial: Callable[[Any, int], Rows]
    """(settings, root seed) -> rows; a pure function, the same in any process."""
    quick: Callable[[Any], Any]
    """Returns settings for a trial of a second or so, to see that everything works."""
    departures: tuple[str, ...] = ()
    """Where this differs from the paper, or fills its silence, in sentences for the report."""
    name: str = field(default="", kw_only=True)
    """Of the folder of its results. `load_experiment` takes it from the module (`load_experiment`); "" until
    then."""
    source: str = field(default="", kw_only=True)
    """What finds its module in any process: one of our names, a module, or the absolute path of a file."""

    def __post_init__(self) -> None:
        names = [condition.name for condition in self.conditions]
        if not names or len(set(names)) != len(names):
            raise ValueError(f"{self.name or self.title}: conditions need names of their own, got {names}")

    @property
    def typed(self) -> str:
        """What one types for NAME in `arl experiment run NAME`, quoted for a shell; of a file only its own
        name.
        """
        return shlex.quote(Path(self.source).name if _is_file(self.source) else self.source or self.name)

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
    "mountain-car": "studies.experiments.mountain_car",
}
"""Where each experiment is: a module with `EXPERIMENT` and `report(results) -> Page`. Imported when asked
for."""


def load_experiment(name: str) -> Experiment:
    """Return an experiment, under the name of its module.

    Args:
        name: one of ours ("fig5"), a module ("my_package.my_experiment"), or a file ("my.py",
            "/home/me/my.py").

    Raises:
        ValueError: there is none of this name, or its module has no EXPERIMENT.
        TypeError: its EXPERIMENT is something else.
        ImportError: its module cannot be imported; of a file, with the line that failed.
    """
    experiment = experiment_module(name).EXPERIMENT
    if not isinstance(experiment, Experiment):
        raise TypeError(f"{name}: its EXPERIMENT is a {type(experiment).__name__}, not an Experiment")
    if not _is_file(name):
        return replace(experiment, name=name, source=name)
    path = Path(name).expanduser().absolute()
    return replace(experiment, name=path.stem, source=str(path))


def experiment_module(name: str) -> Any:
    """Return the module of an experiment: it has `EXPERIMENT` and, to be reported, `report`.

    Args:
        name: as `load_experiment` takes it.
    """
    if _is_file(name):
        module = _module_in(Path(name).expanduser().absolute())
    elif name in MODULES:
        module = import_module(MODULES[name])
    elif "." in name and all(part.isidentifier() for part in name.split(".")):
        module = import_module(name)
    else:
        raise ValueError(
            f"no experiment {name!r}: there are {', '.join(MODULES)}; one of your own is named by its file "
            "(my.py) or module (my_package.my)"
        )
    if not hasattr(module, "EXPERIMENT"):
        raise ValueError(
            f"{name}: has no EXPERIMENT = Experiment(...); docs/own-experiment.md has one to start from"
        )
    return module


def _is_file(name: str) -> bool:
    return name.endswith(".py")


def _module_in(path: Path) -> ModuleType:
    """Return the module in a file; modules that lie beside it can be imported by it, as by a script."""
    if not path.is_file():
        raise ValueError(f"{path}: there is no such file")
    name = f"arl_experiment_{path.stem}"
    known = sys.modules.get(name)
    if known is not None and known.__file__ == str(path):
        return known
    spec = spec_from_file_location(name, path)
    assert spec is not None, "a file that ends in .py is a module"
    assert spec.loader is not None, "a module in a file has a loader"
    module = module_from_spec(spec)
    sys.modules[name] = module
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        del sys.modules[name]
        reason = _where_it_failed(path, error)
        match error:
            case SyntaxError():
                raise  # it names file and line
            case Exception() | SystemExit():
                raise ImportError(reason) from error
        raise
    return module


def _where_it_failed(path: Path, error: BaseException) -> str:
    """Return file, line and reason of an error in the module of an experiment, in one line."""
    lines = [frame.lineno for frame in extract_tb(error.__traceback__) if frame.filename == str(path)]
    place = f"{path}:{lines[-1]}" if lines else str(path)
    return f"{place}: {type(error).__name__}: {error}"


def root_seeds(trials: int, first: int = 0) -> range:
    """Return the root seeds of the trials: first, first + 1, ..."""
    if trials < 1 or first < 0:
        raise ValueError(f"need trials >= 1 and a first seed >= 0, got {trials} and {first}")
    return range(first, first + trials)


def run_unit(experiment: str, condition: str, root_seed: int, quick: bool) -> str:
    """Play one trial of one condition: what a worker is asked for. All arguments are plain.

    Args:
        experiment: as `load_experiment` takes it; a file by its absolute path.
        condition: name.
        root_seed: of the trial.
        quick: play the smoke-test version.

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
    """Return the settings of each condition as they read back from JSON, by name.

    Settings that came later are left out at their defaults (`core.recording.schema.leave_out_later`), so that
    trials played before there were such settings are still those of their condition.
    """
    settings = {
        condition.name: condition.settings if condition.written is None else condition.written
        for condition in conditions
    }
    plain = msgspec.to_builtins(settings)
    leave_out_later(settings, plain)
    read_back: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(plain))
    return read_back


def _plain(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
