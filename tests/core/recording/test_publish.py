"""Copies for publication: no date is left, the chain is whole, and a replay is as exact as the original's."""

import re
from pathlib import Path

import msgspec
import pytest

from core.recording.publish import publish_copy, publish_folder
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.recording.test_recording import HEADER, press
from tests.full_disk import files_end_at

GOLDEN = Path(__file__).resolve().parents[3] / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"


def test_a_copy_replays_exactly_and_holds_the_same_events(tmp_path: Path) -> None:
    original = read_recording(GOLDEN)
    publish_copy(original, tmp_path / "copy.jsonl")
    copy = read_recording(tmp_path / "copy.jsonl", allow_truncated=False)
    assert copy.events == original.events
    assert copy.header.source["published"] == "dates removed, chained anew"
    session = build_session(protocol_from(copy.header.protocol), copy.header.root_seed)
    assert replay_exactly(copy, session).difference is None


def written(path: Path, *, day: int, code: str = "P01", whole: bool = True) -> Path:
    header = msgspec.structs.replace(
        HEADER,
        created_utc=f"2026-11-{day}T10:00:00+00:00",
        participant=code,
        terminal={"TERM": "xterm", "timing_created_utc": f"2026-11-{day}T09:00:00+00:00"},
        source={"credit_files": f"P01-feedback-lag-202611{day}T080000Z.jsonl"},
    )
    writer = LineWriter(path, header)
    writer.write(press(0))
    writer.close() if whole else writer.abandon()
    return path


def test_no_date_is_left_in_headers_and_names(tmp_path: Path) -> None:
    paths = [
        written(tmp_path / "P01-20261124T100000Z.jsonl", day=24),
        written(tmp_path / "P01-20261122T100000Z.jsonl", day=22),
        written(tmp_path / "P02-20261123T100000Z.jsonl", day=23, code="P02", whole=False),
    ]
    copies = publish_folder(paths, tmp_path / "out")
    names = {original.name: copy.name for original, copy in copies}
    assert names == {
        "P01-20261122T100000Z.jsonl": "P01-1.jsonl",
        "P01-20261124T100000Z.jsonl": "P01-2.jsonl",
        "P02-20261123T100000Z.jsonl": "P02-1.jsonl",
    }
    for _, copy in copies:
        assert not re.search(r"2026-?11", copy.read_text())
        assert len(read_recording(copy).events) == 1
    assert not read_recording(tmp_path / "out" / "P02-1.jsonl").complete


def test_a_copy_never_overwrites(tmp_path: Path) -> None:
    path = written(tmp_path / "a.jsonl", day=22)
    publish_folder([path], tmp_path / "out")
    with pytest.raises(FileExistsError):
        publish_folder([path], tmp_path / "out")


def test_no_half_copy_is_left_on_a_full_disk(tmp_path: Path) -> None:
    recording = read_recording(GOLDEN)
    with files_end_at(5000), pytest.raises(OSError, match="too large") as caught:
        publish_copy(recording, tmp_path / "copy.jsonl")
    assert caught.value.filename == str(tmp_path / "copy.jsonl")
    assert list(tmp_path.iterdir()) == []
