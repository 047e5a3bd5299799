"""How long it takes until something is seen. Run by name: `pytest tests/benchmarks/test_startup.py -m benchmark_run`.

Judged by processor time: starting is computing, and on a machine with nothing else to do it is the time that passes.
Wall time is printed beside it.
"""

import os
import statistics
import time
from pathlib import Path

import pytest

from tests.e2e.terminal import Terminal

REPEATS = 7
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
pytestmark = pytest.mark.benchmark_run


def cpu_s(pid: int) -> float:
    """Return the processor time of a running process, without its children, in seconds (resolution 10 ms)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def until_seen(text: str, *arguments: str, folder: Path) -> tuple[float, float]:
    """Return processor and wall time from the start of `arl` to `text` on the screen, in seconds."""
    before = time.perf_counter()
    with Terminal(*arguments, cwd=folder) as terminal:
        while text not in terminal.text:
            assert terminal.pump(0.002), terminal.text
        return cpu_s(terminal.child.pid), time.perf_counter() - before


def judge(name: str, times: list[tuple[float, float]], limit_s: float) -> None:
    """Print the medians and hold the processor time to its limit."""
    cpu, wall = (statistics.median(column) for column in zip(*times, strict=True))
    print(f"{name}: median {cpu:.2f} s of processor time, {wall:.2f} s on the wall, {len(times)} runs")
    assert cpu < limit_s


def test_help_is_there_within_0_4_s(tmp_path: Path) -> None:
    times = [until_seen("Commands:", "--help", folder=tmp_path) for _ in range(REPEATS)]
    judge("help", times, 0.4)


def test_the_first_screen_is_painted_within_0_6_s(tmp_path: Path) -> None:
    times = [until_seen("Teach a computer", "play", "tetris", folder=tmp_path) for _ in range(REPEATS)]
    judge("first paint", times, 0.6)
