"""What a family of densities of reaction times is; `families` lists them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Family:
    """A density of reaction times, known by its parameters' names."""

    name: str
    parameters: tuple[str, ...]
    kernel: int | None
    """Which fit of `kernels`; None for the ex-Gaussian."""
    bound: float
    """Lower bound of a gamma or Weibull shape, upper bound of the log-normal sigma; 0 for none."""
    freeze: Callable[[Sequence[Any]], Any]
    """Return scipy's frozen distribution(s) for the parameters in order: numbers, or arrays that
    broadcast."""

    @property
    def shifted(self) -> bool:
        """True where an offset is fitted."""
        return self.parameters[-1] == "offset_s"

    def values(self, parameters: dict[str, float]) -> list[float]:
        """Return the parameters in the family's order."""
        return [parameters[name] for name in self.parameters]
