"""Does `arl study status --watch` delay the stamps of key presses? Some minutes, by name, quiet machine:
`pytest -n 0 -s -m benchmark_run tests/benchmarks/test_monitor_timing.py`.

One study session in a terminal. Keys are written to it at random moments, in blocks with and without a
monitor in a second terminal, in turn. Key to stamp is the time from just before a key is written to the time
that the recording gives it; both are of the same clock.
"""

import os
import select
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from core.events import KeyPressed
from core.numerics.streams import stream
from tests.e2e.terminal import START, Terminal
from tests.e2e.test_study import STUDY, Lab, consent

PAIRS = 6
"""Blocks with a monitor, and as many without one."""
KEYS = 40
"""Keys in a block."""
MOMENT_S = (0.2, 0.5)
"""Shortest and longest time between two keys."""
SETTLED_S = 4.0
"""A monitor that has been started, or a place where one was, is left alone for so long."""
TOLERATED_MS = 5.0
"""`arl timing` calls a key late from here on."""
LONG = (
    STUDY.replace("episodes = 2", "episodes = 200")
    .replace("watched_steps = 7", "watched_steps = 200")
    .replace("unseen_between = 4", "unseen_between = 0")
    .replace("tick_ms = 70", "tick_ms = 100")
    .replace("[protocol.session]", "[protocol.keys]\nmax_presses_per_episode = 10000\n[protocol.session]")
)


def read(terminals: Sequence[Terminal], duration_s: float) -> None:
    """Take what the programs write, and make nothing of it."""
    files = [terminal.child.child_fd for terminal in terminals]
    end = time.monotonic() + duration_s
    while (left_s := end - time.monotonic()) > 0:
        for file in select.select(files, [], [], left_s)[0]:
            os.read(file, 65536)


def block(session: Terminal, lab: Lab, *, watched: bool, rng: np.random.Generator) -> list[tuple[str, int]]:
    """Press keys for a block; return each with the time just before it was written, ns."""
    with ExitStack() as stack:
        terminals = [session]
        if watched:
            monitor = Terminal("study", "status", str(lab.folder / "study.toml"), "--watch", cwd=lab.folder)
            terminals.append(stack.enter_context(monitor))
            while b"presses per minute" not in monitor.received:
                monitor.pump(0.05)
                read([session], 0.05)
        read(terminals, SETTLED_S)
        pressed = []
        for number in range(KEYS):
            key = "jf"[number % 2]
            pressed.append((key, session.press(key)))
            read(terminals, rng.uniform(*MOMENT_S))
    return pressed


def delays_ms(pressed: list[tuple[str, int]], recorded: list[KeyPressed]) -> NDArray[np.float64]:
    """Return the time from key to stamp of each key that is in the recording, milliseconds."""
    ends = [time_ns for _, time_ns in pressed[1:]] + [pressed[-1][1] + 1_000_000_000]
    found = [
        next(
            (
                event.time_ns - at_ns
                for event in recorded
                if event.key == key and at_ns <= event.time_ns < end
            ),
            None,
        )
        for (key, at_ns), end in zip(pressed, ends, strict=True)
    ]
    return np.array([delay_ns / 1e6 for delay_ns in found if delay_ns is not None])


def interval(with_it: list[float], without: list[float]) -> tuple[float, float, float]:
    """Return the mean difference of pairs of blocks, and the ends of its 95 % interval (Student's t)."""
    differences = np.array(with_it) - np.array(without)
    error = differences.std(ddof=1) / np.sqrt(len(differences))
    reach = float(stats.t.ppf(0.975, len(differences) - 1)) * error
    return float(differences.mean()), float(differences.mean() - reach), float(differences.mean() + reach)


@pytest.mark.jit
@pytest.mark.benchmark_run
def test_a_monitor_does_not_delay_the_stamps_of_keys(tmp_path: Path) -> None:
    lab, rng = Lab(tmp_path, LONG), stream(1, "monitor timing")
    pressed: dict[bool, list[list[tuple[str, int]]]] = {True: [], False: []}
    with lab.run("--participant", "P1") as session:
        consent(session)
        session.wait_for(START)
        session.begin("Game 1")
        for pair in range(PAIRS):
            for watched in (True, False) if pair % 2 else (False, True):
                pressed[watched].append(block(session, lab, watched=watched, rng=rng))
            print(f"{pair + 1} of {PAIRS} pairs of blocks", flush=True)
        read([session], 2.0)
        session.child.kill(9)
    (found,) = lab.blocks()
    recorded = [event for event in found.recording.events if isinstance(event, KeyPressed)]
    delays = {watched: [delays_ms(keys, recorded) for keys in blocks] for watched, blocks in pressed.items()}
    for watched, blocks in delays.items():
        every = np.concatenate(blocks)
        print(
            f"{'with' if watched else 'without'} a monitor: {len(every)} of {PAIRS * KEYS} keys, median "
            f"{np.median(every):.2f} ms, p95 {np.percentile(every, 95):.2f} ms"
        )
        assert len(every) > 0.95 * PAIRS * KEYS
    for name, percent in (("median", 50.0), ("p95", 95.0)):
        of_blocks = {
            watched: [float(np.percentile(one, percent)) for one in blocks]
            for watched, blocks in delays.items()
        }
        mean, low, high = interval(of_blocks[True], of_blocks[False])
        print(
            f"{name} of a block, with minus without: {mean:+.2f} ms, 95 % interval {low:+.2f} to {high:+.2f}"
        )
        assert name != "median" or mean < TOLERATED_MS
