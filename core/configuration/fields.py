"""How a field of a configuration says its range, its unit and what is usual.

The range (`ge`, `gt`, `le`, `lt`) holds wherever a configuration is read by `core.configuration.reading`,
headers of recordings included. What is usual holds for protocols that are about to be run: a value outside it
is a slip (milliseconds for seconds, say). A struct that is made in Python checks by itself what its own
arithmetic needs.
"""

import math
from dataclasses import dataclass

import msgspec

RANGE = "range"
CHOICES = "choices"
ALLOWED = "allowed"


def one_of(choices: tuple[str, ...]) -> msgspec.Meta:
    """Return the annotation of a text that is one of these."""
    return msgspec.Meta(extra={CHOICES: choices})


def text(allowed: str) -> msgspec.Meta:
    """Return the annotation of a text; `allowed` says in words which ones there are."""
    return msgspec.Meta(extra={ALLOWED: allowed})


@dataclass(frozen=True, slots=True)
class Range:
    """The range of a number, as `number` declared it."""

    unit: str = ""
    ge: float | None = None
    gt: float | None = None
    le: float | None = None
    lt: float | None = None
    usual: tuple[float, float] | None = None

    def holds(self, value: float) -> bool:
        """Return whether a value is inside; NaN is not."""
        return (
            not (isinstance(value, float) and math.isnan(value))  # a long integer is no float
            and (self.ge is None or value >= self.ge)
            and (self.gt is None or value > self.gt)
            and (self.le is None or value <= self.le)
            and (self.lt is None or value < self.lt)
        )

    def is_usual(self, value: float) -> bool:
        """Return whether a value is one that a protocol may have."""
        return self.usual is None or self.usual[0] <= value <= self.usual[1]

    def __str__(self) -> str:
        """Return the range in words, with its unit: what a protocol may have."""
        if self.usual is not None:
            low, high = self.usual
            open_low = self.gt is not None and low <= self.gt
            text = f"> {plain(low)}, at most {plain(high)}" if open_low else f"{plain(low)} to {plain(high)}"
        else:
            parts = [
                f"{sign} {plain(bound)}"
                for sign, bound in ((">=", self.ge), (">", self.gt), ("<=", self.le), ("<", self.lt))
                if bound is not None
            ]
            text = " and ".join(parts)
            if self.ge is not None and self.le is not None:
                text = f"{plain(self.ge)} to {plain(self.le)}"
        return f"{text} {self.unit}".strip()


def number(
    unit: str = "",
    *,
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    usual: tuple[float, float] | None = None,
) -> msgspec.Meta:
    """Return the annotation of a number.

    Args:
        unit: in words, such as "seconds"; empty for a number without one.
        ge: lowest value, included.
        gt: lowest value, excluded.
        le: highest value, included.
        lt: highest value, excluded.
        usual: lowest and highest value of a protocol that is about to be run, both included; None: the whole
        range.
    """
    return msgspec.Meta(extra={RANGE: Range(unit, ge, gt, le, lt, usual)})


def plain(value: float) -> str:
    """Return a number as short as possible: 5, not 5.0."""
    return (
        f"{value:,.0f}".replace(",", "") if float(value).is_integer() and abs(value) <= 1e9 else f"{value:g}"
    )
