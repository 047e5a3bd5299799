"""How long it takes until something is seen. Run by name: `pytest -n 0 -s -m benchmark_run
tests/benchmarks/test_startup.py`.

Judged by processor time, as ratios to what a bare Python and a bare Textual program take in the same run:
starting is computing, and on a machine with nothing else to do it is the time that passes. Wall time is
printed beside it.
"""

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import NamedTuple

import pytest

from tests.benchmarks.bare_textual import SEEN
from tests.e2e.terminal import ASKS_AGAIN, PATIENCE_S, REPOSITORY, Terminal

REPEATS = 5
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
COMPILER = "arl_tui.ahead"
"""The process that compiles on another core: nobody waits for it before the first picture."""
pytestmark = pytest.mark.benchmark_run


class Spent(NamedTuple):
    """Seconds."""

    cpu: float
    wall: float


def cpu_s(pid: int, *, alone: bool = False) -> float:
    """Return the processor time of a running process and of all it has started, but for the compiler (to 10
    ms); with `alone`, that of the process itself."""
    if COMPILER in Path(f"/proc/{pid}/cmdline").read_text():
        return 0.0
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    own = (int(fields[11]) + int(fields[12])) / TICKS_PER_S
    if alone:
        return own
    children = Path(f"/proc/{pid}/task").glob("*/children")
    return own + sum(cpu_s(int(child)) for tasks in children for child in tasks.read_text().split())


def of_python(*arguments: str) -> Spent:
    """Return what a Python program takes from start to end."""
    before, start = getrusage(RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL, cwd=REPOSITORY)
    wall, after = time.perf_counter() - start, getrusage(RUSAGE_CHILDREN)
    return Spent(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, wall)


def until_seen(
    text: str,
    *arguments: str,
    folder: Path,
    cache: Path,
    module: str = "arl_tui.cli",
    moving: str | None = None,
) -> Spent:
    """Return what is spent from the start to a text on the screen, or to the second picture of a game after
    it.

    Args:
        text: of the first page.
        arguments: of the command.
        folder: in which it runs.
        cache: of compiled code.
        module: the program.
        moving: what stands on the screen when the game is on; Enter is pressed on the first page.
    """
    before = time.perf_counter()
    exported = {"XDG_CACHE_HOME": str(cache)}
    with Terminal(*arguments, cwd=folder, module=module, exported=exported) as terminal:

        def read_until(seen: Callable[[], bool]) -> None:
            end = time.monotonic() + PATIENCE_S
            while not seen():
                assert terminal.pump(0.002), terminal.text
                assert time.monotonic() < end, terminal.text

        read_until(lambda: text in terminal.text)
        if moving is not None:
            terminal.press("\r")
            read_until(lambda: moving in terminal.text or ASKS_AGAIN in terminal.text)
            if moving not in terminal.text:  # getting ready took long: the page asks once more
                terminal.press("\r")
                read_until(lambda: moving in terminal.text)
            first = terminal.text
            read_until(lambda: terminal.text != first)
        # The worker starts when the first page is painted. What it has spent before the page is read says
        # how busy the machine is, not how long the page took.
        return Spent(cpu_s(terminal.child.pid, alone=moving is None), time.perf_counter() - before)


def judge(name: str, measure: Callable[[], Spent], bare: Callable[[], Spent], limit: float) -> None:
    """Measure both in turns, print the medians, and hold their ratio to a limit."""
    pairs = [(measure(), bare()) for _ in range(REPEATS)]
    ours, theirs = (
        Spent(statistics.median(s.cpu for s in column), statistics.median(s.wall for s in column))
        for column in zip(*pairs, strict=True)
    )
    ratio = ours.cpu / theirs.cpu
    print(
        f"\n{name}: {ours.cpu:.2f} s of processor time ({ours.wall:.2f} s on the wall), "
        f"bare {theirs.cpu:.2f} s ({theirs.wall:.2f} s): {ratio:.1f} times"
    )
    assert ratio < limit


@pytest.fixture
def bare_textual(tmp_path: Path) -> Callable[[], Spent]:
    return lambda: until_seen(SEEN, folder=tmp_path, cache=tmp_path, module="tests.benchmarks.bare_textual")


@pytest.fixture(scope="module")
def bytecode(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bytecode")


@pytest.fixture(autouse=True)
def keep_bytecode(monkeypatch: pytest.MonkeyPatch, bytecode: Path) -> None:
    """Let Python keep its bytecode, as it does for a user: without, each start translates every source."""
    monkeypatch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
    monkeypatch.setenv("PYTHONPYCACHEPREFIX", str(bytecode))


def test_help_takes_less_than_ten_bare_starts_of_python() -> None:
    judge(
        "help", lambda: of_python("-m", "arl_tui.cli", "--help"), lambda: of_python("-c", "pass"), limit=10.0
    )


@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_the_first_page_takes_less_than_twice_bare_textual(
    tmp_path: Path, bare_textual: Callable[[], Spent], game: str
) -> None:
    def first_page() -> Spent:
        return until_seen("only your opinion", "play", game, folder=tmp_path, cache=tmp_path / "none")

    judge(f"first page of {game}", first_page, bare_textual, limit=2.0)


@pytest.mark.parametrize("cache", ["empty", "full"])
@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_the_first_moving_picture(
    tmp_path: Path, bare_textual: Callable[[], Spent], game: str, cache: str
) -> None:
    runs = iter(range(REPEATS + 1))

    def first_picture() -> Spent:
        folder = tmp_path / ("full" if cache == "full" else f"empty-{next(runs)}")
        return until_seen("only your opinion", "demo", game, folder=tmp_path, cache=folder, moving="Game 1")

    if cache == "full":
        exported = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "full")}
        subprocess.run(
            [sys.executable, "-m", "arl_tui.cli", "warm-up"], check=True, env=exported, cwd=REPOSITORY
        )
    # Three seconds are asked for; a bare start takes about a sixth of one.
    judge(f"first picture of {game}, {cache} cache", first_picture, bare_textual, limit=18.0)
