"""Delay densities and credit rules, as settings. No numerical library is imported: a protocol is read without
one.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Protocol, assert_never

import msgspec

from core.configuration.fields import number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

HORIZON_MASS = 1e-6
"""Mass of a density beyond its horizon; credit takes it to lie at the horizon."""


class DelayDensity(Protocol):
    """What credit needs of a density of the delay; any class that has both can be one
    (`docs/extending.md`).
    """

    @property
    def horizon_s(self) -> float:
        """Delay in seconds, > 0, beyond which at most `HORIZON_MASS` is left."""
        ...

    def cdf(self, delay_s: "ArrayLike") -> "NDArray[np.float64]":
        """Return the probability of a delay of at most `delay_s` >= 0 seconds, in [0, 1], element by
        element.
        """
        ...


class GammaDelay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="gamma"):
    """Gamma density of the delay, shifted by an offset (Fig. 4).

    The paper's gamma(2.5, 0.3) is shape and scale in seconds: mean shape * scale_s = 0.75 s, mode
    (shape - 1) * scale_s = 0.45 s. Its text puts the mean about 0.5 s before the press, which holds for
    neither reading of the numbers; we build the numbers (`docs/decisions/credit-of-a-press.md`).
    """

    shape: Annotated[float, number(gt=0, le=1e9, usual=(0.05, 1000))] = 2.5
    """Shape k, dimensionless, > 0 (Fig. 4)."""
    scale_s: Annotated[float, number("seconds", gt=0, le=1e6, usual=(0.0001, 10))] = 0.3
    """Scale theta in seconds, > 0 (Fig. 4)."""
    offset_s: Annotated[float, number("seconds", ge=0, le=1e6, usual=(0, 10))] = 0.0
    """Shortest possible delay in seconds, >= 0. (The paper has none.)"""

    def __post_init__(self) -> None:
        if not (math.isfinite(self.shape) and self.shape > 0):
            raise ValueError(f"gamma delay: shape is > 0, got {self.shape}")
        if not (math.isfinite(self.scale_s) and self.scale_s > 0):
            raise ValueError(f"gamma delay: scale_s is > 0 seconds, got {self.scale_s}")
        if not (math.isfinite(self.offset_s) and self.offset_s >= 0):
            raise ValueError(f"gamma delay: offset_s is >= 0 seconds, got {self.offset_s}")

    @property
    def mean_s(self) -> float:
        """Mean delay in seconds."""
        return self.shape * self.scale_s + self.offset_s

    def cdf(self, delay_s: "ArrayLike") -> "NDArray[np.float64]":
        """Return the probability of a delay of at most `delay_s` seconds, element by element."""
        # Not at the top: reading a protocol must not wait for these.
        import numpy as np
        from scipy.special import gammainc

        beyond_offset_s = np.maximum(np.asarray(delay_s, dtype=np.float64) - self.offset_s, 0.0)
        return np.asarray(gammainc(self.shape, beyond_offset_s / self.scale_s), dtype=np.float64)

    @property
    def horizon_s(self) -> float:
        """Delay in seconds beyond which less than `HORIZON_MASS` is left."""
        return self.offset_s + self.scale_s * _gamma_horizon(self.shape)


class UniformDelay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="uniform"):
    """Uniform density of the delay on [low_s, high_s]."""

    low_s: Annotated[float, number("seconds", ge=0, le=1e6, usual=(0, 10))] = 0.2
    """Shortest delay in seconds, >= 0 (TAMER's code: nobody reacts faster)."""
    high_s: Annotated[float, number("seconds", gt=0, le=1e6, usual=(0, 20))] = 0.8
    """Longest delay in seconds, > low_s (TAMER's code: a window of 0.6 s)."""

    def __post_init__(self) -> None:
        if not (0 <= self.low_s < self.high_s < math.inf):
            raise ValueError(f"uniform delay: need 0 <= low_s < high_s, got {self.low_s} and {self.high_s}")

    def cdf(self, delay_s: "ArrayLike") -> "NDArray[np.float64]":
        """Return the probability of a delay of at most `delay_s` seconds, element by element."""
        import numpy as np  # not at the top: see GammaDelay.cdf

        delay_s = np.asarray(delay_s, dtype=np.float64)
        return np.clip((delay_s - self.low_s) / (self.high_s - self.low_s), 0.0, 1.0)

    @property
    def mean_s(self) -> float:
        """Mean delay in seconds."""
        return (self.low_s + self.high_s) / 2

    @property
    def horizon_s(self) -> float:
        """The longest delay, in seconds."""
        return self.high_s


class PreviousStep(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="previous"):
    """All credit to the step before the one on screen: in Tetris, the piece that last landed.

    TAMER's rule for Tetris (Knox & Stone 2009). With nothing on screen it is the last step that was.
    """


class CurrentStep(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="current"):
    """All credit to the step on screen: feedback "instantaneous" to the letter (section 3.2)."""


Density = GammaDelay | UniformDelay
PressRule = Density | PreviousStep | CurrentStep
"""What one press is shared out by: `rule_for`."""


class ValueDelay(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Density of the delay of presses of one value."""

    value: Annotated[float, number(ge=-1000, le=1000)]
    """What the press says: -1 or 1; -2, -1, 0, 1 or 2 where feedback is graded."""
    delay: Density = GammaDelay()
    """Density of the delay of these presses."""


def _measured(median_s: float) -> GammaDelay:
    """Return the gamma density of the paper's shape, 2.5, with this median (to three digits)."""
    return GammaDelay(2.5, round(median_s / _MEDIAN_OF_UNIT_SCALE, 3))


_MEDIAN_OF_UNIT_SCALE = 2.1757
"""Median of gamma(2.5, 1)."""


class PerValueDelay(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="per-value"):
    """A density of the delay for each value: people are fast when they are sure.

    The defaults have the medians of 5,349 evaluations on the scale from -2 to 2 (`docs/results/delays.md`):
    0.75 s for -2 and 2, 1.15 s for -1 and 1, 1.53 s for 0; the shape is the paper's, 2.5.
    """

    values: tuple[ValueDelay, ...] = tuple(
        ValueDelay(value, _measured(median_s))
        for value, median_s in ((-2.0, 0.75), (-1.0, 1.15), (0.0, 1.53), (1.0, 1.15), (2.0, 0.75))
    )
    """The density of each value, every value once."""
    other: Density = GammaDelay()
    """Density of presses of all other values."""

    def __post_init__(self) -> None:
        listed = [each.value for each in self.values]
        if len(set(listed)) < len(listed):
            raise ValueError(f"per-value delay: values have one density each, got {listed}")

    def for_value(self, value: float) -> Density:
        """Return the density of presses of a value."""
        return next((each.delay for each in self.values if each.value == value), self.other)

    @property
    def densities(self) -> tuple[Density, ...]:
        """All densities, those of the values first."""
        return (*(each.delay for each in self.values), self.other)

    @property
    def horizon_s(self) -> float:
        """Delay in seconds beyond which at most `HORIZON_MASS` of any density is left."""
        return max(density.horizon_s for density in self.densities)


Delay = PressRule | PerValueDelay
"""Any credit rule; msgspec decodes it by its tag, the field "type"."""


def rule_for(delay: Delay, value: float) -> PressRule:
    """Return by what a press of this value is shared out."""
    return delay.for_value(value) if isinstance(delay, PerValueDelay) else delay


def parse_delay(text: str) -> Delay:
    """Return the credit rule that `text` names: the inverse of `describe`.

    Args:
        text: "gamma", "gamma:SHAPE,SCALE", "gamma:SHAPE,SCALE,OFFSET", "uniform", "uniform:LOW,HIGH",
            "previous" or "current"; in seconds, except for SHAPE. "per-value", or a density for each value:
            "per-value:2=gamma:2.5,0.3;0=gamma:2.5,0.7;other=gamma".
    """
    name, colon, rest = text.strip().partition(":")
    if name == "per-value":
        return _parse_per_value(text, rest) if colon else PerValueDelay()
    kinds: dict[str, tuple[type[PressRule], tuple[int, ...]]] = {
        "gamma": (GammaDelay, (2, 3)),
        "uniform": (UniformDelay, (2,)),
        "previous": (PreviousStep, ()),
        "current": (CurrentStep, ()),
    }
    if name not in kinds:
        known = ", ".join([*kinds, "per-value"])
        raise ValueError(f"unknown credit rule {text!r}: use one of {known}, as in gamma:2.5,0.3")
    kind, counts = kinds[name]
    if not colon:
        return kind()
    try:
        numbers = [float(part) for part in rest.split(",")]
    except ValueError:
        raise ValueError(f"credit rule {text!r}: expected numbers after {name!r}, got {rest!r}") from None
    if len(numbers) not in counts:
        wanted = " or ".join(str(count) for count in counts) or "no"
        raise ValueError(f"credit rule {text!r}: {name!r} takes {wanted} numbers, got {len(numbers)}")
    return kind(*numbers)


def one_density(delay: Density | PerValueDelay) -> Density:
    """Return the density of all presses, for what knows no values: experiments.

    Raises:
        ValueError: each value of a press has its own.
    """
    if isinstance(delay, PerValueDelay):
        raise ValueError(  # noqa: TRY004 - a setting is wrong, not a type
            "experiments have one density of the delay for all presses: gamma or uniform"
        )
    return delay


def _parse_per_value(text: str, rest: str) -> PerValueDelay:
    """Return the rule with a density for each value."""
    values: list[ValueDelay] = []
    other: Density = PerValueDelay().other
    for part in filter(None, rest.split(";")):
        name, equals, density_text = part.partition("=")
        density = parse_delay(density_text) if equals else None
        if not isinstance(density, Density):
            raise ValueError(  # noqa: TRY004 - the text is wrong, not its type
                f"credit rule {text!r}: expected VALUE=gamma:... or VALUE=uniform:..., got {part!r}"
            )
        if name.strip() == "other":
            other = density
            continue
        try:
            values.append(ValueDelay(float(name), density))
        except ValueError:
            raise ValueError(f"credit rule {text!r}: {name!r} is no value of a press") from None
    return PerValueDelay(tuple(values), other)


def describe(delay: Delay) -> str:
    """Return the text that `parse_delay` turns back into an equal rule."""
    match delay:
        case PerValueDelay(values=values, other=other):
            parts = [f"{_plain(each.value)}={describe(each.delay)}" for each in values]
            return "per-value:" + ";".join([*parts, f"other={describe(other)}"])
        case GammaDelay(shape=shape, scale_s=scale_s, offset_s=offset_s):
            numbers = [shape, scale_s] + ([offset_s] if offset_s else [])
            return "gamma:" + ",".join(map(_plain, numbers))
        case UniformDelay(low_s=low_s, high_s=high_s):
            return f"uniform:{_plain(low_s)},{_plain(high_s)}"
        case PreviousStep():
            return "previous"
        case CurrentStep():
            return "current"
        case _:
            assert_never(delay)


@lru_cache(maxsize=64)
def _gamma_horizon(shape: float) -> float:
    from scipy.special import gammainccinv  # not at the top: see GammaDelay.cdf

    return float(gammainccinv(shape, HORIZON_MASS))


def _plain(number: float) -> str:
    return repr(float(number)).removesuffix(".0")
