"""Tidy tables: they say what the recordings say, every column is in the codebook, and examples run."""

import csv
import json
import shutil
import subprocess
import sys
import tracemalloc
from typing import get_args, get_type_hints

import pytest

from core.events import KeyPressed, PressRetracted
from core.recording.reader import read_recording
from studies.exports.event_tables import PRESSES
from studies.exports.tables import TABLES
from studies.exports.tidy import ExportError, export_tidy
from studies.exports.words import action_of
from tests.studies.exports.conftest import REFERENCE, REPOSITORY, run

pandas = pytest.importorskip("pandas", reason="pandas is not installed: pip install 'arl-tui[dev]'")


@pytest.fixture(scope="module")
def tables(lab, tmp_path_factory):
    into = tmp_path_factory.mktemp("out") / "tables"
    run("export", "tidy", lab, "--out", into)
    return into


def table(tables, name):
    return pandas.read_csv(tables / f"{name}.csv")


def test_every_table_is_there_with_its_columns(tables):
    for each in TABLES:
        with (tables / f"{each.name}.csv").open(newline="") as file:
            rows = list(csv.reader(file))
        assert tuple(rows[0]) == each.names
        assert len(rows) > 1 or each.name in ("interruptions", "questions"), f"{each.name} is empty"


def test_levels_are_those_of_the_events():
    levels = {column.name: set(column.levels) for column in PRESSES.columns}
    assert levels["verdict"] == set(get_args(get_type_hints(KeyPressed)["verdict"]))
    assert levels["retracted"] == set(get_args(get_type_hints(PressRetracted)["reason"]))
    assert levels["pressed_by"] == set(get_args(get_type_hints(KeyPressed)["source"]))


def test_cells_hold_only_the_levels_of_the_codebook(tables):
    described = json.loads((tables / "codebook.json").read_text())
    for resource in described["resources"]:
        found = pandas.read_csv(tables / resource["path"], dtype=str)
        for field in resource["schema"]["fields"]:
            allowed = field.get("constraints", {}).get("enum")
            if allowed:
                assert set(found[field["name"]].dropna()) <= set(allowed), (resource["name"], field["name"])


def test_presses_by_participant_condition_and_game_are_one_line(tables):
    presses = table(tables, "presses")
    by = ["participant", "condition", "game"]
    counts = presses[presses.counted].groupby(by, dropna=False).value.agg(["size", "mean"])
    assert counts["size"].sum() == presses.counted.sum()
    sessions = table(tables, "sessions")
    in_study = sessions[sessions.study == "small"]
    assert set(in_study.condition) == {"linear", "annealed"}
    assert set(counts.index.get_level_values("game")) == {1, 2, 3, 4}
    assert set(in_study.place) == {1, 2}
    assert set(in_study.sitting) == {1}


@pytest.mark.parametrize("name", ["tetris-linear-equation-4", "keepaway-exponential-equation-4-old"])
def test_a_session_is_the_same_in_tables_and_recording(lab, tables, name):
    recording = read_recording(lab / f"{name}.jsonl")
    presses, credit = table(tables, "presses"), table(tables, "credit")
    mine, its = presses[presses.session == name], credit[credit.session == name]
    recorded = [event for event in recording.events if isinstance(event, KeyPressed)]
    assert list(mine.press_index) == [event.press for event in recorded]
    assert list(mine.time_s * 1e9) == pytest.approx([event.time_ns for event in recorded], abs=1)
    # What was given to steps and what was lost adds up to 1 for each press.
    given = its.groupby("press_index").share.sum()
    lost = (
        mine[mine.verdict == "accepted"]
        .set_index("press_index")[["before_first", "in_gaps", "too_late"]]
        .sum(axis=1)
    )
    assert list(given.reindex(lost.index).fillna(0.0) + lost) == pytest.approx([1.0] * len(lost))


def test_feedback_of_a_step_is_the_sum_of_its_credit(tables):
    steps, credit = table(tables, "steps"), table(tables, "credit")
    sums = credit[credit.counted].groupby(["session", "step_index"]).feedback.sum()
    found = steps.set_index(["session", "step_index"]).feedback
    assert found[sums.index].to_list() == pytest.approx(sums.to_list())
    assert (found.drop(sums.index) == 0.0).all()


def test_games_and_steps_are_counted_from_one(tables):
    steps, games = table(tables, "steps"), table(tables, "games")
    for _, session in steps.groupby("session"):
        assert sorted(session.game.unique()) == list(range(1, session.game.nunique() + 1))
        for _, game in session.groupby("game"):
            assert list(game.step) == list(range(1, len(game) + 1))
    assert games[games.watched].game.notna().all()
    assert games[~games.watched].game.isna().all()


def test_actions_are_in_words():
    assert (
        action_of("tetris", {"piece": 2, "orientation": 1, "column": 4}) == "T, orientation 2 of 4, column 5"
    )
    assert action_of("keepaway", {"keeper": 0, "cycle": 5, "target": -1}) == "hold"
    assert action_of("keepaway", {"keeper": 0, "cycle": 5, "target": 2}) == "pass to keeper 3"
    assert action_of("tetris", {"piece": 2}) is None


def test_defaults_of_the_protocol_are_written_out(tables):
    settings = table(tables, "settings")
    old = settings[settings.session == "tetris-linear-equation-4-old"].set_index("setting").value
    # The file of version 1 names neither; both have their defaults.
    assert (old["domain.type"], old["screen.speed"]) == ('"tetris"', "1.0")


def test_answers_stand_with_condition_place_and_sitting(tables):
    answers = table(tables, "answers")
    assert set(answers.questionnaire) == {"consent", "own", "taught"}
    assert set(answers[answers.questionnaire == "own"].condition) <= {"linear", "annealed"}
    assert answers[answers.questionnaire == "consent"].condition.isna().all()
    assert set(answers[answers.question == "remark"].answer) == {"simulated"}
    assert (answers.duration_s.dropna() >= 0).all()


def test_trials_hold_reaction_times(tables):
    trials = table(tables, "trials")
    assert (len(trials), set(trials.participant), set(trials.task)) == (14, {"P01"}, {"simple"})
    assert trials.practice.sum() == 2
    assert trials.rt_s.between(0.2, 0.5).all()


def test_parquet_holds_the_same(lab, tables, tmp_path):
    pytest.importorskip("pyarrow", reason="pyarrow is not installed: pip install 'arl-tui[parquet]'")
    export_tidy(lab, tmp_path / "parquet", file_format="parquet")
    for each in TABLES:
        in_csv, found = (
            table(tables, each.name),
            pandas.read_parquet(tmp_path / "parquet" / f"{each.name}.parquet"),
        )
        assert len(found) == len(in_csv)
        for column in each.columns:
            if column.kind == "number" and in_csv[column.name].notna().any():
                same = found[column.name].astype(float).equals(in_csv[column.name].astype(float))
                assert same, (each.name, column.name)


def test_a_damaged_file_is_named_and_hides_no_other(lab, tmp_path):
    from click.testing import CliRunner

    from arl_tui.cli import main

    folder = tmp_path / "data"
    folder.mkdir()
    content = (lab / "tetris-linear-equation-4.jsonl").read_bytes()
    (folder / "good.jsonl").write_bytes(content)
    (folder / "bad\x1b[2J.jsonl").write_bytes(content.replace(b'"key":"f"', b'"key":"j"', 1))
    result = CliRunner().invoke(main, ["export", "tidy", str(folder), "--out", str(tmp_path / "out")])
    assert result.exit_code == 1
    assert "Not exported" in result.output
    assert "this line was changed" in result.output
    assert "\x1b" not in result.output
    assert set(table(tmp_path / "out", "sessions").session) == {"good"}


def test_a_folder_with_something_in_it_is_refused(lab, tmp_path):
    (tmp_path / "kept.txt").write_text("mine")
    with pytest.raises(ExportError, match="not empty"):
        export_tidy(lab, tmp_path)


def test_memory_does_not_grow_with_the_number_of_files(tmp_path):
    content = (REFERENCE / "version-2" / "tetris-linear-equation-4.jsonl").read_bytes()

    def peak(n_files):
        folder = tmp_path / str(n_files)
        folder.mkdir()
        for number in range(n_files):
            (folder / f"{number}.jsonl").write_bytes(content)
        tracemalloc.start()
        export_tidy(folder, tmp_path / f"out-{n_files}")
        _, most = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        return most

    peak(1)  # whatever is imported or cached once
    assert peak(30) < 1.3 * peak(3)


def test_the_codebook_in_the_docs_is_the_present_one():
    page = (REPOSITORY / "docs" / "codebook.md").read_text(encoding="utf-8")
    assert page == run("export", "codebook"), "arl export codebook > docs/codebook.md"


def test_the_pandas_example_runs(tables):
    example = REPOSITORY / "docs" / "examples" / "presses_in_pandas.py"
    done = subprocess.run([sys.executable, example, tables], capture_output=True, text=True, check=True)
    assert "annealed" in done.stdout


def test_the_r_example_runs(tables):
    if shutil.which("Rscript") is None:
        pytest.skip("Rscript is not on this machine")
    example = REPOSITORY / "docs" / "examples" / "presses_in_lme4.R"
    done = subprocess.run(["Rscript", example, tables], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "participant" in done.stdout


def test_examples_in_the_docs_are_the_files_that_run():
    page = (REPOSITORY / "docs" / "how-to" / "publish-data.md").read_text(encoding="utf-8")
    for name in ("presses_in_pandas.py", "presses_in_lme4.R", "train_from_presses.py"):
        text = (REPOSITORY / "docs" / "examples" / name).read_text(encoding="utf-8")
        code = text.split('"""\n', 1)[1] if name.endswith(".py") else text
        assert code.strip() in page, name


@pytest.fixture
def imported(tmp_path):
    """Evaluations from a table: presses with delays, no game."""
    (tmp_path / "table.csv").write_text(
        "participant_id,time_s,value,delay_s,task\nP1,1.0,1,0.5,a\nP1,2.0,-1,0.25,a\nP2,1.0,1,0.5,b\n"
    )
    run("import", "evaluations", tmp_path / "table.csv", "--by", "task", "--out", tmp_path / "data")
    return tmp_path / "data"


def test_imported_evaluations_have_delays_and_conditions_and_claim_no_game(imported, tmp_path):
    run("export", "tidy", imported, "--out", tmp_path / "out")
    presses = table(tmp_path / "out", "presses")
    assert sorted(presses.condition) == ["task=a", "task=a", "task=b"]
    assert presses.domain.isna().all()
    assert sorted(presses.since_frame_s) == pytest.approx([0.25, 0.5, 0.5])
    assert len(table(tmp_path / "out", "settings")) == 0


def test_a_packed_copy_beside_its_original_is_another_session(lab, tmp_path):
    import gzip

    folder = tmp_path / "data"
    folder.mkdir()
    content = (lab / "tetris-linear-equation-4.jsonl").read_bytes()
    (folder / "a.jsonl").write_bytes(content)
    (folder / "a.jsonl.gz").write_bytes(gzip.compress(content))
    output = run("export", "tidy", folder, "--out", tmp_path / "out")
    assert list(table(tmp_path / "out", "sessions").session) == ["a", "a.jsonl.gz"]
    assert "Beware: a and a.jsonl.gz seem to be one session" in output


def test_sessions_of_one_participant_are_not_taken_for_one(lab, tmp_path):
    output = run("export", "tidy", lab / "studies", "--out", tmp_path / "out")
    assert "seem to be one session" not in output
