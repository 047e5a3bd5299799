"""How long real people take to react and to evaluate, and how much credit reaches what they judged.

Credit is measured on held-out presses: a density is fitted to one half of a person's delays and shares out
the presses of the other half among steps that follow each other without gaps. What was judged happens u
seconds after its step of T seconds appeared; the press comes d seconds later and gives that step the
density's mass between u + d - T and u + d (section 3.3). Either u is anywhere in the step, or 0: the step's
appearance is what was judged.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from core.feedback.delays import Density, GammaDelay, UniformDelay
from core.numerics.arrays import Floats
from core.numerics.clock import NS_PER_S
from studies.evaluations.table import EvaluationColumns, read_evaluations
from studies.reaction_time.exclusion import SLOW_ABOVE_S, ExclusionPolicy, select
from studies.reaction_time.families import GAMMA, FamilyFit, fit_all, fit_family
from studies.reaction_time.read import read_rows
from studies.reaction_time.results import DATA_SETS
from studies.reaction_time.sample import Sample, sample

STEPS_S = (0.5, 1.0, 2.0)
"""Lengths of steps for which credit is measured: seconds."""
FEWEST = 20
"""People with fewer delays are left out where halves of them are fitted."""
FEWEST_OF_A_VALUE = 5
MOMENTS = tuple((i + 0.5) / 10 for i in range(10))
"""Where in its step something happens, as fractions of the step: evenly spread."""
ONSET = (0.0,)


@dataclass(frozen=True, eq=False)
class Delays:
    """The delays of all people in one task."""

    name: str
    source: str
    licence: str
    slow_above_s: float
    times_s: dict[str, Floats]
    """Person to delays, seconds, shape (n,), in the order of the file."""
    values: dict[str, Floats]
    """Person to the values given with them, shape (n,); empty where nothing was evaluated."""
    left_out: int
    """Rows that the task's limits leave out, and rows without a time."""

    @cached_property
    def samples(self) -> dict[str, Sample]:
        """The delays as fits take them."""
        return {name: sample(times) for name, times in self.times_s.items()}

    @cached_property
    def together(self) -> Floats:
        """All delays, shape (n,)."""
        return np.concatenate(list(self.times_s.values()))

    @cached_property
    def fits_together(self) -> tuple[FamilyFit, ...]:
        """All families on all delays, best AIC first."""
        return fit_all(sample(self.together))

    @cached_property
    def fits(self) -> dict[str, tuple[FamilyFit, ...]]:
        """All families for each person, best AIC first."""
        return {name: fit_all(one) for name, one in self.samples.items()}

    @cached_property
    def medians(self) -> Floats:
        """Each person's median delay, seconds, shape (people,)."""
        return np.array([np.median(times) for times in self.times_s.values()])

    def shapes(self, family: str) -> Floats:
        """Return each person's shape in one of the gammas, shape (people,)."""
        return np.array([fit_of(fits, family).parameters["shape"] for fits in self.fits.values()])

    def best(self) -> Counter[str]:
        """Return how many people each family fits best."""
        return Counter(fits[0].family for fits in self.fits.values())


def fit_of(fits: Sequence[FamilyFit], family: str) -> FamilyFit:
    """Return one family's fit among several."""
    return next(fit for fit in fits if fit.family == family)


def reactions(folder: Path) -> list[Delays]:
    """Read the two public sets of reaction times with the limits of reactions.

    Raises:
        ReadError: a file cannot be used. OSError: there is none.
    """
    sets = []
    for data_set in DATA_SETS:
        rows = read_rows([folder / "reaction_time" / data_set.file], data_set.columns)
        samples, selection = select(rows, ExclusionPolicy())
        kept: dict[str, list[float]] = {name: [] for name in samples}
        for row, verdict in zip(rows, selection.verdicts, strict=True):
            if verdict == "kept" and row.participant in kept and row.rt_s is not None:
                kept[row.participant].append(row.rt_s)
        sets.append(
            Delays(
                name=data_set.name,
                source=data_set.source,
                licence=data_set.licence,
                slow_above_s=SLOW_ABOVE_S["reaction"],
                times_s={name: np.array(times) for name, times in kept.items()},
                values={},
                left_out=len(rows) - sum(map(len, kept.values())),
            )
        )
    return sets


def evaluations(folder: Path) -> Delays:
    """Read the evaluations of a robot (CHARM) with the limits of evaluations.

    Raises:
        ImporterError: the file cannot be used. OSError: there is none.
    """
    columns = EvaluationColumns(participant="participant", time="stamp_unix_s", by=("set",))
    table = read_evaluations(folder / "evaluation_delays" / "charm.csv", columns)
    least_s, slow_above_s = ExclusionPolicy().anticipation_below_s, SLOW_ABOVE_S["evaluation"]
    times: dict[str, Floats] = {}
    values: dict[str, Floats] = {}
    n = 0
    for key, session in table.sessions.items():
        n += len(session)
        kept = [
            (one.delay_ns / NS_PER_S, one.value)
            for one in session
            if one.delay_ns is not None and least_s <= one.delay_ns / NS_PER_S <= slow_above_s
        ]
        times[" ".join(key)] = np.array([time for time, _ in kept])
        values[" ".join(key)] = np.array([value for _, value in kept])
    return Delays(
        name="evaluations",
        source="CHARM (Fang et al. 2025, arXiv 2506.13079), evaluations of a robot from -2 to 2",
        licence="no licence stated: figures only",
        slow_above_s=slow_above_s,
        times_s=times,
        values=values,
        left_out=n - sum(map(len, times.values())) + table.left_out.total(),
    )


# --- how the delay depends on the value ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class OfValue:
    """Delays of the evaluations of one value."""

    value: float
    n: int
    quantiles_s: tuple[float, float, float]
    """5, 50 and 95 %."""
    ratio: float
    """Geometric mean over people of their geometric mean delay at this value by that at all values."""
    ratio_se: float
    """Standard error of its logarithm over people."""
    people: int
    """People with at least `FEWEST_OF_A_VALUE` evaluations of this value."""


def by_value(delays: Delays) -> list[OfValue]:
    """Return the delays of each value, and how they compare within people."""
    found = []
    everything = np.concatenate(list(delays.values.values()))
    for value in np.unique(everything):
        logs = []
        for name, times in delays.times_s.items():
            at = delays.values[name] == value
            if at.sum() >= FEWEST_OF_A_VALUE:
                logs.append(float(np.log(times[at]).mean() - np.log(times).mean()))
        some = delays.together[everything == value]
        low, middle, high = np.quantile(some, (0.05, 0.5, 0.95))
        found.append(
            OfValue(
                value=float(value),
                n=int(some.size),
                quantiles_s=(float(low), float(middle), float(high)),
                ratio=float(np.exp(np.mean(logs))),
                ratio_se=float(np.std(logs, ddof=1) / np.sqrt(len(logs))),
                people=len(logs),
            )
        )
    return found


def fractions_of_variance(delays: Delays) -> dict[str, float]:
    """Return which part of the variance of log delays people explain, and which values explain beyond them.

    Sequential sums of squares: person first, then the value within people.
    """
    logs = {name: np.log(times) for name, times in delays.times_s.items()}
    together = np.concatenate(list(logs.values()))
    total = float(((together - together.mean()) ** 2).sum())
    between = sum(x.size * (x.mean() - together.mean()) ** 2 for x in logs.values())
    fractions = {"person": float(between / total)}
    if delays.values:
        within = np.concatenate([x - x.mean() for x in logs.values()])
        values = np.concatenate(list(delays.values.values()))
        explained = sum(within[values == v].size * within[values == v].mean() ** 2 for v in np.unique(values))
        fractions["value"] = float(explained / total)
    return fractions


# --- credit -------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, kw_only=True)
class CreditOnTarget:
    """How much credit of a rule reaches the step that was judged."""

    rule: str
    share: dict[float, Floats]
    """Length of steps in seconds to each person's mean share, shape (people,), in [0, 1]."""


def credit_on_target(delays: Delays, moments: Sequence[float] = MOMENTS) -> list[CreditOnTarget]:
    """Return, for several rules, the credit that reaches the judged step, on held-out presses of each person.

    Each person's delays are taken alternately into two halves; each half is scored with the fit of the other.
    What is common to all people is fitted to the other people's delays.

    Args:
        delays: of one task; people with fewer than `FEWEST` are left out.
        moments: where in its step what is judged happens, fractions of the step in [0, 1).
    """
    people = [name for name, times in delays.times_s.items() if times.size >= FEWEST]
    shares: dict[str, dict[float, list[float]]] = {}
    for name in people:
        for rule, per_step in _of_person(delays, name, moments).items():
            for step_s, share in per_step.items():
                shares.setdefault(rule, {}).setdefault(step_s, []).append(share)
    return [
        CreditOnTarget(rule=rule, share={step_s: np.array(each) for step_s, each in per_step.items()})
        for rule, per_step in shares.items()
    ]


def _of_person(delays: Delays, name: str, moments: Sequence[float]) -> dict[str, dict[float, float]]:
    times = delays.times_s[name]
    values = delays.values.get(name)
    others = [other for other in delays.times_s if other != name]
    common = _gamma(np.concatenate([delays.times_s[other] for other in others]))
    fixed: dict[str, Density] = {
        "paper: gamma(2.5, 0.3)": GammaDelay(),
        "TAMER: uniform(0.2, 0.8)": UniformDelay(),
        "one gamma of all others": common,
    }
    per_rule: dict[str, list[tuple[Floats, Density]]] = {
        rule: [(times, density)] for rule, density in fixed.items()
    }
    ratios = _ratios(delays, others) if values is not None else {}
    for half in (0, 1):
        train, test = times[half::2], times[1 - half :: 2]
        own = _gamma(train)
        per_rule.setdefault("a gamma of one's own", []).append((test, own))
        if values is None:
            continue
        said = values[1 - half :: 2]
        slower = float(np.mean([ratios[abs(v)] for v in values[half::2]]))
        for size in np.unique(np.abs(said)):
            at = np.abs(said) == size
            for rule, base, mean_ratio in (
                ("all others', by the value's size", common, 1.0),
                ("one's own, by the value's size", own, slower),
            ):
                factor = ratios[float(size)] / mean_ratio
                scaled = GammaDelay(shape=base.shape, scale_s=base.scale_s * factor)
                per_rule.setdefault(rule, []).append((test[at], scaled))
    return {
        rule: {step_s: _share(parts, step_s, moments) for step_s in STEPS_S}
        for rule, parts in per_rule.items()
    }


def _gamma(times: Floats) -> GammaDelay:
    p = fit_family(GAMMA, sample(times)).parameters
    return GammaDelay(shape=p["shape"], scale_s=p["scale_s"])


def _ratios(delays: Delays, people: Sequence[str]) -> Mapping[float, float]:
    """Return each value's size and the mean of its delays by the mean of all, over some people."""
    times = np.concatenate([delays.times_s[name] for name in people])
    sizes = np.abs(np.concatenate([delays.values[name] for name in people]))
    return {float(size): float(times[sizes == size].mean() / times.mean()) for size in np.unique(sizes)}


def _share(parts: Sequence[tuple[Floats, Density]], step_s: float, moments: Sequence[float]) -> float:
    """Return the mean credit of the judged step over presses and moments."""
    shares = []
    for times, density in parts:
        ages = times[:, None] + step_s * np.array(moments)
        mass = density.cdf(ages.ravel()) - density.cdf(np.maximum(ages - step_s, 0.0).ravel())
        shares.append(mass)
    return float(np.concatenate(shares).mean())
