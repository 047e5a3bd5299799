"""When the agent poses a question, and how it is answered. No compiled code is imported."""

from typing import Annotated, ClassVar

import msgspec

from core.configuration.fields import number, text

NO_ANSWER = -1
"""In place of the option for the key that says: none of these."""
ANTICIPATED_NS = 100_000_000
"""A key pressed earlier after a question came on screen was not pressed because of it (100 ms)."""
AnswerKey = Annotated[str, text("one lower-case letter a-z or one digit")]


class AskingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When the agent poses a choice of candidate actions (`core.combination.asking`;
    `docs/decisions/asking.md`).
    """

    per_episode: Annotated[int, number("questions", ge=0, le=1_000_000)] = 0
    """Questions per watched episode at most. 0: the agent never asks, as in the paper's experiments."""
    options: Annotated[int, number("actions", ge=2, le=3)] = 3
    """Candidate actions of a question at most, 2 or 3."""
    share: Annotated[float, number(gt=0, lt=1)] = 0.05
    """It asks where its policies disagree more than in all but this fraction of recent decisions, in (0, 1).
    (Our choice.)"""
    memory: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 200
    """How many recent decisions that fraction is of. (Our choice.)"""
    minimum_decisions: Annotated[int, number("decisions", ge=1, le=1_000_000)] = 20
    """It does not ask before it has seen this many. (Our choice.)"""
    limit_s: Annotated[float, number("seconds", gt=0, le=3600, usual=(2, 120))] = 10.0
    """A question that is not answered after so long on screen is taken back, and nothing is learned from it.
    (Our choice.)"""
    settle_s: Annotated[float, number("seconds", ge=0, le=60)] = 2.0
    """The game stands still for so long before a question covers it, and presses still count: what was last
    seen can be judged first. (Our choice: as long as the final picture of an episode stays.)"""
    keys: tuple[AnswerKey, AnswerKey, AnswerKey] = ("1", "2", "3")
    """Keys of the first, second and third option."""
    none_key: AnswerKey = "0"
    """Key for "none of these": the game goes on, and nothing is learned."""

    LATER: ClassVar[frozenset[str]] = frozenset({"limit_s", "settle_s", "keys", "none_key"})
    """Settings that came after version 0.2: at their defaults they are not written to recordings."""

    def __post_init__(self) -> None:
        if self.per_episode < 0 or self.options not in (2, 3) or not 0 < self.share < 1:
            raise ValueError(
                "asking needs per_episode >= 0, 2 or 3 options and a share in (0, 1), got "
                f"{self.per_episode}, {self.options}, {self.share}"
            )
        if not 1 <= self.minimum_decisions <= self.memory:
            raise ValueError(
                f"need 1 <= minimum_decisions <= memory, got {self.minimum_decisions} and {self.memory}"
            )
        if not (0 < self.limit_s <= 3600 and 0 <= self.settle_s <= 60):
            raise ValueError(
                f"asking needs limit_s in (0, 3600] and settle_s in [0, 60] seconds, got {self.limit_s} and "
                f"{self.settle_s}"
            )
        for key in self.answer_keys:
            if len(key) != 1 or not (key.isascii() and (key.islower() or key.isdigit())):
                raise ValueError(f"a key of an answer is one lower-case letter a-z or one digit, got {key!r}")
        if len(set(self.answer_keys)) != len(self.answer_keys):
            raise ValueError(f"answers need different keys, got {', '.join(self.answer_keys)}")

    @property
    def answer_keys(self) -> tuple[str, ...]:
        """Keys of the options, and the one for none of them."""
        return (*self.keys, self.none_key)

    def option_of(self, key: str, n_options: int) -> int | None:
        """Return which of n options (1 to 3) a key chooses, from 0.

        `NO_ANSWER` for the key that chooses none; None for a key that is no answer.
        """
        if key == self.none_key:
            return NO_ANSWER
        offered = self.keys[:n_options]
        return offered.index(key) if key in offered else None
