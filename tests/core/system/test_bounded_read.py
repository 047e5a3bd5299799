"""A device without an end is refused, and a pipe is read."""

import os
import sys
from pathlib import Path

import pytest

from core.recording.reader import read_recording
from core.system import bounded_read
from core.system.bounded_read import EndlessFileError, read_bounded
from studies.exports.sources import find_sources

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such pipes and devices")


@pytest.fixture(autouse=True)
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounded_read, "MOST_OF_A_DEVICE", 1 << 21)


@pytest.mark.parametrize("read", [read_bounded, read_recording])
def test_a_device_without_an_end_is_refused(read) -> None:
    with pytest.raises(EndlessFileError) as caught:
        read(Path("/dev/zero"))
    assert str(caught.value) == (
        "/dev/zero: a pipe or a device that gives more than 2,097,152 bytes: "
        "copy what you mean to a file, and name that"
    )


def test_a_pipe_is_read_to_its_end() -> None:
    ends = os.pipe()
    os.write(ends[1], b"abc")
    os.close(ends[1])
    assert read_bounded(Path(f"/dev/fd/{ends[0]}")) == b"abc"
    os.close(ends[0])


def test_a_file_is_read_whole_however_long(tmp_path: Path) -> None:
    (tmp_path / "long").write_bytes(b"a" * (1 << 22))
    assert len(read_bounded(tmp_path / "long")) == 1 << 22


def test_a_pipe_in_a_folder_of_data_is_named_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.jsonl")
    with pytest.raises(EndlessFileError, match=r"pipe\.jsonl: a pipe or a device, not a file"):
        list(find_sources(tmp_path))
