"""Damaged results of experiments: named, played again, never averaged in."""

import dataclasses
import json
import shutil
from pathlib import Path

import msgspec
import pytest

from studies.experiments.results import DamagedSweep, read_beside, read_results
from studies.experiments.run import SWEEP_FILE, SweepError, run_sweep
from studies.experiments.trial_file import DamagedTrial, Played, read_rows, read_trials, seal_of, seal_path
from tests.studies.experiments.test_experiment_runs import Inline
from tests.studies.tiny_experiment import EXPERIMENT

FIRST = "low/seed-0000000.csv"


def played(folder: Path) -> Path:
    run_sweep(EXPERIMENT, range(3), folder, Inline())
    return folder


def every_file(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def cut_at_a_line(content: bytes) -> bytes:
    return content[: content.rindex(b"\n", 0, -1) + 1]


DAMAGE = {
    "empty": lambda content: b"",
    "cut within a line": lambda content: content[:-4],
    "cut at a line": cut_at_a_line,
    "cut to its header": lambda content: content[: content.index(b"\n") + 1],
    "binary": lambda content: b"\x00\xff" * 50,
    "another number": lambda content: content.replace(b"0.", b"1.", 1),
    "a word": lambda content: content.replace(b"\n0,", b"\nzero,", 1),
    "a row less within": lambda content: b"\n".join([*content.split(b"\n")[:3], *content.split(b"\n")[4:]]),
    "a row twice": lambda content: content.replace(b"\n1,", b"\n1,0,0\n1,", 1),
    "a column less": lambda content: b"\n".join(line.rpartition(b",")[0] for line in content.split(b"\n")),
    "no header": lambda content: content.partition(b"\n")[2],
    "other line ends": lambda content: content.replace(b"\n", b"\r\n"),
}
"""Damage that a copy, a full disk or an editor does."""


@pytest.mark.parametrize("sealed", [True, False], ids=["sealed", "from before seals"])
@pytest.mark.parametrize("damage", DAMAGE.values(), ids=DAMAGE)
def test_damage_is_named_and_the_trial_played_again(tmp_path, damage, sealed):
    folder = played(tmp_path / "sweep")
    whole = every_file(folder)
    if not sealed:
        for seal in folder.rglob("*.seal.json"):
            seal.unlink()
    path = folder / FIRST
    content = damage(path.read_bytes())
    path.write_bytes(content)
    if not sealed and damage is DAMAGE["another number"]:
        return  # without a seal another number is a number
    with pytest.raises(
        DamagedSweep, match=r"1 files .* are damaged(?s:.*)low/seed-0000000\.csv: .*(?s:.*)arl experiment run"
    ):
        read_results(EXPERIMENT, folder)
    told: list[tuple[Path, str]] = []
    runner = Inline()
    run_sweep(EXPERIMENT, range(3), folder, runner, on_damaged=lambda *one: told.append(one))
    assert [path for path, _ in told] == [path]
    assert len(runner.calls) == 1
    now = every_file(folder)
    assert {name: now[name] for name in whole if sealed or not name.endswith("seal.json")} == {
        name: whole[name] for name in whole if sealed or not name.endswith("seal.json")
    }
    assert read_results(EXPERIMENT, folder).seeds == (0, 1, 2)


def trials_by_time(folder: Path, seal: bool) -> Played:
    """Write three trials that end with the episode that reaches an hour, as those of Keepaway do."""
    how = Played({"hours": 1.0}, quick=False)
    hours = ([0.4, 0.8, 1.1], [0.2, 0.4, 0.7, 0.99, 1.4], [0.3, 1.0])
    folder.mkdir()
    for seed, ends in enumerate(hours):
        path = folder / f"seed-{seed:07d}.csv"
        path.write_text("episode,hours\n" + "".join(f"{n},{end}\n" for n, end in enumerate(ends)))
        if seal:
            seal_path(path).write_text(seal_of(path, path.read_bytes(), how))
    return how


@pytest.mark.parametrize("seal", [True, False], ids=["sealed", "from before seals"])
def test_trials_that_last_some_hours_may_differ_in_episodes_and_one_that_is_cut_is_named(tmp_path, seal):
    folder = tmp_path / "sarsa"
    how = trials_by_time(folder, seal)
    paths = sorted(folder.glob("*.csv"))
    sound, damaged = read_trials(paths, how)
    assert (list(sound), damaged) == (paths, {})
    paths[0].write_bytes(cut_at_a_line(paths[0].read_bytes()))
    sound, damaged = read_trials(paths, how)
    assert (list(sound), list(damaged)) == (paths[1:], paths[:1])


def test_a_file_copied_from_another_trial_is_named(tmp_path):
    folder = played(tmp_path / "sweep")
    for name in ("seed-0000000.csv", "seed-0000000.seal.json"):
        shutil.copy(folder / "high" / name, folder / "low" / name)
    with pytest.raises(DamagedSweep, match=r"it is another trial's: high/seed-0000000\.csv"):
        read_results(EXPERIMENT, folder)


def test_what_cannot_be_read_is_named_and_a_folder_has_to_be_removed(tmp_path):
    folder = played(tmp_path / "sweep")
    (folder / FIRST).unlink()
    (folder / FIRST).mkdir()
    with pytest.raises(DamagedSweep, match=r"seed-0000000\.csv: it cannot be read: Is a directory"):
        read_results(EXPERIMENT, folder)
    with pytest.raises(SweepError, match=r"seed-0000000\.csv or its seal is a folder"):
        run_sweep(EXPERIMENT, range(3), folder, Inline())


def test_a_file_that_is_no_trials_is_named(tmp_path):
    folder = played(tmp_path / "sweep")
    shutil.copy(folder / FIRST, folder / "low" / "seed-0000000 (copy).csv")
    with pytest.raises(DamagedSweep, match=r"no trial's file is called so"):
        read_results(EXPERIMENT, folder)


def test_a_damaged_seal_is_named(tmp_path):
    folder = played(tmp_path / "sweep")
    seal_path(folder / FIRST).write_bytes(b"[" * 3000)
    with pytest.raises(DamagedSweep, match=r"its seal seed-0000000\.seal\.json is damaged"):
        read_results(EXPERIMENT, folder)


def test_a_report_of_other_settings_is_refused(tmp_path):
    folder = played(tmp_path / "sweep")
    low = msgspec.structs.replace(EXPERIMENT.condition("low").settings, mean=9.0)
    conditions = (
        dataclasses.replace(EXPERIMENT.condition("low"), settings=low),
        EXPERIMENT.condition("high"),
    )
    changed = dataclasses.replace(EXPERIMENT, conditions=conditions)
    with pytest.raises(SweepError, match="condition low was played with other settings"):
        read_results(changed, folder)
    # The record says the new settings, the files were played with the old ones.
    record = json.loads((folder / SWEEP_FILE).read_text())
    record["conditions"]["low"]["mean"] = 9.0
    (folder / SWEEP_FILE).write_text(json.dumps(record))
    with pytest.raises(DamagedSweep, match=r"low/seed-0000000\.csv: it was played with other settings"):
        read_results(changed, folder)


def test_a_report_of_another_experiment_or_an_unknown_condition_is_refused(tmp_path):
    folder = played(tmp_path / "sweep")
    record = json.loads((folder / SWEEP_FILE).read_text())
    (folder / SWEEP_FILE).write_text(json.dumps(record | {"experiment": "fig4"}))
    with pytest.raises(SweepError, match=r"holds results of fig4, not of tests\.studies\.tiny_experiment"):
        read_results(EXPERIMENT, folder)
    del record["conditions"]["low"]
    (folder / SWEEP_FILE).write_text(json.dumps(record))
    with pytest.raises(SweepError, match="does not say with what settings low was played"):
        read_results(EXPERIMENT, folder)


def test_damage_beside_is_not_passed_over(tmp_path):
    folder = played(tmp_path / EXPERIMENT.name)
    results = read_results(EXPERIMENT, folder)
    (folder / FIRST).write_bytes(b"")
    with pytest.raises(DamagedSweep):
        read_beside(results, EXPERIMENT.name, ())


def test_a_trial_that_was_half_written_is_played_again(tmp_path):
    """The seal is written first: a kill between the two leaves a seal without a file."""
    folder = played(tmp_path / "sweep")
    whole = every_file(folder)
    (folder / FIRST).unlink()
    run_sweep(EXPERIMENT, range(3), folder, Inline())
    assert every_file(folder) == whole


def test_rows_that_are_whole_are_read_without_a_seal(tmp_path):
    path = tmp_path / "seed-0000001.csv"
    path.write_text("episode,score\n0,1.5\n1,nan\n")
    rows = read_rows(path, Played({}, quick=False))
    assert list(rows) == ["episode", "score"]
    path.write_text("episode,episode\n0,1.5\n")
    with pytest.raises(DamagedTrial, match="names no columns"):
        read_rows(path, Played({}, quick=False))
