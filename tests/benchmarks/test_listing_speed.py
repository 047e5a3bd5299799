"""How fast a long recording is listed, beside the time that hashing the same file takes. Run with
`pytest -n 0 -m benchmark_run -s tests/benchmarks/test_listing_speed.py`."""

import hashlib
import statistics
import time
from pathlib import Path

import pytest

from core.recording.skim import skim_recording
from tests.studies.session_view.made import large

pytestmark = pytest.mark.benchmark_run


def cpu_s(action) -> float:
    start = time.process_time()
    action()
    return time.process_time() - start


def hashed(path: Path) -> None:
    """Do what no check of a recording can do without."""
    running = hashlib.sha256()
    with path.open("rb") as file:
        while part := file.read(1 << 18):
            running.update(part)


def test_a_million_events_of_which_a_third_are_presses_are_listed_in_8_times_their_hashing(tmp_path):
    """0.5 s of CPU, with SHA-256 in hardware (0.08 s); without it the ratio is smaller."""
    path = large(tmp_path / "presses.jsonl")
    assert skim_recording(path).summary.presses_counted == 330_000
    # In turns, so that a busy moment of the machine meets both.
    times = [(cpu_s(lambda: skim_recording(path)), cpu_s(lambda: hashed(path))) for _ in range(7)]
    listing_s, hashing_s = (statistics.median(each) for each in zip(*times, strict=True))
    print(f"\n1,000,000 events: listed in {listing_s:.2f} s of CPU, hashed in {hashing_s:.3f} s")
    assert listing_s < 8 * hashing_s
