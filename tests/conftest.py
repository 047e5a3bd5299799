"""What all tests share: no test fails because a machine is slow, none writes into anybody's home, and both
cores have something to do from beginning to end.
"""

import gc
import os
import subprocess
import sys
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

REPOSITORY = Path(__file__).resolve().parents[1]
NEEDS_KERNELS = ("arl_tui", "contracts", "interop", "keepaway", "tetris")
"""Folders of tests that play games: they come after those that need nothing compiled."""
WORTH_COMPILING_AHEAD = 1000
"""A run of so many tests compiles everything on the second core while its first tests run."""
_ahead: list[subprocess.Popen[bytes]] = []

# Programs that tests start come from bytecode, as they do for users: without it each takes a second longer.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# The first example of a property may compile kernels, and machines differ: hypothesis is not to look at the
# clock.
settings.register_profile("no clock", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("no clock")
# Thousands of tests keep millions of objects alive, and every full collection looks at all of them.
gc.set_threshold(20_000, 20, 50)


@pytest.fixture(autouse=True, scope="session")
def _home_of_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep what a test does not keep elsewhere in a folder of this run; processes that tests start inherit
    it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ARL_HOME", str(tmp_path_factory.mktemp("arl-home")))
        yield


@pytest.fixture(scope="session")
def compiled(_home_of_tests: None) -> None:
    """Wait until everything is compiled that sessions need.

    Each of a hundred sessions would begin to compile, and be ended before it is done.
    """
    assert _compile_everything().wait() == 0


def _compile_everything() -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "arl_tui.cli", "warm-up"],
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
    )


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put first what needs nothing compiled, and spread sessions in a terminal between the other files: they
    mostly wait, and where several wait side by side a core has nothing to do.
    """
    files = [list(group) for _, group in groupby(items, key=lambda item: item.path)]
    sessions = [item for group in files if "e2e" in group[0].path.parts for item in group]
    games = [group for group in files if set(NEEDS_KERNELS) & set(group[0].path.parts)]
    first = [group for group in files if group not in games and "e2e" not in group[0].path.parts]
    spread: list[pytest.Item] = []
    tests, so_far, placed = sum(map(len, games)), 0, 0
    for group in games:
        spread += group
        so_far += len(group)
        due = len(sessions) * so_far // tests
        spread += sessions[placed:due]
        placed = due
    items[:] = [*(item for group in first for item in group), *spread, *sessions[placed:]]


def pytest_collection_finish(session: pytest.Session) -> None:
    """Begin to compile, and take what all tests share out of later collections: each drawn session begins
    with a full one.
    """
    first_worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0") == "gw0"
    if first_worker and len(session.items) > WORTH_COMPILING_AHEAD:
        _ahead.append(_compile_everything())
    gc.collect()
    gc.freeze()


def pytest_sessionfinish() -> None:
    """Leave no process behind."""
    for process in _ahead:
        process.kill()
        process.wait()
