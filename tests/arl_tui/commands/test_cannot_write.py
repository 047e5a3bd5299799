"""Where a command cannot write, it says so in a sentence, before any work."""

import errno
import stat
import subprocess
import sys
import tempfile
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from arl_tui.command_line import ToWrite, why_not_writable
from tests.arl_tui.command_tree import members
from tests.data_folder import REPOSITORY

GOLDEN = REPOSITORY / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"
RULE = ("--credit", "previous", "--scheme", "human-only", "--games", "1", "--workers", "1")


def arl(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


# Every option of every command that names something to write, with what the command needs besides.
WRITING: dict[str, tuple[str | Path, ...]] = {
    "play --recordings": ("play",),
    "demo --recordings": ("demo",),
    "calibrate --recordings": ("calibrate", "--participant", "P01"),
    "timing --recordings": ("timing",),
    "timing --json": ("timing",),
    "import tamer-log --recordings": ("import", "tamer-log", GOLDEN),
    "import tamer-log --out": ("import", "tamer-log", GOLDEN),
    "import evaluations --recordings": ("import", "evaluations", GOLDEN),
    "import evaluations --out": ("import", "evaluations", GOLDEN),
    "replay --csv": ("replay", GOLDEN, *RULE),
    "replay --plot": ("replay", GOLDEN, *RULE),
    "recordings --csv": ("recordings", "--recordings", GOLDEN.parent),
    "recordings --publish": ("recordings", "--recordings", GOLDEN.parent),
    "recordings upgrade into": ("recordings", "upgrade", GOLDEN),
    "anonymise into": ("anonymise", GOLDEN, "--key", "no-key"),
    "archive --out": ("archive", GOLDEN.parent, "--key", "no-key"),
    "export tidy --out": ("export", "tidy", GOLDEN),
    "export bids --out": ("export", "bids", GOLDEN),
    "export minari --out": ("export", "minari", GOLDEN),
    "study run --recordings": ("study", "run", GOLDEN),
    "study simulate --recordings": ("study", "simulate", GOLDEN),
    "study withdraw --recordings": ("study", "withdraw", GOLDEN, "P01"),
    "study drop --recordings": ("study", "drop", GOLDEN, "P01"),
    "train --save": ("train", "keepaway"),
    "fit --figure": ("fit", GOLDEN),
    "fit --json": ("fit", GOLDEN),
    "fit --html": ("fit", GOLDEN),
    "fit --out": ("fit", GOLDEN),
    "recordings --make-key": ("recordings", "--recordings", GOLDEN.parent),
    "compare --csv": ("compare", GOLDEN, GOLDEN),
    "compare --plot": ("compare", GOLDEN, GOLDEN),
    "compare --html": ("compare", GOLDEN, GOLDEN),
    "watch --export": ("watch", GOLDEN),
    "experiment run --out": ("experiment", "run", "fig5", "--quick", "--trials", "1"),
    "experiment report --into": ("experiment", "report", "fig5"),
    "experiment report --out": ("experiment", "report", "fig5"),
}


@pytest.mark.parametrize("case", WRITING)
def test_a_place_that_cannot_be_written_is_refused_in_a_sentence(case: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    option = [case.split()[-1]] if "--" in case else []  # else it is an argument
    result = arl(*WRITING[case], *option, tmp_path / "file" / "below.csv")
    assert result.exit_code != 0
    assert isinstance(result.exception, SystemExit), result.exception
    said = " ".join(result.output.split())
    assert str(tmp_path / "file") in said
    assert (tmp_path / "file").read_text() == "in the way"


@pytest.mark.parametrize("case", ["replay --plot", "compare --plot", "fit --figure"])
@pytest.mark.parametrize("name", ["figure.exe", "figure"])
def test_a_figure_that_cannot_be_drawn_is_refused_before_any_work(
    case: str, name: str, tmp_path: Path
) -> None:
    result = arl(*WRITING[case], case.split()[-1], tmp_path / name)
    assert result.exit_code == 2
    assert f"{name} does not end in .png, .svg or .pdf" in " ".join(result.output.split())
    assert list(tmp_path.iterdir()) == []


def options_that_write(command: click.Command, name: str = "") -> set[str]:
    """Return every option whose type says that it writes, as "command --option"."""
    found = {f"{name} {option.opts[0]}" for option in command.params if isinstance(option.type, ToWrite)}
    for below, inner in members(command) if isinstance(command, click.Group) else ():
        found |= options_that_write(inner, f"{name} {below}".strip())
    return found


def test_no_option_that_writes_is_forgotten_here() -> None:
    assert options_that_write(main) <= set(WRITING)
    assert len(options_that_write(main)) >= 15


@pytest.mark.parametrize(
    ("path", "folder", "why"),
    [
        ("file/x", True, "is a file, not a folder"),
        ("file/x.csv", False, "is a file, not a folder"),
        ("missing/x.csv", False, "there is no folder"),
        ("missing/deep", True, None),
        ("x.csv", False, None),
        ("file", False, None),
    ],
)
def test_why_a_place_cannot_be_written(tmp_path: Path, path: str, folder: bool, why: str | None) -> None:
    (tmp_path / "file").touch()
    found = why_not_writable(tmp_path / path, folder=folder)
    assert (found is None) if why is None else (why in str(found))


def test_a_read_only_folder_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import os

    locked = tmp_path / "locked"
    locked.mkdir()
    locked.chmod(stat.S_IRUSR | stat.S_IXUSR)
    # The administrator may write everywhere: ask what anybody else would be told.
    monkeypatch.setattr(os, "access", lambda path, mode: not (Path(path) == locked and mode & os.W_OK))
    assert f"the folder {locked} is read-only" in str(why_not_writable(locked / "x", folder=True))


def test_a_write_that_fails_later_is_told_in_a_sentence_too(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(tmp_path / "a.jsonl"))

    monkeypatch.setattr("studies.demo.simulate_session", full)
    result = arl("demo", "--recordings", tmp_path)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit)
    said = " ".join(result.output.split())
    assert "a.jsonl could not be written: No space left on device. Make room, or name another place" in said


def test_without_a_folder_for_temporary_files_it_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", None)
    monkeypatch.setattr(tempfile, "_candidate_tempdir_list", lambda: [str(tmp_path / "missing")])
    monkeypatch.setattr("studies.demo.simulate_session", lambda *_, **__: tempfile.mkdtemp())
    result = arl("demo", "--recordings", tmp_path)
    assert result.exit_code == 1
    said = " ".join(result.output.split())
    assert "Error: No usable temporary directory found in" in said
    assert "missing']: make room in one of these folders, or let TMPDIR name another" in said


def test_too_little_memory_is_told_in_a_sentence(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def too_much(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr("studies.demo.simulate_session", too_much)
    result = arl("demo", "--recordings", tmp_path)
    assert result.exit_code == 1
    assert "Error: there is not enough memory for this" in result.output


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--help",), "what is printed"),
        (("protocol", "tetris"), "what is printed"),
        (("recordings", "--recordings", GOLDEN.parent), "what is printed"),
    ],
    ids=["help", "protocol", "recordings"],
)
def test_an_output_whose_disk_is_full_is_told_in_a_sentence(arguments: tuple[str, ...], said: str) -> None:
    with open("/dev/full", "wb") as full:
        ended = subprocess.run(
            [sys.executable, "-m", "arl_tui.cli", *map(str, arguments)],
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
            timeout=60,
        )
    assert ended.returncode == 1
    (line,) = ended.stderr.decode().splitlines()
    assert line.startswith(f"Error: {said} could not be written: No space left on device. ")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.parametrize("case", ["recordings --csv", "export bids --out", "replay --plot"])
def test_a_file_whose_disk_is_full_is_named(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / ("out.png" if case.endswith("plot") else "out")
    if case.startswith("recordings"):
        target.symlink_to("/dev/full")
    else:
        # What the system says while bytes go to an open file: it names none.
        def full(*_: object, **__: object) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr("matplotlib.figure.Figure.savefig", full)
        monkeypatch.setattr("json.dumps", full)
        target.mkdir() if case.startswith("export") else target.touch()
    result = arl(*WRITING[case], case.split()[-1], target)
    assert result.exit_code == 1
    assert isinstance(result.exception, SystemExit), result.exception
    said = " ".join(result.output.split())
    assert f"Error: {target} could not be written: No space left on device. " in said
