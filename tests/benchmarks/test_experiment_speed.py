"""CPU seconds of a trial: `pytest -m benchmark_run tests/benchmarks/test_experiment_speed.py -s -n 0`."""

import time

import pytest

from studies.experiments.sweep import load_experiment, run_unit

BUDGET_S = {"fig5": 600.0, "fig6": 600.0}
"""Seconds in which 20 trials of every condition are to be done on two cores (Fig. 5: asked for; Fig. 6:
ours)."""
SEEDS = (900_001, 900_002)


@pytest.mark.jit
@pytest.mark.benchmark_run
@pytest.mark.parametrize("name", BUDGET_S)
def test_a_figure_of_twenty_trials_fits_its_budget(name):
    conditions = [condition.name for condition in load_experiment(name).conditions]
    run_unit(name, conditions[0], 0, True)  # compiles
    total_s = 0.0
    for condition in conditions:
        start = time.process_time()
        for seed in SEEDS:
            run_unit(name, condition, seed, False)
        seconds = (time.process_time() - start) / len(SEEDS)
        print(f"{name} {condition}: {seconds:.1f} CPU s per trial")
        total_s += seconds
    assert total_s * 20 / 2 < BUDGET_S[name]
