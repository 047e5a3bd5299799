"""How fast a large recording opens and is looked through. `pytest -m benchmark_run -n 0
tests/benchmarks/test_viewer_speed.py`."""

import time
from pathlib import Path

import numpy as np
import pytest

from core.events import FrameShown
from studies.session_view.session import open_session
from tests.studies.session_view.made import MS, ended, pressed, started, taken, write

pytestmark = pytest.mark.benchmark_run


def test_a_million_events_open_in_a_second_and_any_moment_is_found_in_a_tenth(tmp_path: Path) -> None:
    events: list = []
    for step in range(330_000):
        now = step * 1000 * MS
        if step % 50 == 0:
            events.append(started(now, step // 50))
        events += [
            taken(now, step, step % 9, step // 50),
            FrameShown(frame=step, step=step, flushed_ns=now + MS),
        ]
        events.append(pressed(now + 500 * MS, step, step))
        if step % 50 == 49:
            events.append(ended(now + 900 * MS, step // 50))
    path = write(tmp_path / "large.jsonl", events)
    del events
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
