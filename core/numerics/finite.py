"""Numbers that have overflowed: found where they arise, before a session goes on with them."""

import math
from collections.abc import Iterable, Mapping

import msgspec
import numpy as np

from core.numerics.arrays import Floats

TOO_LARGE = (
    "Rewards, features (psi) or step sizes are too large by many orders of magnitude: features are "
    "about 1 as a rule"
)


class DivergedError(ValueError):
    """Learned numbers have become infinite, or no numbers; the message says which, and what to do."""


def check_learned(arrays: Iterable[Floats], what: str) -> None:
    """Check that what has been learned can still be computed with.

    Raises:
        DivergedError: a number is infinite or NaN.
    """
    if not all(np.isfinite(array).all() for array in arrays):
        raise DivergedError(f"{what} has overflowed: it holds infinite numbers, or none. {TOO_LARGE}")


def check_numbers(record: msgspec.Struct) -> None:
    """Check the numbers of a record: JSON has no word for infinity and NaN, and nobody could read it again.

    Looked at are numbers, lists of numbers, and tables of such lists.

    Raises:
        DivergedError: one is infinite or NaN.
    """
    for name in record.__struct_fields__:
        value = getattr(record, name)
        parts = value.items() if isinstance(value, Mapping) else [(name, value)]
        for part, numbers in parts:
            if not _finite(numbers):
                raise DivergedError(f"{part} of {type(record).__name__} is no finite number. {TOO_LARGE}")


def _finite(value: object) -> bool:
    if isinstance(value, float):
        return math.isfinite(value)
    return not isinstance(value, list) or all(map(_finite, value))
