"""`arl compare`, and `arl replay` with several files."""

import csv
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from tests.studies.session_view.made import KEEPAWAY, TETRIS

pytestmark = pytest.mark.jit


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


@pytest.fixture
def files(tmp_path: Path) -> list[str]:
    found = sorted(TETRIS.parent.glob("tetris-*.jsonl"))
    return [shutil.copy(path, tmp_path) for path in found]


def test_tables_figures_and_page(files: list[str], tmp_path: Path) -> None:
    outputs = {name: tmp_path / f"out.{name}" for name in ("csv", "png", "html")}
    done = run(
        "compare", *files, "--by", "protocol",
        "--csv", str(outputs["csv"]), "--plot", str(outputs["png"]), "--html", str(outputs["html"]),
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    for words in (
        "Sessions",
        "Groups by protocol",
        "agreement",
        "consistency",
        "trust after the game, by game",
    ):
        assert words in done.output
    rows = list(csv.DictReader(outputs["csv"].read_text().splitlines()))
    assert len(rows) == 9
    assert sum(int(row["good"]) + int(row["bad"]) for row in rows) == 23 + 14 + 24
    assert outputs["png"].read_bytes().startswith(b"\x89PNG")
    assert outputs["html"].read_text().startswith("<!DOCTYPE html>")


def test_games_cannot_be_mixed_nor_files_named_twice(files: list[str], tmp_path: Path) -> None:
    done = run("compare", files[0], shutil.copy(KEEPAWAY, tmp_path))
    assert done.exit_code == 1
    assert "recordings of keepaway and tetris" in done.output
    done = run("compare", files[0], files[0])
    assert done.exit_code == 2
    assert "is named twice" in done.output


def test_a_damaged_recording_is_named(files: list[str]) -> None:
    Path(files[1]).write_bytes(Path(files[1]).read_bytes().replace(b'"step":3', b'"step":4', 1))
    done = run("compare", *files)
    assert done.exit_code == 1
    assert Path(files[1]).name in done.output


def test_a_figure_of_an_unknown_kind_is_refused(files: list[str], tmp_path: Path) -> None:
    done = run("compare", files[0], "--plot", str(tmp_path / "a.docx"))
    assert done.exit_code == 2
    assert "docx" in done.output


def test_several_recordings_are_replayed_and_none_hides_another(files: list[str]) -> None:
    done = run("replay", *files)
    assert done.exit_code == 0
    assert done.output.count("Replay: exact") == 3
    Path(files[0]).write_text("nothing")
    done = run("replay", *files)
    assert done.exit_code == 1
    assert done.output.count("Replay: exact") == 2
    assert "1 of 3 recordings failed" in done.output
    done = run("replay", *files[1:], "--credit", "paper", "--csv", "a.csv")
    assert done.exit_code == 2
    assert "arl compare" in done.output
