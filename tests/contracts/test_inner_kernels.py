"""What `core.numerics.compiled.inner_kernel` takes for granted holds everywhere
(`docs/decisions/inner-kernels.md`)."""

import ast
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from core.keepaway.arl_autoplay import ArlAutoplay, ArlKeepawayConfig
from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.keepaway.viewed_match import ViewedMatch
from core.learners.sarsa import SarsaConfig, new_sarsa
from core.numerics.compiled import INNER, inner_kernel

REPOSITORY = Path(__file__).resolve().parents[2]
PLAIN = {"None", "bool", "int", "float"}


def decorators(function: ast.FunctionDef) -> set[str]:
    return {decorator.id for decorator in function.decorator_list if isinstance(decorator, ast.Name)}


@cache
def modules() -> dict[str, ast.Module]:
    """Return the syntax tree of every module of the project, by its dotted name."""
    paths = [
        path for package in ("core", "studies", "arl_tui") for path in (REPOSITORY / package).rglob("*.py")
    ]
    return {
        ".".join(path.relative_to(REPOSITORY).with_suffix("").parts): ast.parse(
            path.read_text(encoding="utf-8")
        )
        for path in paths
    }


@cache
def functions(module: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in ast.walk(module) if isinstance(node, ast.FunctionDef)]


@cache
def imported(module: ast.Module) -> dict[str, str]:
    """Return where a module has its imported names from, as module.name."""
    return {
        alias.asname or alias.name: f"{node.module}.{alias.name}"
        for node in reversed(list(ast.walk(module)))  # of two imports of a name the first counts
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }


def origin(name: str, dotted: str, module: ast.Module) -> str:
    """Return where a module has a name from, as module.name."""
    return imported(module).get(name, f"{dotted}.{name}")


@cache
def inner_kernels() -> dict[str, ast.FunctionDef]:
    return {
        f"{dotted}.{function.name}": function
        for dotted, module in modules().items()
        for function in functions(module)
        if {"inner_kernel", "called_kernel"} & decorators(function)
    }


def fields(record: str, module: ast.Module) -> list[str]:
    """Return the types of the fields of a named tuple that a module defines."""
    (found,) = (node for node in ast.walk(module) if isinstance(node, ast.ClassDef) and node.name == record)
    assert [ast.unparse(base) for base in found.bases] == ["NamedTuple"], f"{record} is no named tuple"
    return [ast.unparse(node.annotation) for node in found.body if isinstance(node, ast.AnnAssign)]


def test_inner_kernels_return_numbers_and_no_arrays():
    assert len(inner_kernels()) > 100
    for name, function in inner_kernels().items():
        returned = ast.unparse(function.returns)
        parts = returned.removeprefix("tuple[").removesuffix("]").split(", ")
        if not set(parts) <= PLAIN:
            parts = fields(returned, modules()[name.rpartition(".")[0]])
        assert set(parts) <= PLAIN, f"{name} returns {returned}"


def test_only_kernels_call_inner_kernels_that_draw():
    draw = {
        name
        for name, function in inner_kernels().items()
        if any("Generator" in ast.unparse(a) or "Streams" in ast.unparse(a) for a in function.args.args)
    }
    assert {"core.keepaway.simulator.game.begin_cycle", "core.learners.sarsa.greedy_or_random"} <= draw
    seen = 0
    for dotted, module in modules().items():
        compiled = [
            f for f in functions(module) if decorators(f) & {"kernel", "inner_kernel", "called_kernel"}
        ]
        in_kernels = {node for function in compiled for node in ast.walk(function)}
        for node in ast.walk(module):
            name = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
            if name and origin(name, dotted, module) in draw:
                assert node in in_kernels, f"{dotted}:{node.lineno} calls {name} from Python"
                seen += 1
    assert seen > 20


def _sum_of_last_rows(rows, out):
    kept = rows[0]
    for i in range(len(rows)):
        if out[0] >= 2.0:
            kept = rows[i]
        for k in range(len(kept)):
            out[0] += kept[k]


@pytest.mark.jit
@pytest.mark.parametrize(("options", "counts"), [(INNER, False), ({}, True)])
def test_code_of_inner_kernels_counts_no_references(options, counts):
    import numba  # only after core.numerics.compiled has named the folder of its cache

    # Not `inner_kernel` itself: a function that comes from the cache has no text to look at.
    summed, out = numba.njit(**options)(_sum_of_last_rows), np.zeros(1)
    summed(np.arange(6.0).reshape(3, 2), out)
    # 0 + 1, then row 0 again since 1 < 2, then row 2: 4 + 5
    assert out[0] == 11.0
    assert any("NRT_" in code for code in summed.inspect_llvm().values()) == counts


@inner_kernel
def _quotient(a, b):
    return a / b


@pytest.mark.jit
def test_an_inner_kernel_divides_by_zero_as_ieee_says():
    assert _quotient(1.0, 0.0) == np.inf
    assert np.isnan(_quotient(0.0, 0.0))


def references(*records) -> list[int]:
    return [sys.getrefcount(part) for record in records for part in record]


@pytest.mark.parametrize("exact_state", [True, False])
def test_playing_keeps_no_reference_to_arrays_or_generators(exact_state):
    config = KeepawayConfig(exact_state=exact_state)
    game = Autoplay(config, 1, "references")
    sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(config), 3, 3)
    shown = ViewedMatch(config, sarsa, 1, "references")
    heard = ArlAutoplay(ArlKeepawayConfig(task=config), 1, "references")

    def play() -> list[int]:
        game.learn(sarsa, 1)
        game.play("random", 1)
        heard.play_episode()
        for _ in range(5):
            shown.step()
        return references(
            game.match,
            game.streams,
            sarsa,
            shown._match,
            shown._streams,
            heard.match,
            heard.streams,
            heard.sarsa,
        )

    assert play() == play()
