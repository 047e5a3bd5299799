"""The runner: what is played, where it is written, and that nothing depends on who played it."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path

import msgspec
import numpy as np
import pytest
from click.testing import CliRunner

from arl_tui.commands import experiment as command
from studies.experiments.results import read_results
from studies.experiments.run import (
    SWEEP_FILE,
    SweepError,
    dask_cluster,
    planned_units,
    read_record,
    run_sweep,
)
from studies.experiments.sweep import (
    MODULES,
    Condition,
    csv_text,
    describe_settings,
    load_experiment,
    root_seeds,
    run_unit,
)
from studies.pools import processes
from tests.e2e.processes import children, left_after
from tests.studies.tiny_experiment import EXPERIMENT, Tiny

ROOT = Path(__file__).resolve().parents[3]


class Inline(Executor):
    """Runs what is submitted at once, and remembers it."""

    def __init__(self, most: int = 10**9) -> None:
        self.calls: list[tuple] = []
        self.most = most

    def submit(self, fn, /, *args, **kwargs):
        self.calls.append(args)
        future: Future = Future()
        if len(self.calls) > self.most:
            future.set_exception(KeyboardInterrupt())
        else:
            try:
                future.set_result(fn(*args, **kwargs))
            except ArithmeticError as error:
                future.set_exception(error)
        return future


class Falling(msgspec.Struct, frozen=True):
    """Settings with a scheme in them."""

    scheme: dict[str, object]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("seed-*.csv"))}


def test_each_trial_of_each_condition_has_one_file_with_a_row_per_episode(tmp_path):
    files = run_sweep(EXPERIMENT, root_seeds(3, first=7), tmp_path, Inline())
    assert len(files) == 6
    assert sorted(contents(tmp_path)) == sorted(str(path.relative_to(tmp_path)) for path in files)
    lines = (tmp_path / "high" / "seed-0000008.csv").read_text().splitlines()
    assert lines[0] == "episode,score,count"
    assert [line.split(",")[0] for line in lines[1:]] == list("012345")


def test_numbers_are_read_back_exactly(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path, Inline())
    results = read_results(EXPERIMENT, tmp_path)
    assert results.seeds == (0, 1, 2)
    for seed, trial in zip(results.seeds, results.trials["high"], strict=True):
        expected = EXPERIMENT.trial(EXPERIMENT.condition("high").settings, seed)
        assert np.array_equal(trial["score"], expected["score"])
    assert results.table("low", "count").shape == (3, 6)
    assert results.blocks("low", "count", 4).tolist() == [[1.5]] * 3


def test_trials_pair_by_seed_across_conditions(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(4), tmp_path, Inline())
    results = read_results(EXPERIMENT, tmp_path)
    assert results.table("high", "score") - results.table("low", "score") == pytest.approx(3.0)


def test_what_was_played_before_is_not_played_again(tmp_path):
    first = Inline()
    run_sweep(EXPERIMENT, root_seeds(2), tmp_path, first)
    before = contents(tmp_path)
    (tmp_path / "low" / "seed-0000001.csv").unlink()
    second = Inline()
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path, second)
    assert len(first.calls) == 4
    assert {(call[1], call[2]) for call in second.calls} == {("low", 1), ("low", 2), ("high", 2)}
    after = contents(tmp_path)
    assert {name: after[name] for name in before} == before


def test_progress_counts_what_is_there_and_then_every_trial(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline())
    seen: list[tuple[int, int]] = []
    run_sweep(EXPERIMENT, root_seeds(2), tmp_path, Inline(), on_progress=lambda *now: seen.append(now))
    assert seen == [(2, 4), (3, 4), (4, 4)]


def test_trials_are_planned_seed_by_seed():
    units = planned_units(EXPERIMENT.conditions, [5, 6])
    assert [(unit.condition, unit.root_seed) for unit in units] == [
        ("low", 5),
        ("high", 5),
        ("low", 6),
        ("high", 6),
    ]


def test_a_run_that_was_killed_leaves_whole_files_and_goes_on(tmp_path):
    whole = tmp_path / "whole"
    run_sweep(EXPERIMENT, root_seeds(30), whole, Inline())
    arguments = [
        "experiment",
        "run",
        EXPERIMENT.name,
        "--trials",
        "30",
        "--workers",
        "2",
        "--out",
        str(tmp_path),
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "arl_tui.cli", *arguments],
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    folder = tmp_path / EXPERIMENT.name
    deadline = time.monotonic() + 600
    while len(contents(folder)) < 3 and time.monotonic() < deadline:
        time.sleep(0.01)
    workers = children(process.pid)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert left_after(workers, 600.0) == set(), "workers outlive their run"
    left = contents(folder)
    assert 3 <= len(left) < 60
    assert left.items() <= contents(whole).items()
    again = Inline()
    run_sweep(EXPERIMENT, root_seeds(30), folder, again)
    assert len(again.calls) == 60 - len(left)
    assert contents(folder) == contents(whole)


def test_an_interrupted_run_keeps_what_was_finished(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run_sweep(EXPERIMENT, root_seeds(3), tmp_path, Inline(most=4))
    assert len(contents(tmp_path)) <= 4
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path, Inline())
    assert len(contents(tmp_path)) == 6


def test_processes_and_threads_give_the_same_bytes(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path / "one", Inline())
    with ThreadPoolExecutor(3) as pool:
        run_sweep(EXPERIMENT, root_seeds(3), tmp_path / "threads", pool)
    with processes(2) as pool:
        run_sweep(EXPERIMENT, root_seeds(3), tmp_path / "processes", pool)
    assert contents(tmp_path / "threads") == contents(tmp_path / "one")
    assert contents(tmp_path / "processes") == contents(tmp_path / "one")


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_of_two_workers_gives_the_same_bytes(tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask is not installed (extra: cluster)")
    run_sweep(EXPERIMENT, root_seeds(4), tmp_path / "one", Inline())
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        dask_cluster(cluster.scheduler_address) as pool,
    ):
        run_sweep(EXPERIMENT, root_seeds(4), tmp_path / "cluster", pool)
    assert contents(tmp_path / "cluster") == contents(tmp_path / "one")


def test_results_of_other_settings_are_not_mixed_in(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline())
    changed = dataclasses.replace(
        EXPERIMENT, conditions=(EXPERIMENT.conditions[0], Condition("high", "high", Tiny(4.0)))
    )
    with pytest.raises(SweepError, match="condition high was played with other settings"):
        run_sweep(changed, root_seeds(2), tmp_path, Inline())
    with pytest.raises(SweepError, match="choose another folder"):
        run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline(), quick=True)


def test_results_from_before_schedules_were_said_are_gone_on_with(tmp_path):
    def condition(**scheme) -> Condition:
        return Condition("high", "high", Falling({"type": "annealed", "decay": 0.98, **scheme}))

    def experiment(**scheme):
        return dataclasses.replace(EXPERIMENT, conditions=(EXPERIMENT.conditions[0], condition(**scheme)))

    run_sweep(experiment(), root_seeds(1), tmp_path, Inline(), only=["low"])
    record = read_record(tmp_path)
    before = msgspec.structs.replace(record, conditions=describe_settings([condition()]))
    (tmp_path / "sweep.json").write_bytes(msgspec.json.encode(before))
    with pytest.raises(SweepError, match="condition high was played with other settings"):
        run_sweep(experiment(per="watched-game"), root_seeds(1), tmp_path, Inline(), only=["high"])
    played = tmp_path / "high" / "seed-0000000.csv"
    played.parent.mkdir()
    played.write_text("score\n1\n")
    run_sweep(experiment(per="episode"), root_seeds(1), tmp_path, Inline(), only=["high"])
    assert read_record(tmp_path).conditions["high"]["scheme"]["per"] == "episode"


def test_the_record_names_settings_and_every_program_that_added_trials(tmp_path):
    for commit in ("a", "b", "a"):
        run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline(), software={"commit": commit})
    record = read_record(tmp_path)
    assert record is not None
    assert record.conditions["high"] == {
        "mean": 3.0,
        "places": [1, 2],
        "episodes": 6,
        "seconds": 0.05,
        "fails": False,
    }
    assert [versions["commit"] for versions in record.software] == ["a", "b"]


def test_only_trials_that_all_conditions_have_are_compared(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path, Inline())
    (tmp_path / "low" / "seed-0000001.csv").unlink()
    assert read_results(EXPERIMENT, tmp_path).seeds == (0, 2)
    assert read_results(EXPERIMENT, tmp_path, only=["high"]).seeds == (0, 1, 2)


def test_a_condition_that_has_hardly_begun_is_left_out_and_named(tmp_path):
    run_sweep(EXPERIMENT, root_seeds(5), tmp_path, Inline(), only=["low"])
    run_sweep(EXPERIMENT, root_seeds(2), tmp_path, Inline(), only=["high"])
    results = read_results(EXPERIMENT, tmp_path)
    assert (results.seeds, results.conditions, results.left_out) == ((0, 1, 2, 3, 4), ("low",), {"high": 2})
    run_sweep(EXPERIMENT, root_seeds(3), tmp_path, Inline())
    assert read_results(EXPERIMENT, tmp_path).seeds == (0, 1, 2)


def test_an_empty_folder_says_what_to_do(tmp_path):
    with pytest.raises(SweepError, match="arl experiment run"):
        read_results(EXPERIMENT, tmp_path)
    run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline(), only=["low"])
    with pytest.raises(SweepError, match="no trial was played under every condition"):
        read_results(EXPERIMENT, tmp_path, only=["low", "high"])


def test_a_trial_that_fails_stops_the_run_with_its_error(tmp_path):
    broken = dataclasses.replace(
        EXPERIMENT, conditions=(Condition("broken", "broken", Tiny(0.0, fails=True)),)
    )

    class Broken(Inline):
        def submit(self, fn, /, name, condition, seed, quick):
            return super().submit(
                lambda *_: csv_text(broken.trial(broken.condition(condition).settings, seed)), name
            )

    with pytest.raises(ArithmeticError, match="cannot be played"):
        run_sweep(broken, root_seeds(1), tmp_path, Broken())
    assert contents(tmp_path) == {}


def test_a_damaged_record_is_named(tmp_path):
    (tmp_path / SWEEP_FILE).write_text("{")
    with pytest.raises(SweepError, match="not a sweep's record"):
        run_sweep(EXPERIMENT, root_seeds(1), tmp_path, Inline())


def test_nobody_answers_at_a_wrong_address():
    pytest.importorskip("distributed")
    unused = "tcp://127.0.0.1:1"
    with pytest.raises(SweepError, match=unused), dask_cluster(unused, timeout_s=0.5):
        pass


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(ValueError, match="one length"):
        csv_text({"a": np.zeros(2), "b": np.zeros(3)})


def test_the_command_lists_every_experiment_that_there_is():
    assert set(command.NAMES) == set(MODULES)


def test_a_quick_run_names_the_command_that_finds_its_trials(tmp_path: Path):
    options = ["--trials", "1", "--workers", "1", "--out", str(tmp_path)]
    done = CliRunner().invoke(command.experiment, ["run", EXPERIMENT.name, "--quick", *options])
    assert done.exit_code == 0, done.output
    _, following = " ".join(done.output.split()).split("Next: arl experiment ")
    assert following.split() == ["report", EXPERIMENT.name, "--out", str(tmp_path), "--quick"]
    assert contents(tmp_path / f"{EXPERIMENT.name}-quick")


@pytest.mark.parametrize("name", sorted(MODULES))
def test_every_experiment_can_be_loaded_and_its_settings_written_down(name):
    experiment = load_experiment(name)
    assert experiment.name == name
    for condition in experiment.conditions:
        plain = msgspec.json.encode(msgspec.to_builtins(condition.settings))
        quick = msgspec.json.encode(msgspec.to_builtins(experiment.quick(condition.settings)))
        assert plain != quick


def test_unknown_experiments_and_conditions_are_refused_with_what_there_is():
    with pytest.raises(ValueError, match="fig5"):
        load_experiment("fig99")
    with pytest.raises(ValueError, match="low, high"):
        run_unit(EXPERIMENT.name, "middle", 0, False)
