"""Keep Python's garbage collector away from time stamps: a full collection stops all threads for 25-37 ms."""

import gc

SWEEP_EVERY = 8
"""Looks between two collections of the youngest objects."""
OLDER_EVERY = 16
"""Such collections between two that take those objects, too, that have survived one."""
ALL_EVERY = 40
"""Looks between two full collections while the game is covered."""
OF_PYTHON = 5_000
"""Objects at most that Python itself has frozen at its start (3.12: some hundreds)."""


class GarbageControl:
    """Collects everything between episodes, and during one only what was made lately.

    Each frame leaves some dozens of objects behind that refer to each other. Without any collection memory
    grows by 1.6 MB a minute: in a long game, and in a pause of an hour. Objects of the last two seconds are
    collected in well under a millisecond.
    """

    def __init__(self) -> None:
        self._begun = self._frozen = False
        self._looks = 0

    def first_paint(self) -> None:
        """Take everything that start-up left behind out of later collections.

        Where a program around this one has frozen objects of its own, nothing more is frozen: `restore`
        could not tell the two apart.
        """
        if not self._begun:
            self._begun = True
            gc.collect()
            self._frozen = gc.get_freeze_count() <= OF_PYTHON
            if self._frozen:
                gc.freeze()
            gc.enable()

    def hold(self) -> None:
        """Collect nothing from here on."""
        gc.disable()

    def look(self, *, covered: bool) -> None:
        """Collect a little where the collector is held back; to be called four times a second.

        Args:
            covered: the game is covered: presses do not count, and there is time for everything.
        """
        if gc.isenabled():
            return
        self._looks += 1
        if covered:
            if self._looks % ALL_EVERY == 0:
                gc.collect()
        elif self._looks % SWEEP_EVERY == 0:
            gc.collect(1 if self._looks % (SWEEP_EVERY * OLDER_EVERY) == 0 else 0)

    def collect(self) -> None:
        """Collect now, and as usual from here on."""
        gc.enable()
        gc.collect()

    def restore(self) -> None:
        """Leave the collector as it was found."""
        gc.enable()
        if self._frozen:
            gc.unfreeze()
        self._begun = self._frozen = False
