"""Key presses of a simulated participant in compiled play: planned, made when they fall due, and let through
or not.

What counts is what `core.feedback.keys.PressGate` lets through: a budget per episode, and no repeats within
the refractory time. Its rule for held keys has nothing to act on here: judgements and the presses of a burst
are too far apart.
"""

from typing import Final, NamedTuple

import numpy as np

from core.feedback.keys import KeyConfig
from core.numerics.arrays import Bools, Floats, Ints
from core.numerics.clock import NS_PER_MS
from core.numerics.compiled import inner_kernel, kernel

NEVER_NS: Final = (1 << 63) - 1
"""Later than any press."""
LONG_AGO_NS: Final = -(1 << 62)

# Entries of `Presses.counts`.
JUDGED: Final = 0
"""Judgements in this episode."""
WAITING: Final = 1
"""Presses planned and not yet made."""
MADE: Final = 2
"""Presses made in this episode and the pause after it, the refused ones too."""
ACCEPTED: Final = 3
"""Of these, those that count."""
LOST: Final = 4
"""Presses for which there was no room: must stay 0."""
_COUNTS: Final = 5


class Presses(NamedTuple):
    """Presses to come and those of the present episode; room for n of either."""

    due_ns: Ints
    """When presses will be made, earliest first, shape (n,); of equal times the one planned first."""
    due_value: Floats
    """1.0 good, -1.0 bad, shape (n,)."""
    due_step: Ints
    """Number of the step each is about, shape (n,)."""
    due_deliberate: Bools
    """Whether it is wrong on purpose, shape (n,)."""
    made_ns: Ints
    """When presses of this episode were made, shape (n,)."""
    made_value: Floats
    """What they said, shape (n,)."""
    made_step: Ints
    """What they were about, shape (n,)."""
    made_deliberate: Bools
    """Whether they were wrong on purpose, shape (n,)."""
    made_accepted: Bools
    """Whether they counted, shape (n,)."""
    last_ns: Ints
    """When the good and the bad key were last pressed, shape (2,)."""
    counts: Ints
    """JUDGED, WAITING, MADE, ACCEPTED, LOST, shape (5,)."""
    budget: int
    """Presses per episode that count."""
    refractory_ns: int
    """A press of the same key within this time of the one before does not count."""


def new_presses(keys: KeyConfig, room: int) -> Presses:
    """Return an account without presses."""
    return Presses(
        due_ns=np.zeros(room, np.int64),
        due_value=np.zeros(room),
        due_step=np.zeros(room, np.int64),
        due_deliberate=np.zeros(room, np.bool_),
        made_ns=np.zeros(room, np.int64),
        made_value=np.zeros(room),
        made_step=np.zeros(room, np.int64),
        made_deliberate=np.zeros(room, np.bool_),
        made_accepted=np.zeros(room, np.bool_),
        last_ns=np.full(2, LONG_AGO_NS, np.int64),
        counts=np.zeros(_COUNTS, np.int64),
        budget=int(keys.max_presses_per_episode),
        refractory_ns=int(keys.refractory_ms * NS_PER_MS),
    )


@kernel
def renew_budget(presses: Presses) -> None:
    """Give a new budget; presses that are still to come stay."""
    presses.counts[JUDGED] = 0
    presses.counts[MADE] = 0
    presses.counts[ACCEPTED] = 0


@inner_kernel
def plan(presses: Presses, time_ns: int, value: float, step: int, deliberate: bool) -> None:
    """Put a press among those to come."""
    n = presses.counts[WAITING]
    if n >= len(presses.due_ns):
        presses.counts[LOST] += 1
        return
    place = n
    while place > 0 and presses.due_ns[place - 1] > time_ns:
        presses.due_ns[place] = presses.due_ns[place - 1]
        presses.due_value[place] = presses.due_value[place - 1]
        presses.due_step[place] = presses.due_step[place - 1]
        presses.due_deliberate[place] = presses.due_deliberate[place - 1]
        place -= 1
    presses.due_ns[place], presses.due_value[place] = time_ns, value
    presses.due_step[place], presses.due_deliberate[place] = step, deliberate
    presses.counts[WAITING] += 1


@inner_kernel
def is_due(presses: Presses, now_ns: int) -> bool:
    """Return whether a press is to be made now."""
    return bool(presses.counts[WAITING] > 0 and presses.due_ns[0] <= now_ns)


@inner_kernel
def make(presses: Presses) -> bool:
    """Make the press that is due first; return whether it counts. Its time and value: `made_ns`,
    `made_value`.
    """
    place = presses.counts[MADE]
    if place >= len(presses.made_ns):
        presses.counts[LOST] += 1
        place -= 1
    else:
        presses.counts[MADE] += 1
    time_ns, value = presses.due_ns[0], presses.due_value[0]
    key = 0 if value > 0.0 else 1
    accepted = (
        time_ns - presses.last_ns[key] >= presses.refractory_ns and presses.counts[ACCEPTED] < presses.budget
    )
    presses.last_ns[key] = time_ns
    presses.counts[ACCEPTED] += accepted
    presses.made_ns[place], presses.made_value[place] = time_ns, value
    presses.made_step[place], presses.made_deliberate[place] = (
        presses.due_step[0],
        presses.due_deliberate[0],
    )
    presses.made_accepted[place] = accepted
    waiting = presses.counts[WAITING] - 1
    for k in range(waiting):
        presses.due_ns[k], presses.due_value[k] = presses.due_ns[k + 1], presses.due_value[k + 1]
        presses.due_step[k] = presses.due_step[k + 1]
        presses.due_deliberate[k] = presses.due_deliberate[k + 1]
    presses.counts[WAITING] = waiting
    return bool(accepted)
