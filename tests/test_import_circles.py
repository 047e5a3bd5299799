"""No circle of modules: no file needs one that needs it."""

from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter

import grimp
import pytest

PACKAGES = "core", "studies", "arl_tui"


def imports() -> dict[str, set[str]]:
    """Return what each module imports, inside functions and for type checks only included."""
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def circle_in(graph: Mapping[str, set[str]]) -> list[str]:
    """Return the modules of a circle of imports, the first one again at the end; empty if there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_circle_of_modules() -> None:
    assert circle_in(imports()) == []


@pytest.mark.parametrize(
    ("graph", "circle"),
    [
        ({"a": {"b"}, "b": {"c"}, "c": set()}, set()),
        ({"a": {"b"}, "b": {"c"}, "c": {"b"}}, {"b", "c"}),
    ],
)
def test_a_circle_is_found(graph: dict[str, set[str]], circle: set[str]) -> None:
    assert set(circle_in(graph)) == circle


def test_imports_inside_functions_count() -> None:
    # `arl_tui.session_app` imports the facts of a header only when a session begins.
    assert "arl_tui.app.facts" in imports()["arl_tui.session_app"]
