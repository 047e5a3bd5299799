"""The package as strangers get it: built, installed into an empty environment, and run without the
repository."""

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]


def run(*command: str | Path, folder: Path, **changes: str) -> str:
    environment = {
        name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")
    }
    done = subprocess.run(
        [str(word) for word in command],
        cwd=folder,
        env=environment | {"ARL_HOME": str(folder)} | changes,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the sdist, and the wheel that was built from the sdist."""
    folder = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--outdir", folder, REPOSITORY, folder=folder)
    return folder


def test_the_versions_of_python_are_the_same_everywhere():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    oldest, beyond = re.fullmatch(r">=3\.(\d+),<3\.(\d+)", project["requires-python"]).groups()
    name = "Programming Language :: Python :: 3."
    listed = [each.removeprefix(name) for each in project["classifiers"] if each.startswith(name)]
    assert listed == [str(minor) for minor in range(int(oldest), int(beyond))]
    for page in ("README.md", "docs/tutorials/first-session.md"):
        text = (REPOSITORY / page).read_text(encoding="utf-8")
        assert f"You need Python 3.{oldest} to 3.{int(beyond) - 1}, pip" in text, page


@pytest.mark.thorough
def test_the_wheel_holds_everything_that_is_read_at_run_time_and_nothing_else(built: Path):
    (wheel,) = built.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info" not in name} == {
        "arl_tui",
        "core",
        "studies",
    }
    packages = [path for name in ("arl_tui", "core", "studies") for path in (REPOSITORY / name).rglob("*")]
    data = {
        path.relative_to(REPOSITORY).as_posix()
        for path in packages
        if path.is_file()
        # Of a catalogue of words the compiled form is read.
        and path.suffix not in (".pyc", ".py", ".po")
        and "__pycache__" not in path.parts
    }
    assert data - set(names) == set()


@pytest.mark.thorough
def test_the_sdist_holds_the_licence_and_the_readme(built: Path):
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as packed:
        names = {name.split("/", 1)[-1] for name in packed.getnames()}
    assert {"LICENSE", "README.md", "pyproject.toml"} <= names


@pytest.mark.thorough
def test_the_wheel_runs_in_an_empty_environment(built: Path, tmp_path: Path):
    (wheel,) = built.glob("*.whl")
    run(sys.executable, "-m", "venv", tmp_path / "venv", folder=tmp_path)
    python = tmp_path / "venv" / "bin" / "python"
    run(python, "-m", "pip", "install", "-q", "-c", REPOSITORY / "requirements.lock", wheel, folder=tmp_path)
    arl = python.with_name("arl")
    assert "0.2.0" in run(arl, "--version", folder=tmp_path)
    assert "Replay: exact" in run(arl, "demo", "--seed", "1", folder=tmp_path)
    run(arl, "doctor", "--quick", folder=tmp_path)
    run(arl, "study", "new", "my-study", folder=tmp_path)
    readme = (REPOSITORY / "README.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    run(python, "-c", example, folder=tmp_path)
