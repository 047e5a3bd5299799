"""Anonymised copies: nothing names a person, a day or a machine, and a replay is as exact as before."""

import hashlib
import hmac
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.events import EpisodeStarted, KeyPressed, PressRetracted
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.layouts import KeyReader
from core.recording.anonymise import OTHER_KEY, Anonymising, anonymised, removals
from core.recording.reader import Recording, read_recording
from core.recording.recorder import LineWriter
from core.session.inputs import check_inputs
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.recording.test_recording import HEADER, press

REFERENCE = Path(__file__).resolve().parents[3] / "recordings" / "reference"
KEY = bytes(range(32))


def copy_of(path: Path, how: Anonymising, into: Path) -> Recording:
    target = into / "copy.jsonl"
    target.write_bytes(anonymised(read_recording(path), how))
    return read_recording(target)


@pytest.mark.parametrize(
    "path", sorted(REFERENCE.rglob("*.jsonl")), ids=lambda path: f"{path.parent.name}-{path.stem}"
)
@pytest.mark.jit
def test_a_copy_of_either_version_replays_exactly(path: Path, tmp_path: Path) -> None:
    original, copy = read_recording(path), copy_of(path, Anonymising(KEY), tmp_path)
    assert (copy.header.version, copy.events) == (original.header.version, original.events)
    session = build_session(protocol_from(copy.header.protocol), copy.header.root_seed)
    result = replay_exactly(copy, session)
    assert result.difference is None
    assert result.outputs == len(original.outputs)


def written(path: Path) -> Path:
    header = msgspec.structs.replace(
        HEADER,
        participant="P01",
        created_utc="2026-11-24T10:00:00+00:00",
        terminal={
            "TERM": "xterm",
            "LANG": "de_DE",
            "stamps": "flush",
            "timing_utc": "2026-11-24T09:00:00+00:00",
        },
        source={
            "credit_files": "P01-feedback-lag-20261124T080000Z.jsonl",
            "continues": "/home/anna/P01.jsonl",
            "study.condition": "linear",
        },
    )
    writer = LineWriter(path, header)
    writer.write(press(0))
    writer.write(
        msgspec.structs.replace(press(1), key="ж", verdict="other", value=None, read_as=";", layout="russian")
    )
    writer.close()
    return path


def test_dates_terminal_facts_texts_typed_keys_and_the_code_are_gone(tmp_path: Path) -> None:
    path = written(tmp_path / "P01-20261124T100000Z.jsonl")
    copy = copy_of(path, Anonymising(KEY), tmp_path)
    content = copy.path.read_text(encoding="utf-8")
    for trace in ("2026", "1124", "P01", "anna", "xterm", "de_DE", "ж", "russian"):
        assert trace not in content
    assert copy.header.terminal == {"stamps": "flush", "timing_utc": "(date removed)"}
    assert copy.header.source["study.condition"] == "linear"
    first, second = (event for event in copy.events if isinstance(event, KeyPressed))
    assert (first, second.key, second.time_ns) == (press(0), OTHER_KEY, press(1).time_ns)


def test_the_header_says_what_was_done_and_names_the_old_file(tmp_path: Path) -> None:
    path = written(tmp_path / "P01.jsonl")
    source = copy_of(path, Anonymising(KEY), tmp_path).header.source
    assert source["anonymised_from_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert source["anonymised"] == (
        "removed: dates, terminal facts, free text, names of other keys; participant has a new code; times "
        "and all else "
        "as recorded; sealed anew"
    )
    keyed = copy_of(path, Anonymising(KEY, keyed_hash=True), tmp_path).header.source
    assert keyed["anonymised_from_hmac_sha256"] == hmac.digest(KEY, path.read_bytes(), "sha256").hex()
    assert "anonymised_from_sha256" not in keyed


def test_what_is_to_be_kept_is_kept(tmp_path: Path) -> None:
    path = written(tmp_path / "P01.jsonl")
    kept = ("dates", "terminal", "free-text", "other-keys", "codes")
    copy, original = copy_of(path, Anonymising(KEY, removals(kept)), tmp_path), read_recording(path)
    assert copy.events == original.events
    said = {name: text for name, text in copy.header.source.items() if not name.startswith("anonymised")}
    assert msgspec.structs.replace(copy.header, source=said) == original.header


def test_a_code_follows_from_the_key_and_says_nothing_without_it() -> None:
    code = Anonymising(KEY).code("P01")
    assert code == Anonymising(KEY).code("P01")
    assert len({code, Anonymising(KEY).code("P02"), Anonymising(bytes(32)).code("P01")}) == 3


def test_a_cut_recording_stays_one(tmp_path: Path) -> None:
    path = written(tmp_path / "P01.jsonl")
    path.write_bytes(path.read_bytes()[:-60])
    original, copy = read_recording(path), copy_of(path, Anonymising(KEY), tmp_path)
    assert not copy.complete
    assert len(copy.events) == len(original.events)


def test_a_press_that_was_taken_back_can_be_followed_in_the_copy(tmp_path: Path) -> None:
    gate = PressGate(KeyConfig())
    gate.reader = KeyReader("ru")
    gate.episode_started()
    start = EpisodeStarted(
        episode=0, time_ns=0, inputs=0, episode_seed=7, policy=0, form=0, w_r=1.0, trust=0.0, weight=0.25, handover=0.0  # noqa: E501
    )  # fmt: skip
    keys = ["j", "x", "u", "j", "\u0433"]
    presses = [event for n, key in enumerate(keys) for event in gate.judge(key, n * 10**9)]
    assert [event.press for event in presses if isinstance(event, PressRetracted)] == [0, 3]
    writer = LineWriter(tmp_path / "P01.jsonl", msgspec.structs.replace(HEADER, origin="live"))
    for event in (start, *presses):
        writer.write(event)
    writer.close()
    copy = copy_of(tmp_path / "P01.jsonl", Anonymising(KEY), tmp_path)
    kept = [event.key for event in copy.events if isinstance(event, KeyPressed)]
    assert kept == ["j", OTHER_KEY, "u", "j", "\u0433"]
    check_inputs(copy, KeyConfig())


MS = 1_000_000


def recorded_keys(path: Path, keys: list[tuple[str, int]]) -> list[KeyPressed | PressRetracted]:
    """Record presses of these keys at these times, ms; return them with what follows from them."""
    gate = PressGate(KeyConfig())
    gate.episode_started()
    start = EpisodeStarted(
        episode=0, time_ns=0, inputs=0, episode_seed=7, policy=0, form=0, w_r=1.0, trust=0.0, weight=0.25, handover=0.0  # noqa: E501
    )  # fmt: skip
    events = [event for key, time_ms in keys for event in gate.judge(key, time_ms * MS)]
    writer = LineWriter(path, msgspec.structs.replace(HEADER, origin="live"))
    for event in (start, *events):
        writer.write(event)
    writer.close()
    return events


def test_other_keys_typed_while_a_key_is_held_do_not_look_like_a_held_one(tmp_path: Path) -> None:
    held = [("j", 0), ("j", 500), ("a", 510), ("b", 520), ("c", 525), ("j", 530), ("j", 560)]
    events = recorded_keys(tmp_path / "P01.jsonl", held)
    assert [event.press for event in events if isinstance(event, PressRetracted)] == [1]
    copy = copy_of(tmp_path / "P01.jsonl", Anonymising(KEY), tmp_path)
    names = [event.key for event in copy.events if isinstance(event, KeyPressed)]
    assert names == ["j", "j", OTHER_KEY, "(other key 2)", "(other key 3)", "j", "j"]
    check_inputs(copy, KeyConfig())


def test_typed_text_cannot_be_read_from_the_names_of_keys(tmp_path: Path) -> None:
    text = "the thin man ate the heat"
    recorded_keys(tmp_path / "P01.jsonl", [(letter, 200 * n) for n, letter in enumerate(text)])
    copy = copy_of(tmp_path / "P01.jsonl", Anonymising(KEY), tmp_path)
    names = [event.key for event in copy.events if isinstance(event, KeyPressed)]
    seen: set[str] = set()
    for letter, name in zip(text, names, strict=True):
        # Of a letter that came before, nothing is said but that.
        assert (name == OTHER_KEY) == (letter in seen or not seen)
        seen.add(letter)


@given(
    st.lists(
        st.tuples(st.sampled_from("jjjfabcu"), st.sampled_from([5, 30, 79, 80, 81, 300, 500])), max_size=60
    )
)
def test_whatever_is_pressed_a_copy_follows_from_its_presses(pressed: list[tuple[str, int]]) -> None:
    now_ms, keys = 0, []
    for key, wait_ms in pressed:
        now_ms += wait_ms
        keys.append((key, now_ms))
    with TemporaryDirectory() as folder:
        events = recorded_keys(Path(folder) / "P01.jsonl", keys)
        copy = copy_of(Path(folder) / "P01.jsonl", Anonymising(KEY), Path(folder))
    assert len(copy.events) == len(events) + 1
    check_inputs(copy, KeyConfig())
