"""Files that were changed between the lab and the analyst: named, and read where the chain is whole."""

import bz2
import codecs
import gzip
import lzma
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from core.recording.reader import RecordingError, read_recording
from core.recording.recorder import Recorder
from core.recording.schema import VERSION
from tests.core.recording.test_recording import EVENTS, HEADER


@pytest.fixture
def content(tmp_path: Path) -> bytes:
    """Return a whole recording: a header, three events, an end line."""
    with Recorder(tmp_path / "original.jsonl", HEADER) as recorder:
        for event in EVENTS:
            recorder.record(event)
    return (tmp_path / "original.jsonl").read_bytes()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "copy.jsonl"


def powershell(content: bytes) -> bytes:
    """Return what `type a.jsonl > b.jsonl` makes of a file: UTF-16 with a mark, and its own line ends."""
    return codecs.BOM_UTF16_LE + content.decode().replace("\n", "\r\n").encode("utf-16-le")


READABLE: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "git's line ends": (lambda c: c.replace(b"\n", b"\r\n"), r"lines end as on Windows \(CR LF\)"),
    "some of git's line ends": (lambda c: c.replace(b"\n", b"\r\n", 2), r"2 of the lines end as on Windows"),
    "old line ends": (lambda c: c.replace(b"\n", b"\r"), r"old Macs"),
    "a byte-order mark": (lambda c: codecs.BOM_UTF8 + c, "byte-order mark"),
    "a mangled byte-order mark": (lambda c: "ï»¿".encode() + c, "byte-order mark"),
    "gzip": (gzip.compress, r"compressed \(gzip\)"),
    "bzip2": (bz2.compress, r"compressed \(bzip2\)"),
    "xz": (lzma.compress, r"compressed \(xz\)"),
    "UTF-16": (powershell, "UTF-16"),
    "UTF-16 without a mark": (lambda c: c.decode().encode("utf-16-be"), "UTF-16"),
    "gzip of git's line ends": (lambda c: gzip.compress(c.replace(b"\n", b"\r\n")), "CR LF"),
    "a blank line at the end": (lambda c: c + b"\n", "line 6 is empty"),
    "blank lines between": (lambda c: c.replace(b"\n", b"\n\n"), "5 lines, from line 2 on, are empty"),
    "no newline at the end": (lambda c: c[:-1], "line end behind the last line is missing"),
    "gzip in parts": (lambda c: gzip.compress(c[:500]) + gzip.compress(c[500:]), r"compressed \(gzip\)"),
    "doubled as gzip": (lambda c: gzip.compress(c) * 2, "holds the same recording twice"),
    "doubled": (lambda c: c + c, "holds the same recording twice"),
    "appended thrice": (lambda c: c * 3, r"3\.0 times"),
    "doubled and cut": (lambda c: c + b"".join(c.splitlines(keepends=True)[:2]), r"1\.4 times"),
}


@pytest.mark.parametrize("kind", READABLE)
def test_what_can_be_undone_is_read_and_said(kind: str, content: bytes, path: Path) -> None:
    change, said = READABLE[kind]
    path.write_bytes(change(content))
    recording = read_recording(path, allow_truncated=False)
    assert (recording.header, list(recording.events)) == (HEADER, EVENTS)
    assert recording.lost_tail == b""
    assert any(re.search(said, note) for note in recording.notes), recording.notes


def test_an_unchanged_file_needs_no_note(content: bytes, path: Path) -> None:
    path.write_bytes(content)
    assert read_recording(path).notes == ()


@pytest.mark.parametrize("kind", [kind for kind in READABLE if "blank" not in kind and "newline" not in kind])
def test_a_change_inside_is_found_whatever_else_was_done_to_the_file(
    kind: str, content: bytes, path: Path
) -> None:
    path.write_bytes(READABLE[kind][0](content.replace(b'"key":"j"', b'"key":"f"')))
    with pytest.raises(RecordingError, match=r"copy\.jsonl:3: .*this line was changed"):
        read_recording(path)


def edited(content: bytes, old: bytes, new: bytes) -> bytes:
    assert old in content
    return content.replace(old, new)


def later_version(content: bytes) -> bytes:
    return edited(content, f'"version":{VERSION}'.encode(), f'"version":{VERSION + 1}'.encode())


REFUSED: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "empty": (lambda c: b"", "the file is empty: 0 bytes"),
    "only blank lines": (lambda c: b"\n\n", "holds no whole line"),
    "cut in its header": (lambda c: c[:100], "cut off within the header, after 100 bytes"),
    "an edited date": (lambda c: edited(c, b"2026-11-22", b"2026-11-23"), "header was changed after it was"),
    "a removed date": (
        lambda c: edited(c, b'"created_utc":"2026-11-22T10:00:00+00:00",', b""),
        "created_utc was taken out",
    ),
    "a newer version": (later_version, f"version {VERSION + 1} of the format, newer than this program"),
    "two recordings": (
        lambda c: c + edited(c, b'"participant":"P01"', b'"participant":"P02"'),
        r"copy\.jsonl:6: a second header: two recordings were joined.*head -n 5",
    ),
    "something appended": (lambda c: c + b'{"note":"mine"}\n', "line behind the end line.*first 5 lines"),
    "something appended without a newline": (lambda c: c + b"mine", "behind the end line stands b'mine'"),
    "a cut gzip of nothing": (lambda c: gzip.compress(c)[:12], r"compressed \(gzip\) and holds nothing"),
    "a damaged gzip": (lambda c: gzip.compress(c)[:-8] + bytes(8), r"compressed \(gzip\) and damaged"),
    "something behind a gzip": (lambda c: gzip.compress(c) + b"mine", "4 more bytes; was something appended"),
    "zip": (lambda c: b"PK\x03\x04rest", "a zip archive: unpack it"),
    "zstd": (lambda c: b"\x28\xb5\x2f\xfdrest", "compressed with zstd: unpack it"),
    "damaged UTF-16": (lambda c: powershell(c)[:-1], "UTF-16 text and is damaged"),
    "trials": (lambda c: b'{"type":"header","format":"arl-reaction-times"}\n', "`arl fit` reads it"),
    "JSON of others": (lambda c: b'{"a":1}\n', "JSON of another program"),
    "binary data": (lambda c: b"\x7fELF\x00\x01\n\x00", "holds binary data"),
    "a table": (lambda c: b"rt,participant\n0.3,P01\n", r"begins b'rt,participant'"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_what_cannot_be_believed_is_refused_by_its_name(kind: str, content: bytes, path: Path) -> None:
    change, said = REFUSED[kind]
    path.write_bytes(change(content))
    with pytest.raises(RecordingError, match=said) as caught:
        read_recording(path)
    assert str(path) in str(caught.value)


def test_a_folder_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"a folder, not a recording"):
        read_recording(tmp_path)


def test_a_cut_gzip_is_read_up_to_its_last_whole_line(content: bytes, path: Path) -> None:
    path.write_bytes(gzip.compress(content)[:-12])
    recording = read_recording(path)
    assert not recording.complete
    assert list(recording.events) == EVENTS[: len(recording.events)]
    assert any("gzip file is cut off" in note for note in recording.notes)


def test_every_cut_is_read_or_refused_and_never_taken_for_whole(content: bytes, path: Path) -> None:
    header_ends = content.index(b"\n") + 1
    for length in range(header_ends, len(content) - 1):
        path.write_bytes(content[:length])
        recording = read_recording(path)
        assert not recording.complete
        assert list(recording.events) == EVENTS[: len(recording.events)]
        assert bool(recording.notes) == (content[length - 1] != ord("\n"))
        assert recording.notes or not recording.lost_tail


def test_a_header_alone_is_read_and_holds_nothing(content: bytes, path: Path) -> None:
    path.write_bytes(content.splitlines(keepends=True)[0])
    recording = read_recording(path)
    assert (recording.events, recording.complete) == ((), False)
