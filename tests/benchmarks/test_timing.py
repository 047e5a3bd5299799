"""How exactly reaction times are measured here: `pytest tests/benchmarks/test_timing.py -m benchmark_run -s
-n 0`.

Takes four minutes. Targets (on a quiet machine): at rest bias < 0.5 ms and sd < 0.2 ms; beside a 30 fps board
with a learner in its own process median < 0.5 ms and p95 < 3 ms. Judged by medians, the only figures that
other processes on the machine leave alone; the rest is printed.
"""

import os

import pytest

from arl_tui.commands.timing import report_lines
from arl_tui.timing.plan import CONDITIONS, make_plan
from arl_tui.timing.result import TimingResult, compare
from arl_tui.timing.robot import run_plan
from core.numerics.clock import wall_time_utc

pytestmark = pytest.mark.benchmark_run

LIMITS_MS = {"bare reader": 0.5, "at rest": 0.5, "beside a board": 3.0}


@pytest.mark.parametrize("condition", CONDITIONS)
def test_the_median_error_is_small(condition):
    plan = make_plan(condition, 60, root_seed=1)
    found = compare(plan, *run_plan(plan))
    result = TimingResult(
        created_utc=wall_time_utc(),
        root_seed=1,
        cores=os.cpu_count() or 1,
        load=os.getloadavg()[0],
        software={},
        conditions=(found,),
    )
    print("\n" + "\n".join(list(report_lines(result))[:8]))
    assert found.on_time is not None
    assert found.on_time.median < LIMITS_MS[condition]
