"""What users import: every name is there, is documented, and is loaded only when it is asked for."""

import ast
import inspect
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import pytest

import arl_tui
import core
import studies

PACKAGES = [core, studies]
MARKED = [arl_tui, core, studies]


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.__name__)
def test_every_public_name_is_there_and_documented(package: ModuleType) -> None:
    for name in package.__all__:
        found = getattr(package, name)
        if inspect.isclass(found) or inspect.isfunction(found):
            assert inspect.getdoc(found), name
            assert found.__name__ == name
        assert name in dir(package)


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.__name__)
def test_type_checkers_see_the_same_names_from_the_same_places(package: ModuleType) -> None:
    tree = ast.parse(Path(str(package.__file__)).read_text(encoding="utf-8"))
    seen = {
        alias.name: node.module
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == package._PLACES
    assert sorted(package.__all__) == sorted(seen)


@pytest.mark.parametrize("package", MARKED, ids=lambda package: package.__name__)
def test_a_name_that_is_not_there_is_an_attribute_error(package: ModuleType) -> None:
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        _ = package.nonsense


@pytest.mark.parametrize("package", MARKED, ids=lambda package: package.__name__)
def test_the_package_says_that_it_is_typed(package: ModuleType) -> None:
    assert (Path(str(package.__file__)).parent / "py.typed").is_file()


def test_the_version_is_the_distribution_s() -> None:
    assert arl_tui.__version__ == version("arl-tui")


def test_importing_the_packages_loads_no_module_of_theirs_and_no_arrays() -> None:
    script = "import arl_tui, core, studies, sys; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert not {name for name in loaded if name.startswith(("core.", "studies.", "arl_tui."))}
    assert not loaded & {"numpy", "numba", "msgspec", "textual"}
