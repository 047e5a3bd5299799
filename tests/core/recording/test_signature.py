"""Signatures: what the hash cannot tell, a forgery that was sealed anew."""

import json

import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from arl_tui.signing import NoKey, signer_in_use
from core.events import KeyPressed
from core.recording.publish import publish_copy
from core.recording.reader import read_recording
from core.recording.recorder import Recorder
from core.recording.signature import SigningError, make_key, public_key, signer, verify
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.core.recording.test_long_recordings import ORIGINAL
from tests.core.recording.test_recording import HEADER
from tests.full_disk import files_end_at
from tests.fuzz.mutate import resealed


@pytest.fixture
def signed(tmp_path):
    """A signed recording and the public key."""
    public = make_key(tmp_path / "key")
    events = read_recording(ORIGINAL).events
    with Recorder(tmp_path / "r" / "signed.jsonl", HEADER, sign=signer(tmp_path / "key")) as recorder:
        for event in events:
            recorder.record(event)
    return tmp_path / "r" / "signed.jsonl", public


def test_a_signed_recording_is_verified_and_nothing_else(signed, tmp_path):
    path, public = signed
    recording = read_recording(path)
    assert verify(recording, public_key(public)) == "signed"
    assert verify(recording, public_key(make_key(tmp_path / "other"))) == "another key, or changed"
    assert verify(read_recording(ORIGINAL), public_key(public)) == "not signed"


def test_a_forgery_that_was_sealed_anew_is_not_verified(signed):
    path, public = signed
    content = path.read_bytes()
    lines = content.splitlines(keepends=True)
    key = public_key(public)
    for forged in (
        content.replace(b'"participant":"P01"', b'"participant":"P02"', 1),
        content.replace(b'"value":1.0', b'"value":-1.0', 1),
        b"".join(lines[:-1]),
    ):
        assert forged != content
        path.write_bytes(resealed(forged))
        assert verify(read_recording(path), key) in ("another key, or changed", "no end line")
    end = json.loads(lines[-1])
    fewer = (
        b"".join([*lines[:5], *lines[6:-1]])
        + json.dumps(
            {"type": "end", "events": end["events"] - 1, "signature": end["signature"], "chain": ""},
            separators=(",", ":"),
        ).encode()
    )
    path.write_bytes(resealed(fewer))
    assert verify(read_recording(path), key) == "another key, or changed"
    path.write_bytes(resealed(content.replace(end["signature"].encode(), b"no hex")))
    assert verify(read_recording(path), key) == "another key, or changed"


def test_a_press_moved_within_its_frame_is_told_by_the_signature_alone(tmp_path):
    """Nothing in a file hangs on its time where credit goes by the step (`SECURITY.md`)."""
    original = read_recording(ORIGINAL)
    public = make_key(tmp_path / "key")
    path = tmp_path / "r" / "signed.jsonl"
    with Recorder(path, original.header, sign=signer(tmp_path / "key")) as recorder:
        for event in original.events:
            recorder.record(event)
    lines = path.read_bytes().splitlines(keepends=True)
    press = next(
        event for event in original.events if isinstance(event, KeyPressed) and event.verdict == "accepted"
    )
    at = original.events.index(press) + 1
    moved = lines[at].replace(b'"time_ns":%d' % press.time_ns, b'"time_ns":%d' % (press.time_ns + 20_000_000))
    assert moved != lines[at]
    path.write_bytes(resealed(b"".join([*lines[:at], moved, *lines[at + 1 :]])))
    forged = read_recording(path)
    session = build_session(protocol_from(forged.header.protocol), forged.header.root_seed)
    assert replay_exactly(forged, session).difference is None
    told = CliRunner().invoke(main, ["recordings", "--recordings", str(path.parent), "--verify", str(public)])
    assert (told.exit_code, told.output.splitlines()[0]) == (1, "signed.jsonl  another key, or changed")


def test_a_published_copy_is_not_signed(signed, tmp_path):
    path, public = signed
    publish_copy(read_recording(path), tmp_path / "copy.jsonl")
    copy = read_recording(tmp_path / "copy.jsonl", allow_truncated=False)
    assert verify(copy, public_key(public)) == "not signed"


def test_keys_are_private_and_never_overwritten(tmp_path):
    public = make_key(tmp_path / "key")
    assert (tmp_path / "key").stat().st_mode & 0o077 == 0
    before = (tmp_path / "key").read_bytes()
    with pytest.raises(FileExistsError):
        make_key(tmp_path / "key")
    assert (tmp_path / "key").read_bytes() == before
    with pytest.raises(SigningError, match="not a private key"):
        signer(public)
    with pytest.raises(SigningError, match=r"ends in \.pub"):
        public_key(tmp_path / "key")


def test_the_environment_names_the_key(tmp_path, monkeypatch):
    monkeypatch.delenv("ARL_SIGNING_KEY", raising=False)
    assert signer_in_use() is None
    monkeypatch.setenv("ARL_SIGNING_KEY", str(tmp_path / "key"))
    with pytest.raises(NoKey, match="the key cannot be used"):
        signer_in_use()
    make_key(tmp_path / "key")
    assert signer_in_use() is not None


def test_the_command_makes_keys_and_verifies_a_folder(signed, tmp_path):
    path, public = signed

    def run(*arguments):
        return CliRunner().invoke(main, ["recordings", *map(str, arguments)])

    result = run("--recordings", path.parent, "--verify", public)
    assert (result.exit_code, result.output.splitlines()[0]) == (0, "signed.jsonl  signed")
    (path.parent / "other.jsonl").write_bytes(ORIGINAL.read_bytes())
    (path.parent / "torn.jsonl").write_bytes(ORIGINAL.read_bytes()[:-400].replace(b"0", b"1"))
    result = run("--recordings", path.parent, "--verify", public)
    assert result.exit_code == 1
    assert "other.jsonl  not signed" in result.output
    assert "torn.jsonl  damaged: " in result.output
    assert "1 of 3 recordings were signed" in result.output
    result = run("--make-key", tmp_path / "mine")
    assert result.exit_code == 0
    assert "export ARL_SIGNING_KEY=" in result.output
    assert run("--make-key", tmp_path / "mine").exit_code == 1


def test_half_a_key_is_not_left_on_a_full_disk(tmp_path):
    with files_end_at(100), pytest.raises(OSError, match="too large"):
        make_key(tmp_path / "key")
    assert list(tmp_path.iterdir()) == []
    assert make_key(tmp_path / "key").exists()
