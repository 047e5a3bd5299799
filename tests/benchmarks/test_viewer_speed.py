"""How fast a large recording opens and is looked through. `pytest -m benchmark_run -n 0
tests/benchmarks/test_viewer_speed.py`."""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from arl_tui.viewer.pictures import pictures_of
from core.events import Event, FrameShown
from studies.session_view.session import open_at_once, open_session
from tests.studies.session_view.made import MS, large, started, taken, write

pytestmark = pytest.mark.benchmark_run


def test_a_million_events_open_in_a_second_and_any_moment_is_found_in_a_tenth(tmp_path: Path) -> None:
    path = large(tmp_path / "large.jsonl")
    began = time.perf_counter()
    part = open_at_once(path)
    assert len(part.games) >= 1
    assert time.perf_counter() - began < 1.0
    assert not part.index.whole
    assert open_session(path).index.events >= 1_000_000
    began = time.perf_counter()
    session = open_session(path)
    assert time.perf_counter() - began < 1.0
    times = []
    for at in np.linspace(session.start_ns, session.end_ns, 200).astype(int).tolist():
        began = time.perf_counter()
        moment = session.at(at)
        if moment.step >= 0:
            session.step_taken(moment.step)
        times.append(time.perf_counter() - began)
    assert max(times) < 0.1


def test_the_end_of_a_game_of_5000_pieces_is_drawn_in_a_tenth(tmp_path: Path) -> None:
    def events() -> Iterator[Event]:
        yield started(0)
        for step in range(5000):
            now = (step + 1) * 1000 * MS
            yield taken(now, step, 2 * step % 10)
            for nth in range(8):
                yield FrameShown(frame=8 * step + nth, step=step, flushed_ns=now + (1 + 100 * nth) * MS)

    session = open_session(write(tmp_path / "long.jsonl", events()))
    pictures_of(session).at(session.at(session.start_ns + 2000 * MS))  # imports
    taken_s = []
    for _ in range(5):
        pictures = pictures_of(session)
        began = time.process_time()
        pictures.at(session.at(session.end_ns))
        taken_s.append(time.process_time() - began)
    assert min(taken_s) < 0.1
