"""`arl import evaluations`, `arl presses`, and importers of other packages, as commands."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main

TABLE = "participant_id,time_s,value,delay_s\n" + "".join(
    f"E{i % 2},{i * 3}.5,{(-1) ** (i // 2)},{0.6 + 0.07 * (i % 9)}\n" for i in range(40)
)


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, list(map(str, arguments)))


@pytest.fixture
def recordings(tmp_path: Path) -> list[Path]:
    table = tmp_path / "lab.csv"
    table.write_text(TABLE)
    result = run("import", "evaluations", table, "--recordings", tmp_path / "r")
    assert result.exit_code == 0, result.output
    assert "40 evaluations of 2 participants in 2 recordings" in result.output
    return sorted((tmp_path / "r" / "imported" / "lab").glob("*.jsonl"))


def test_imported_presses_are_reported_fitted_and_listed_but_not_replayed(
    recordings: list[Path], tmp_path: Path
) -> None:
    report = run("presses", *recordings, "--each", "--csv", tmp_path / "p.csv")
    assert report.exit_code == 0, report.output
    assert "40 presses in 40 bursts" in report.output
    assert "delay since the event judged (s)" in report.output
    assert "\nE1\n" in report.output
    assert (tmp_path / "p.csv").read_text().count("\n") == 41
    fit = run("fit", *recordings, "--resamples", "0", "--goodness", "0", "--workers", "1")
    assert fit.exit_code == 0, fit.output
    assert "slower than 10 s something else" in fit.output  # limits of evaluations
    assert "E0: 20 responses" in fit.output
    for arguments in ((), ("--credit", "paper")):
        replay = run("replay", recordings[0], *arguments)
        assert replay.exit_code == 1
        assert "nothing can be replayed" in replay.output
    assert "imported" in run("recordings", "--recordings", tmp_path / "r").output


def test_a_table_that_does_not_fit_is_an_error_with_the_likely_column(tmp_path: Path) -> None:
    table = tmp_path / "lab.csv"
    table.write_text(TABLE.replace("participant_id", "subject"))
    result = run("import", "evaluations", table, "--recordings", tmp_path / "r")
    assert result.exit_code == 1
    assert "no column 'participant_id'" in result.output
    assert "--column participant=NAME" in result.output


def test_importers_of_other_packages_are_commands(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from importlib.metadata import EntryPoint

    from core.recording.importers import contract

    points = [EntryPoint("our-lab", "studies.evaluations.importer:IMPORTER", contract.GROUP)]
    monkeypatch.setattr(contract, "entry_points", lambda group: points)
    assert "our-lab" in run("import", "--help").output
    table = tmp_path / "lab.csv"
    table.write_text(TABLE.replace("delay_s", "lag_s"))
    result = run("import", "our-lab", table, "--set", "delay=lag_s", "--out", tmp_path / "o")
    assert result.exit_code == 0, result.output
    assert len(list((tmp_path / "o").iterdir())) == 2
    unknown = run("import", "our-lab", table, "--set", "colour=red", "--out", tmp_path / "p")
    assert unknown.exit_code == 1
    assert "has no setting 'colour'" in unknown.output


def test_what_tables_say_of_themselves_does_not_move_the_terminal(tmp_path: Path) -> None:
    canary = "\x1b]0;canary\x07\x9b2J\u202e"
    for text in (
        f"participant_id,note{canary},rt_s\n"
        + "".join(f"P{canary},{i % 2},0.{300 + 7 * i}\n" for i in range(40)),
        f"participant_id,rt_s\nP1,{canary}\n",
        f"participant_id{canary},x{canary}\nP1,1\n",
        f"participant_id,rt_s\nP1,0.4,{canary}\n",
    ):
        table = tmp_path / f"a{canary.replace('/', '')}.csv"
        table.write_text(text, encoding="utf-8")
        result = run(
            "fit", table, "--column", "rt=rt_s", "--resamples", "0", "--goodness", "0", "--workers", "1"
        )
        for sign in "\x1b\x07\x9b\u202e":
            assert sign not in result.output
        imported = run("import", "evaluations", table, "--out", tmp_path / "o")
        assert "\x1b" not in imported.output
