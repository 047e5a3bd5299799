"""The package as strangers get it: built, installed into an empty environment, and run without the
repository."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.documented import DOCS, REPOSITORY, blocks_of, extras_installed

README, LOCK = REPOSITORY / "README.md", REPOSITORY / "requirements.lock"
CLONED = ("pyproject.toml", "requirements.lock", "README.md", "LICENSE", "arl_tui", "core", "studies")
"""What of the repository an installation reads."""


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
    # Of a copy: each process of the tests builds, and a build writes beside what it reads.
    copy_repository(folder / "clone")
    run(sys.executable, "-m", "build", "--outdir", folder, folder / "clone", folder=folder)
    return folder


def copy_repository(folder: Path) -> None:
    """Copy what an installation reads."""
    folder.mkdir()
    for name in CLONED:
        source = REPOSITORY / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, folder / name)


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
def test_the_wheel_holds_what_is_read_at_run_time_and_nothing_else_the_sdist_the_licence(built: Path):
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
    (sdist,) = built.glob("*.tar.gz")
    with tarfile.open(sdist) as packed:
        names = {name.split("/", 1)[-1] for name in packed.getnames()}
    assert {"LICENSE", "README.md", "pyproject.toml"} <= names


@pytest.mark.thorough
def test_the_wheel_runs_in_an_empty_environment_and_where_pipx_or_uv_installs_it(
    built: Path, tmp_path: Path
) -> None:
    (wheel,) = built.glob("*.whl")
    run(sys.executable, "-m", "venv", tmp_path / "venv", folder=tmp_path)
    python = tmp_path / "venv" / "bin" / "python"
    skip_without_index(python)
    run(python, "-m", "pip", "install", "-q", "-c", LOCK, wheel, folder=tmp_path)
    arl = python.with_name("arl")
    runs(arl, tmp_path)
    run(arl, "doctor", "--quick", folder=tmp_path)
    run(arl, "study", "new", "my-study", folder=tmp_path)
    (example,) = (block.text for block in blocks_of(README) if block.language == "python")
    run(python, "-c", example, folder=tmp_path)
    # The extras of the documentation are those of the installed program, wherever that came from.
    run(python, "-m", "pip", "install", "-q", "--dry-run", *extras_installed(), folder=tmp_path)
    # Nothing else is asked of this environment, so both installers may come into it.
    run(python, "-m", "pip", "install", "-q", "pipx", "uv", folder=tmp_path)
    chosen = ("--python", sys.executable)
    run(
        *(python.with_name("pipx"), "install", *chosen, f"--pip-args=--constraint={LOCK}", wheel),
        folder=tmp_path,
        **{name: str(tmp_path / name) for name in ("PIPX_HOME", "PIPX_BIN_DIR", "PIPX_MAN_DIR")},
    )
    run(
        *(python.with_name("uv"), "tool", "install", *chosen, "--constraints", LOCK, wheel),
        folder=tmp_path,
        **{name: str(tmp_path / name) for name in ("UV_TOOL_DIR", "UV_TOOL_BIN_DIR")},
    )
    for name in ("PIPX_BIN_DIR", "UV_TOOL_BIN_DIR"):
        assert [path.name for path in (tmp_path / name).iterdir()] == ["arl"]
        runs(tmp_path / name / "arl", tmp_path)


def runs(arl: Path, folder: Path) -> None:
    """See that an installed command plays a session and replays it."""
    assert "0.2.0" in run(arl, "--version", folder=folder)
    assert "Replay: exact" in run(arl, "demo", "--seed", "1", folder=folder)


def skip_without_index(python: Path) -> None:
    """Skip, saying why, where pip reaches no package index."""
    command = [str(python), "-m", "pip", "download", "-q", "--no-deps", "--retries", "1", "click"]
    with TemporaryDirectory() as folder:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"pip reaches no package index: {done.stderr.strip().splitlines()[-1]}")


@pytest.mark.thorough
def test_the_first_commands_of_the_readme_work_in_a_copy_of_the_repository(tmp_path: Path) -> None:
    clone = tmp_path / "clone"
    copy_repository(clone)
    run(sys.executable, "-m", "venv", clone / ".venv", folder=clone)  # whose pip is asked
    skip_without_index(clone / ".venv" / "bin" / "python")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    first, tests = (block.text for block in blocks_of(README) if block.language == "sh")
    assert "Replay: exact" in run("bash", "-euc", first, folder=clone, PATH=path)
    # The second command installs what the tests need: whether there is such a set of versions is asked here.
    install, then = tests.strip().rsplit(" && ", 1)
    assert then == ".venv/bin/pytest"
    run("bash", "-euc", f"{install} --dry-run", folder=clone, PATH=path)


def test_the_tutorial_installs_as_the_readme_does() -> None:
    first, *_ = (block.text for block in blocks_of(README) if block.language == "sh")
    tutorial, *_ = (block.text for block in blocks_of(DOCS / "tutorials" / "first-session.md"))
    make, install, use = tutorial.splitlines()
    assert [make, install, ".venv/bin/arl demo"] == first.strip().replace(" -q", "").split(" && ")
    assert use == "source .venv/bin/activate"
