"""What is done at a step of Keepaway, as recordings hold it."""

from core.events import ActionRecord


class ChosenOption(ActionRecord, frozen=True):
    """A keeper's decision."""

    keeper: int
    """Who decided, from 0."""
    cycle: int
    """When, in cycles of 100 ms since the episode began."""
    target: int
    """The keeper that the ball is passed to; -1: it is held."""
