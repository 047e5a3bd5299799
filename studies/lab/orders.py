"""Orders of conditions: which order belongs to which place in a study. They follow from the study's seed
alone.
"""

from typing import assert_never

import numpy as np

from core.numerics.streams import stream
from studies.lab.config import LatinSquare, Listed, PermutedBlocks, Study

Order = tuple[str, ...]
"""Names of conditions, first to last."""


def williams_square(n: int) -> tuple[tuple[int, ...], ...]:
    """Return the rows of a Latin square balanced for order and for immediate succession (Williams 1949).

    Args:
        n: number of conditions, >= 1.

    Returns:
        Rows of the numbers 0 to n - 1: n rows where n is even (or 1), else 2 n. In every column each number
        comes equally often; each ordered pair of different numbers stands side by side equally often.

    Raises:
        ValueError: n < 1.
    """
    if n < 1:
        raise ValueError(f"a Latin square needs at least one condition, got {n}")
    zigzag = [(k + 1) // 2 if k % 2 else (n - k // 2) % n for k in range(n)]
    rows = [tuple((step + row) % n for step in zigzag) for row in range(n)]
    if n % 2 and n > 1:
        rows += [row[::-1] for row in rows]
    return tuple(rows)


def orders_per_cycle(study: Study) -> int:
    """Return after how many places the study is balanced."""
    match study.assignment:
        case LatinSquare():
            return len(williams_square(len(study.conditions)))
        case PermutedBlocks(each=each):
            return each * len(study.conditions)
        case Listed(orders=orders):
            return len(orders)
        case other:
            assert_never(other)


def order_of(study: Study, place: int) -> Order:
    """Return the order of conditions that belongs to a place.

    Args:
        study: with at least one condition.
        place: from 0; places beyond `study.participants` go on in the same way.

    Returns:
        Names of conditions, one per block with an assigned condition. A single name serves all of them.

    Raises:
        ValueError: `place` < 0.
    """
    if place < 0:
        raise ValueError(f"a place is >= 0, got {place}")
    cycle, row = divmod(place, orders_per_cycle(study))
    names = list(study.conditions)
    match study.assignment:
        case LatinSquare():
            # Which condition is called 0, 1, ... is drawn once; which row comes when, anew in every cycle.
            labels = [names[i] for i in stream(study.seed, "labels").permutation(len(names))]
            square = williams_square(len(names))
            rows = stream(study.seed, "orders", cycle).permutation(len(square))
            rounds = study.assigned_blocks // len(names)
            return tuple(
                labels[number]
                for again in range(rounds)
                for number in square[rows[(row + again) % len(rows)]]
            )
        case PermutedBlocks(each=each):
            numbers = np.repeat(np.arange(len(names)), each)
            return (names[stream(study.seed, "orders", cycle).permutation(numbers)[row]],)
        case Listed(orders=orders):
            return orders[row]
        case other:
            assert_never(other)
