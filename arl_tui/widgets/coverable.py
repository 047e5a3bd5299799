"""Words over a game, so that it waits and there is nothing to judge."""

from textual.widget import Widget


class CoverableWidget(Widget, inherit_bindings=False, can_focus=False):
    """A picture of a game that can be covered; how a cover looks is the picture's business."""

    _cover_text: tuple[str, ...] = ()
    _cover_whole = True

    def cover(self, text: str, *, whole: bool = True) -> None:
        """Write a few short lines over the game, until `uncover`.

        Args:
            text: lines; what is longer than the game is wide is cut off.
            whole: hide the whole game, so that there is nothing to judge; otherwise only a band around the
                text.
        """
        self._cover_text = tuple(text.splitlines()) or ("",)
        self._cover_whole = whole
        self.refresh()

    def uncover(self) -> None:
        """Show the game again."""
        self._cover_text = ()
        self.refresh()

    @property
    def covered(self) -> bool:
        """Whether something is written over the game."""
        return bool(self._cover_text)

    @property
    def hidden_whole(self) -> bool:
        """Whether nothing of the game is to be seen."""
        return self.covered and self._cover_whole

    def covering(self, y: int, height: int) -> str | None:
        """Return what is written over line y of a game of so many lines; None where the game itself is to be
        seen.
        """
        line = y - (height - len(self._cover_text)) // 2
        if not self.covered or not (self._cover_whole or -1 <= line <= len(self._cover_text)):
            return None
        return self._cover_text[line] if 0 <= line < len(self._cover_text) else ""
