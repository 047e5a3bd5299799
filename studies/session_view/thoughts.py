"""Decisions of an agent as they are read again: R, H and f(R, H) of its best actions. No compiled code."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

BEST: Final = 5
"""Actions that are kept of each decision, beside the chosen one and what each side alone would have done."""
SLOTS: Final = BEST + 3
THOUGHT: Final = np.dtype(
    [
        ("n", "<i4"), ("chosen", "<i4"), ("environment", "<i4"), ("human", "<i4"), ("policy", "<i4"), ("form", "<i4"),  # noqa: E501
        ("handed", "<i4"), ("known", "<i4"), ("trust", "<f8"), ("weight", "<f8"), ("w_r", "<f8"), ("handover", "<f8"),  # noqa: E501
        ("action", "<i4", (SLOTS,)), ("r", "<f8", (SLOTS,)), ("h", "<f8", (SLOTS,)), ("f", "<f8", (SLOTS,)),
    ]
)  # fmt: skip
"""One decision. `n` actions to choose from; `action` is -1 behind the last one that is kept, best f(R, H)
first."""


@dataclass(frozen=True, slots=True)
class Considered:
    """One action at one decision."""

    action: int
    r: float
    """Value of the environment's side."""
    h: float
    """Value of the human model."""
    f: float
    """Both together, as the scheme combines them (Eq. 2, 3)."""


@dataclass(frozen=True, slots=True)
class Thought:
    """One decision of an agent."""

    n_actions: int
    chosen: int
    environment: int
    """What the environment's side alone would have done."""
    human: int
    """What the human model alone would have done; -1 while it knows nothing."""
    policy: int
    form: int
    handed_over: bool
    """The choice was handed to the human model (control sharing)."""
    human_known: bool
    trust: float
    weight: float
    """Weight w_h in use."""
    w_r: float
    actions: tuple[Considered, ...]
    """Best f(R, H) first; the chosen one and those of each side are among them."""

    @property
    def best(self) -> tuple[Considered, ...]:
        """The best five."""
        return self.actions[:BEST]


class Thoughts:
    """Decisions in a file that may still grow."""

    def __init__(self, path: Path) -> None:
        """Read from a file of a `ThoughtWriter`; it need not exist yet."""
        self._path = path

    def __len__(self) -> int:
        try:
            return os.stat(self._path).st_size // THOUGHT.itemsize
        except FileNotFoundError:
            return 0

    def __getitem__(self, row: int) -> Thought | None:
        """Return a decision by the row of its step; None while it is not known."""
        if not 0 <= row < len(self):
            return None
        with self._path.open("rb") as file:
            file.seek(row * THOUGHT.itemsize)
            entry = np.frombuffer(file.read(THOUGHT.itemsize), dtype=THOUGHT)[0]
        actions = tuple(
            Considered(int(action), float(r), float(h), float(f))
            for action, r, h, f in zip(entry["action"], entry["r"], entry["h"], entry["f"], strict=True)
            if action >= 0
        )
        return Thought(
            int(entry["n"]), int(entry["chosen"]), int(entry["environment"]), int(entry["human"]),
            int(entry["policy"]), int(entry["form"]), bool(entry["handed"]), bool(entry["known"]),
            float(entry["trust"]), float(entry["weight"]), float(entry["w_r"]), actions,
        )  # fmt: skip

    def chosen(self) -> NDArray[np.int32]:
        """Return the chosen action of every decision that is known."""
        if not len(self):
            return np.zeros(0, dtype=np.int32)
        rows = np.memmap(self._path, dtype=THOUGHT, mode="r", shape=(len(self),))
        return np.array(rows["chosen"])
