"""Keep Python's garbage collector away from time stamps: a full collection stops all threads for 25-37 ms."""

import gc


class GarbageControl:
    """Collects between episodes, never during one."""

    def __init__(self) -> None:
        self._frozen = False

    def first_paint(self) -> None:
        """Take everything that start-up left behind out of later collections."""
        if not self._frozen:
            gc.collect()
            gc.freeze()
            gc.enable()
            self._frozen = True

    def hold(self) -> None:
        """Collect nothing from here on."""
        gc.disable()

    def collect(self) -> None:
        """Collect now, and as usual from here on."""
        gc.enable()
        gc.collect()

    def restore(self) -> None:
        """Leave the collector as it was found."""
        gc.enable()
        if self._frozen:
            gc.unfreeze()
            self._frozen = False
