"""Files are written whole, or what was there before stays."""

import errno
import os
import stat
from pathlib import Path

import pytest

from core.system.whole_file import whole_file, write_whole


def test_a_file_is_there_when_all_has_been_written(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    with whole_file(path) as file:
        file.write("a\r\n")
        file.flush()
        assert not path.exists()
    assert path.read_bytes() == b"a\r\n"
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~(os.umask(0o022) or os.umask(0o022))
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("number", [None, errno.ENOSPC])
def test_what_was_there_stays_where_writing_fails(tmp_path: Path, number: int | None) -> None:
    path = tmp_path / "table.csv"
    write_whole(path, "old")
    path.chmod(0o640)
    error = ValueError("no") if number is None else OSError(number, os.strerror(number))

    def write_and_fail() -> None:
        with whole_file(path) as file:
            file.write("new")
            raise error

    with pytest.raises(type(error)) as caught:
        write_and_fail()
    assert getattr(caught.value, "filename", str(path)) == str(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    write_whole(path, "new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o640


def test_a_link_stays_a_link_and_a_device_is_written_to(tmp_path: Path) -> None:
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to("real")
    write_whole(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_text() == "new"
    write_whole(Path(os.devnull), "gone")
    assert not Path(os.devnull).is_file()


def test_a_failure_names_the_file_that_was_asked_for(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="missing") as caught:
        write_whole(tmp_path / "missing" / "a.html", "")
    assert caught.value.filename == str(tmp_path / "missing" / "a.html")


def test_another_files_error_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, whole_file(tmp_path / "a.csv"):
        (tmp_path / "source").read_bytes()
    assert caught.value.filename == str(tmp_path / "source")
