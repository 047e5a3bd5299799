"""The index against a plain reading of the same file, and when it is made again."""

import gzip
import math
import os
import shutil
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.events import (
    CreditGiven,
    EpisodeStarted,
    Event,
    FrameShown,
    KeyPressed,
    Resumed,
    ScreenCleared,
    StepTaken,
    UnseenPlayed,
)
from core.recording.reader import RecordingError, read_recording
from studies.session_view import index as indexing
from studies.session_view.building import VERDICTS
from studies.session_view.index import SUFFIX, open_index
from studies.session_view.session import SessionView, open_session
from tests.studies.session_view.made import (
    MS,
    RECORDINGS,
    TETRIS,
    ended,
    live_events,
    pressed,
    started,
    taken,
    write,
)


def same(session: SessionView, path: Path) -> None:
    """Check an index against the events as `read_recording` gives them."""
    recording = read_recording(path)
    of = {
        kind: [event for event in recording.events if isinstance(event, kind)]
        for kind in (FrameShown, StepTaken, KeyPressed, EpisodeStarted, CreditGiven, UnseenPlayed)
    }
    assert session.index.events == len(recording.events)
    assert session.index.header == recording.header
    assert session.frames["number"].tolist() == [event.frame for event in of[FrameShown]]
    assert session.frames["step"].tolist() == [event.step for event in of[FrameShown]]
    assert session.steps["number"].tolist() == [event.step for event in of[StepTaken]]
    assert [session.step_taken(row) for row in range(len(session.steps))] == of[StepTaken]
    assert [session.game_started(row) for row in range(len(session.games))] == of[EpisodeStarted]
    for row, event in enumerate(of[KeyPressed]):
        press = session.press_at(row)
        assert (press.number, press.time_ns, press.key, press.step) == (
            event.press,
            event.time_ns,
            event.key,
            event.step,
        )
        assert press.verdict == VERDICTS[VERDICTS.index(event.verdict)]
        assert press.value == event.value or (event.value is None and math.isnan(press.value))
    for credited in of[CreditGiven]:
        assert session.credit_of(credited.press) == credited
    shown: dict[int, int] = {}
    for frame in of[FrameShown]:
        shown.setdefault(frame.step, frame.flushed_ns)
    expected = [shown.get(event.step, -1) for event in of[StepTaken]]
    assert session.steps["shown"].tolist() == expected


@pytest.mark.parametrize("path", RECORDINGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_the_index_says_what_a_plain_reading_says(path: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copy(path, tmp_path))
    same(open_session(copy), copy)
    assert (tmp_path / (copy.name + SUFFIX)).exists()
    same(open_session(copy), copy)  # from the file


def test_an_index_is_used_again_and_made_anew_when_the_file_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "a.jsonl", live_events())
    first = open_index(path)
    monkeypatch.setattr(indexing, "_build", lambda *_: pytest.fail("it was built again"))
    assert open_index(path).events == first.events
    monkeypatch.undo()
    path.unlink()
    write(path, [*live_events()[:-1], taken(20_000 * MS, 2, 6)])
    os.utime(path, ns=(time.time_ns(), time.time_ns() + 1))
    assert open_index(path).events == first.events
    assert len(open_index(path).tables["steps"]) == len(first.tables["steps"]) + 1


@pytest.mark.parametrize("content", [b"", b"not an index\n", b'{"index":1,"of":"","facts":{},"tables":{}}\n'])
def test_an_index_that_is_no_index_is_made_again(content: bytes, tmp_path: Path) -> None:
    path = write(tmp_path / "a.jsonl", live_events())
    (tmp_path / f"a.jsonl{SUFFIX}").write_bytes(content)
    same(open_session(path), path)


def test_an_index_that_was_cut_off_is_made_again(tmp_path: Path) -> None:
    path = write(tmp_path / "a.jsonl", live_events())
    open_session(path)
    place = tmp_path / f"a.jsonl{SUFFIX}"
    place.write_bytes(place.read_bytes()[:-40])
    same(open_session(path), path)


def test_a_recording_without_its_end_is_taken_for_what_it_holds(tmp_path: Path) -> None:
    path = write(tmp_path / "a.jsonl", live_events(), complete=False)
    with path.open("ab") as file:
        file.write(b'{"type":"frame-sh')
    session = open_session(path)
    assert not session.index.complete
    assert "ends within a line" in session.index.notes[0]
    assert session.index.events == len(live_events())


def test_a_file_that_an_editor_or_packer_has_changed_is_put_right(tmp_path: Path) -> None:
    packed = tmp_path / "a.jsonl.gz"
    packed.write_bytes(gzip.compress(TETRIS.read_bytes()))
    session = open_session(packed)
    assert "unpacked" in session.index.notes[0]
    same(session, packed)
    windows = tmp_path / "b.jsonl"
    windows.write_bytes(TETRIS.read_bytes().replace(b"\n", b"\r\n"))
    assert "Windows" in open_session(windows).index.notes[0]


def test_damage_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_bytes(TETRIS.read_bytes().replace(b'"value":-1.0', b'"value":1.0', 1))
    with pytest.raises(RecordingError, match=r"a\.jsonl:\d+: "):
        open_index(path)
    assert not (tmp_path / f"a.jsonl{SUFFIX}").exists()


def test_in_a_folder_that_cannot_be_written_the_index_is_kept_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write(tmp_path / "a.jsonl", live_events())
    refused = tmp_path / f"a.jsonl{SUFFIX}"

    def write_tables(place: Path, *rest: object) -> None:
        if place == refused:
            raise PermissionError
        original(place, *rest)

    original = indexing.write_tables
    monkeypatch.setattr(indexing, "write_tables", write_tables)
    same(open_session(path), path)
    assert not refused.exists()


Times = st.lists(st.integers(1, 400), min_size=1, max_size=60)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(waits=Times, data=st.data())
def test_any_order_of_frames_pauses_and_presses_is_found_again(
    waits: list[int], data: st.DataObject, tmp_path: Path
) -> None:
    """Against a slow twin: who walks through all events knows what is on screen at every moment."""
    events: list = [live_events()[0]]
    now, step, frame, press, covered = 1000 * MS, -1, 0, 0, False
    for wait in waits:
        now += wait * MS
        match data.draw(st.sampled_from(["frame", "step", "press", "cover"])):
            case "step":
                step += 1
                events += [taken(now, step, step % 9), FrameShown(frame=frame, step=step, flushed_ns=now + 1)]
                frame, covered = frame + 1, False
            case "frame" if step >= 0:
                events.append(FrameShown(frame=frame, step=step, flushed_ns=now))
                frame, covered = frame + 1, False
            case "press":
                events.append(pressed(now, press, step, 1.0 if wait % 2 else -1.0))
                press += 1
            case "cover" if not covered:
                events.append(ScreenCleared(time_ns=now, reason="pause"))
                covered = True
            case "cover":
                events.append(Resumed(time_ns=now))
                covered = False
    path = tmp_path / "any.jsonl"
    path.unlink(missing_ok=True)
    session = open_session(write(path, events))
    same(session, path)
    for at in range(900 * MS, now + 500 * MS, max(1, (now - 900 * MS) // 40)):
        assert seen(session, at) == plainly_seen(events, at)
    assert np.all(np.diff(session.times("press")) >= 0)


def seen(session: SessionView, at: int) -> tuple[int, bool]:
    moment = session.at(at)
    number = int(session.steps["number"][moment.step]) if moment.step >= 0 else -1
    return number, bool(moment.covered)


def plainly_seen(events: list, at: int) -> tuple[int, bool]:
    step, covered = -1, False
    for event in events:
        match event:
            case FrameShown(step=number, flushed_ns=time_ns) if time_ns <= at:
                step, covered = number, False
            case ScreenCleared(time_ns=time_ns) if time_ns <= at:
                covered = True
            case Resumed(time_ns=time_ns) if time_ns <= at:
                covered = False
    return step, covered


@pytest.mark.parametrize(
    ("events", "told"),
    [
        ([msgspec.structs.replace(started(0), episode_seed=10**300)], "no session records what stands at"),
        ([msgspec.structs.replace(taken(0, 0, 0), step=2**40)], "no session records what stands at"),
        ([ended(5)], "a table of 0 episodes has no row -1"),
    ],
    ids=["seed", "step", "end"],
)
def test_what_no_table_can_hold_is_refused(tmp_path: Path, events: list[Event], told: str) -> None:
    with pytest.raises(RecordingError, match=told):
        open_index(write(tmp_path / "impossible.jsonl", events))
