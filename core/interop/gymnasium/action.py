"""What is done at a step of a Gymnasium task, as recordings hold it."""

from core.events import ActionRecord


class EnvAction(ActionRecord, frozen=True):
    """An action and when it was taken."""

    action: int
    """The environment's own number of it (`Discrete.start` is the first)."""
    time: int
    """Steps since the episode began."""
