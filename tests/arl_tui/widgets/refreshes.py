"""What a widget asked to be drawn anew."""

from typing import Any

import pytest
from textual.geometry import Region
from textual.widget import Widget


def refreshes_of(widget: type[Widget], monkeypatch: pytest.MonkeyPatch) -> list[tuple[Region, ...]]:
    """Return a list that will hold the regions of every refresh of such a widget; () is the whole of it."""
    asked: list[tuple[Region, ...]] = []
    refresh = widget.refresh

    def noting(self: Widget, *regions: Region, **options: Any) -> Widget:
        asked.append(regions)
        return refresh(self, *regions, **options)

    monkeypatch.setattr(widget, "refresh", noting)
    return asked
