"""An experiment in a file of one's own: the documentation's template runs, from any folder."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from studies.experiments.sweep import load_experiment

ROOT = Path(__file__).resolve().parents[3]
PAGE = ROOT / "docs" / "own-experiment.md"


def template() -> str:
    (text,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    return str(text)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "my.py").write_text(template(), encoding="utf-8")
    return tmp_path


def arl(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["experiment", *map(str, arguments)])


def test_the_template_runs_in_processes_of_its_own_and_is_reported(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = folder / "else where"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    done = arl("run", "../my.py", "--trials", 3, "--workers", 2)
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in Path("results/my").iterdir()) == ["five", "none", "sweep.json"]
    assert "Next: arl experiment report ../my.py --out results" in done.output
    reported = arl("report", "../my.py")
    assert reported.exit_code == 0, reported.output
    page = Path("results/my/report/results/my.md").read_text()
    assert "arl experiment run my.py && arl experiment report my.py" in page
    assert Path("results/my/report/figures/my.png").read_bytes().startswith(b"\x89PNG")


def test_the_command_finds_a_file_from_any_folder(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    command = [sys.executable, "-m", "arl_tui", "experiment", "run", str(folder / "my.py")]
    options = ["--quick", "--trials", "1", "--workers", "1", "--only", "five"]
    done = subprocess.run(
        [*command, *options], cwd=tmp_path / "x", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert f"Next: arl experiment report {folder / 'my.py'} --out results --quick --only five" in done.stdout


def test_the_name_is_the_file_s_and_a_path_with_spaces_is_quoted(tmp_path: Path) -> None:
    path = tmp_path / "my own.py"
    path.write_text(template(), encoding="utf-8")
    experiment = load_experiment(str(path))
    assert (experiment.name, experiment.source) == ("my own", str(path))
    assert experiment.typed == "'my own.py'"
    done = arl("run", path, "--quick", "--trials", 1, "--workers", 1, "--out", tmp_path / "o o")
    assert f"arl experiment report '{path}' --out '{tmp_path / 'o o'}' --quick" in done.output


def test_a_file_may_import_what_lies_beside_it(folder: Path) -> None:
    (folder / "beside_it.py").write_text("TITLE = 'Imported'\n")
    text = template().replace('title="Few presses and many"', "title=TITLE")
    (folder / "your.py").write_text(
        text.replace("import msgspec", "import msgspec\nfrom beside_it import TITLE", 1)
    )
    assert load_experiment(str(folder / "your.py")).title == "Imported"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("EXPERIMENT = 3\n", "its EXPERIMENT is a int, not an Experiment"),
        ("x = 1\n", "docs/own-experiment.md has one to start from"),
        ("import nothing_of_this_name\n", "nothing_of_this_name"),
        ("def (\n", "invalid syntax"),
        ("x = 1\nnonsense\n", "broken.py:2: NameError: name 'nonsense' is not defined"),
        ("import sys\nsys.exit(0)\n", "broken.py:2: SystemExit: 0"),
    ],
)
def test_a_file_that_is_no_experiment_is_refused_in_a_sentence(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "broken.py").write_text(text)
    done = arl("run", tmp_path / "broken.py")
    assert done.exit_code == 2
    assert said in " ".join(done.output.split())


def test_results_that_a_report_cannot_be_made_of_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "nan.py").write_text(template().replace("np.floor(lines)", "np.nan * lines"))
    monkeypatch.chdir(tmp_path)
    assert arl("run", "nan.py", "--trials", 2, "--workers", 1).exit_code == 0
    done = arl("report", "nan.py")
    assert done.exit_code == 1
    assert "nan.py: its report cannot be made of results/nan: results must be finite" in done.output


def test_a_name_that_is_neither_file_nor_module_is_refused() -> None:
    assert "no experiment './'" in arl("run", "./").output


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    done = arl("run", tmp_path / "none.py")
    assert done.exit_code == 2
    assert "there is no such file" in " ".join(done.output.split())
