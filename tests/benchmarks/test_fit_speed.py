"""Speeds of the reaction-time fits: CPU seconds, medians. Run with `pytest -n 0 -m benchmark_run -s
tests/benchmarks/test_fit_speed.py`."""

import resource
import statistics
import time

import numpy as np
import pytest

from core.numerics.streams import stream
from studies.reaction_time.families import fit_all
from studies.reaction_time.fit import FitSettings, fit_group
from studies.reaction_time.sample import sample
from tests.studies.reaction_time import real

pytestmark = pytest.mark.benchmark_run


def cpu_seconds(action, repeats=9):
    """Median CPU time of `action` after one call to warm up."""
    action()
    spent = []
    for _ in range(repeats):
        start = time.process_time()
        action()
        spent.append(time.process_time() - start)
    return statistics.median(spent)


@pytest.mark.parametrize("limit_s", [None, 0.65], ids=["all answered", "some timed out"])
def test_all_families_of_a_participant_with_100_trials_take_under_half_a_second(limit_s):
    x = 0.2 + stream(1, "speed").gamma(4.8, 0.065, 100)
    late = x >= limit_s if limit_s else np.zeros(100, dtype=bool)
    data = sample(x[~late], np.full(late.sum(), limit_s or 1.0))
    spent = cpu_seconds(lambda: fit_all(data))
    print(f"\nall families, 100 trials, {late.sum()} timed out: {spent * 1e3:.0f} ms")
    assert spent < 0.5


def test_257_participants_with_bootstrap_intervals_take_under_two_minutes_on_two_cores():
    people = {name: sample(times) for name, times in real.go_times().items()}
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    group = fit_group(people, FitSettings(), n_workers=2)
    after, spent = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter() - start
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(
        f"\n{len(people)} participants, {FitSettings().n_resamples} resamples, two workers: "
        f"{cpu:.0f} CPU seconds, {spent:.0f} s on this machine as it was"
    )
    assert len(group.participants) == len(people)
    # Two cores of our own would need half the CPU time; other processes may share them.
    assert cpu / 2 < 120.0
