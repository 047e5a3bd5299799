"""What is said where neither the recording's disk nor the one for temporary files takes the rest."""

import tempfile
from pathlib import Path

import pytest

from arl_tui.app.close_recording import close_recorder
from core.recording.reader import read_recording
from core.recording.recorder import Recorder
from tests.core.recording.test_recording import HEADER, press
from tests.full_disk import files_end_at


def test_events_that_no_disk_takes_are_counted_and_no_half_file_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    recorder = Recorder(tmp_path / "r.jsonl", HEADER)
    length = (tmp_path / "r.jsonl").stat().st_size
    with files_end_at(length + 1000):
        for number in range(40):
            recorder.record(press(number))
        problem, path = close_recorder(recorder)
    held = len(read_recording(tmp_path / "r.jsonl").events)
    assert 0 < held < 40
    assert problem is not None
    assert "could not be saved elsewhere: [Errno 27] File too large" in problem
    assert f"({40 - held} KeyPressed)" in problem
    assert path == tmp_path / "r.jsonl"
    assert list(temporary.iterdir()) == []


def test_a_recording_without_a_header_is_not_left(tmp_path: Path) -> None:
    with files_end_at(100), pytest.raises(OSError, match="too large"):
        Recorder(tmp_path / "r.jsonl", HEADER)
    assert list(tmp_path.iterdir()) == []
