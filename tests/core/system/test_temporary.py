"""What killed programs leave behind is removed, and nothing else."""

import gzip
import multiprocessing
import os
import tempfile
from pathlib import Path

import pytest

from arl_tui.recordings import rescue_whole
from core.system.temporary import prefix_of, remove_left_behind
from tests.core.recording.test_long_recordings import ORIGINAL


@pytest.fixture
def temporary(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    folder = tmp_path / "t"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    monkeypatch.setenv("TMPDIR", str(folder))
    return folder


def test_what_programs_that_are_gone_have_left_is_removed_and_everything_else_stays(temporary: Path) -> None:
    left = ("arl-worker-999999999-a.log", "arl-copy-999999999-b.jsonl", f"arl-{'0' * 24}.jsonl")
    for name in (
        *left,
        f"{prefix_of('worker')}a.log",
        f"{prefix_of('copy')}b.jsonl",
        "arl-worker-x.log",
        "other",
    ):
        (temporary / name).touch()
    for name in ("arl-watch-999999999-c", "arl-watch-x"):
        (temporary / name).mkdir()
        (temporary / name / "file").touch()
    participants = [rescue_whole(b"{}", "arl"), rescue_whole(b"{}", f"arl-{'0' * 24}")]
    (temporary / "arl-timing-999999999-link").symlink_to(temporary / "arl-watch-x")
    assert remove_left_behind() == len(left) + 2
    stay = {*participants, temporary / "other", temporary / "arl-worker-x.log", temporary / "arl-watch-x"}
    stay |= {temporary / f"{prefix_of('worker')}a.log", temporary / f"{prefix_of('copy')}b.jsonl"}
    assert set(temporary.iterdir()) == stay
    assert (temporary / "arl-watch-x" / "file").exists()


def _view(packed: Path, seen: "multiprocessing.Queue[int]") -> None:
    from studies.session_view.session import open_session

    session = open_session(packed)
    (copy,) = Path(tempfile.gettempdir()).glob("arl-copy-*.jsonl")
    seen.put(copy.stat().st_mode & 0o777)
    session.at(session.end_ns)


def test_the_copy_of_a_packed_recording_is_private_and_goes_when_its_program_ends(
    temporary: Path, tmp_path: Path
) -> None:
    packed = tmp_path / "a.jsonl.gz"
    packed.write_bytes(gzip.compress(ORIGINAL.read_bytes()))
    context = multiprocessing.get_context("spawn")
    seen = context.Queue()
    for _ in range(2):  # the second program finds an index that points into a copy that is gone
        process = context.Process(target=_view, args=(packed, seen))
        process.start()
        process.join()
        assert process.exitcode == 0
        assert seen.get() == 0o600
        assert list(temporary.glob("arl-*")) == []
    assert os.path.exists(f"{packed}.index")
