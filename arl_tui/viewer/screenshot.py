"""A screen of the viewer as cells, and as files: SVG and PNG."""

from pathlib import Path
from typing import Any

from textual.app import App

from arl_tui.viewer.raster import Cells, cells_of, picture_of
from core.numerics.clock import NS_PER_S


def screen_cells(app: App[Any]) -> Cells:
    """Return what an app shows, character by character."""
    # Textual draws its own screenshots from here, too.
    return cells_of(app.screen._compositor.render_strips())


def save_screen(app: App[Any], recording: Path, after_ns: int) -> str:
    """Save the screen as SVG and PNG in the app's folder; return where, or why not.

    Args:
        app: whose screen it is; its `saved_in` says where.
        recording: whose name the files get.
        after_ns: time since the session's beginning, part of the name.
    """
    folder: Path = getattr(app, "saved_in", Path.cwd())
    stem = f"{recording.name.removesuffix('.jsonl')}-{after_ns / NS_PER_S:.2f}s"
    number, path = 2, folder / f"{stem}.svg"
    while path.exists() or path.with_suffix(".png").exists():
        path = folder / f"{stem}-{number}.svg"
        number += 1
    png = path.with_name(path.name.removesuffix(".svg") + ".png")
    try:
        path.write_text(app.export_screenshot(title=f"arl watch {recording.name}"), encoding="utf-8")
        picture_of(screen_cells(app)).save(png)
    except OSError as error:
        return f"{folder} cannot be written: {error.strerror}"
    return f"Saved {path} and .png"
