"""How Sphinx builds the documentation: `sphinx-build -W --keep-going -b html docs build/docs`."""

import re
import sys
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

project = "arl-tui"
author = "The arl-tui authors"
project_copyright = "2026, the arl-tui authors"
release = version_of("arl-tui")
version = release

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_click"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["figures", "film"]
myst_enable_extensions = ["colon_fence", "dollarmath", "deflist"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"arl-tui {release}"
html_static_path: list[str] = []

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
nitpicky = False

_CODE = re.compile(r"(``?[^`]+``?)")
"""Quoted code in a docstring; what lies between is prose."""
_COLON = "\ue000"
"""Stands for a colon while napoleon works; no text has it."""


def _plain_text(_app: Any, what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Read docstrings as the plain text that they are: `code` is code, and a star or a bar is itself."""
    for number, line in enumerate(lines):
        parts = _CODE.split(line)
        for index, part in enumerate(parts):
            if index % 2:
                parts[index] = f"``{part.strip('`')}``"
            else:
                parts[index] = re.sub(r"([*|])|_(?=\W|$)", lambda found: "\\" + found[0], part)
        lines[number] = "".join(parts)
        if what in ("attribute", "property", "data"):  # napoleon takes what precedes a colon for a type
            lines[number] = lines[number].replace(":", _COLON)


def _colons_again(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    lines[:] = [line.replace(_COLON, ":") for line in lines]


def setup(app: Any) -> None:
    """Register the reading of docstrings."""
    app.connect("autodoc-process-docstring", _plain_text, priority=100)
    app.connect("autodoc-process-docstring", _colons_again, priority=900)
