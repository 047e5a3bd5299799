"""Files that only their owner can read; writes that the system takes in parts."""

import os
from pathlib import Path

import pytest

from core.system.private_files import create_private, make_private_folder, write_all, write_private
from tests.full_disk import files_end_at


@pytest.fixture(autouse=True)
def open_umask():
    before = os.umask(0)
    yield
    os.umask(before)


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_new_folders_are_private_and_existing_ones_keep_their_mode(tmp_path):
    (tmp_path / "a").mkdir(mode=0o755)
    make_private_folder(tmp_path / "a" / "b" / "c")
    assert [mode(tmp_path / part) for part in ("a", "a/b", "a/b/c")] == [0o755, 0o700, 0o700]


def test_a_new_file_is_private_and_an_existing_one_is_not_touched(tmp_path):
    with create_private(tmp_path / "f") as file:
        file.write(b"first")
    assert mode(tmp_path / "f") == 0o600
    with pytest.raises(FileExistsError):
        create_private(tmp_path / "f")
    assert (tmp_path / "f").read_bytes() == b"first"


def test_a_replaced_file_is_private_and_whole(tmp_path):
    path = tmp_path / "f"
    path.write_bytes(b"old")
    path.chmod(0o644)
    write_private(path, b"new")
    assert path.read_bytes() == b"new"
    assert mode(path) == 0o600
    assert list(tmp_path.iterdir()) == [path]


class Disk:
    """Takes so many bytes at a time."""

    def __init__(self, *takes: int) -> None:
        self.takes = list(takes)
        self.content = b""

    def write(self, part: memoryview) -> int:
        taken = self.takes.pop(0)
        self.content += bytes(part[:taken])
        return taken


def test_what_the_system_takes_in_parts_is_written_whole():
    disk = Disk(2, 1, 10)
    write_all(disk, b"abcdef")
    assert disk.content == b"abcdef"


def test_a_system_that_takes_nothing_is_an_error():
    with pytest.raises(OSError, match="2 of 6 bytes"):
        write_all(Disk(2, 0), b"abcdef")


def test_a_failure_names_the_file_that_was_asked_for(tmp_path: Path) -> None:
    write_private(tmp_path / "a", b"old")
    with files_end_at(10), pytest.raises(OSError, match="too large") as caught:
        write_private(tmp_path / "a", b"new" * 10)
    assert caught.value.filename == str(tmp_path / "a")
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [b"old"]
