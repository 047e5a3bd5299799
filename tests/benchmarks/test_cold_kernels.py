"""What compiling takes on an empty cache. Run by name: `pytest -n 0 -s -m benchmark_run
tests/benchmarks/test_cold_kernels.py`.

Judged as a ratio to a program that starts numba and compiles one addition, in turns in the same run.
"""

import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

import pytest

from tests.e2e.terminal import REPOSITORY

REPEATS = 3
LIMIT = 40.0
"""In November 2026 it was 27 to 32."""
ONE_ADDITION = """
import numba

@numba.njit
def add(a, b):
    return a + b

add(1.0, 2.0)
"""


def cpu_s(arguments: tuple[str, ...], cache: Path) -> float:
    """Return the processor time of a Python program and of all it starts, with this folder as its cache."""
    before = getrusage(RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *arguments],
        check=True,
        stdout=subprocess.DEVNULL,
        env=os.environ | {"XDG_CACHE_HOME": str(cache)},
        cwd=REPOSITORY,
    )
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.jit
@pytest.mark.benchmark_run
def test_all_kernels_take_less_than_forty_starts_of_numba(tmp_path: Path) -> None:
    ours, bare = [], []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory(dir=tmp_path) as empty:
            ours.append(cpu_s(("-m", "arl_tui.cli", "warm-up"), Path(empty)))
        bare.append(cpu_s(("-c", ONE_ADDITION), tmp_path))
    ratio = statistics.median(ours) / statistics.median(bare)
    print(
        f"\narl warm-up, empty cache: {statistics.median(ours):.1f} s of processor time, "
        f"one addition {statistics.median(bare):.2f} s: {ratio:.1f} times"
    )
    assert ratio < LIMIT
