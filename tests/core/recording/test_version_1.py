"""Recordings of version 1: what today's program makes of them."""

import hashlib
import json

import msgspec
import pytest

from core.combination.config import Annealed, ControlSharing, Linear
from core.events import EpisodeEnded, EpisodeStarted, SessionEnded, UnseenPlayed
from core.recording.reader import RecordingError, read_recording
from core.recording.recorder import LineWriter
from core.recording.version_1 import as_far_as_recorded, with_schedules
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from tests.data_folder import REPOSITORY

GOLDEN = REPOSITORY / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"
ANNEALED = REPOSITORY / "recordings" / "reference" / "tetris-annealed-per-episode.jsonl"


def written(path):
    """Return the lines of a file as they stand there."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def sealed(path, lines):
    """Write JSON objects with the chain that belongs to them."""
    running = hashlib.sha256()
    with path.open("wb") as file:
        for line in lines:
            payload = msgspec.json.encode({name: value for name, value in line.items() if name != "chain"})
            running.update(payload)
            chain = running.hexdigest()[:16].encode()
            file.write(payload[:-1] + b',"chain":"' + chain + b'"}\n')
    return path


def test_the_two_meanings_of_w_h_get_their_names():
    lines, recording = written(GOLDEN), read_recording(GOLDEN)
    for tag, kind, name in (
        ("episode-started", EpisodeStarted, "weight"),
        ("episode-ended", EpisodeEnded, "trust"),
        ("unseen-played", UnseenPlayed, "trust"),
    ):
        before = [line["w_h"] for line in lines if line["type"] == tag]
        assert before == [getattr(event, name) for event in recording.events if isinstance(event, kind)]
        assert before


def test_what_version_1_did_not_hold_is_not_made_up():
    outputs = read_recording(GOLDEN).outputs
    assert all(output.trust is None for output in outputs if isinstance(output, EpisodeStarted))
    assert all(output.weights is None for output in outputs if isinstance(output, UnseenPlayed))


def test_the_last_word_calls_trust_by_its_name():
    (last,) = [output for output in read_recording(GOLDEN).outputs if isinstance(output, SessionEnded)]
    assert "w_h" not in last.weights
    assert last.weights["trust"] == written(GOLDEN)[-2]["weights"]["w_h"]


def test_a_weight_that_fell_fell_with_every_episode():
    said = written(ANNEALED)[0]["protocol"]["agent"]["scheme"]
    assert "per" not in said
    protocol = protocol_from(read_recording(ANNEALED).header.protocol)
    assert protocol.agent.scheme == Annealed(per="episode")
    assert Annealed() != Annealed(per="episode")


def test_settings_that_say_it_are_left_alone():
    assert with_schedules({"type": "linear"}) == {"type": "linear"}
    said = {"agent": {"scheme": {"type": "annealed", "per": "watched-game"}}, "others": [1, "x", None]}
    assert with_schedules(said) == said
    inside = {"play": [{"scheme": {"type": "control-sharing", "decay": 0.5}}]}
    assert with_schedules(inside)["play"][0]["scheme"]["per"] == "episode"


def test_every_scheme_whose_weight_falls_is_meant():
    for kind in (Annealed, ControlSharing, Linear):
        plain = msgspec.to_builtins(kind())
        plain.pop("per", None)
        expected = "episode" if kind is not Linear else None
        assert with_schedules(plain).get("per") == expected


def test_a_session_of_version_1_that_is_written_again_still_replays(tmp_path):
    recording = read_recording(ANNEALED)
    writer = LineWriter(tmp_path / "again.jsonl", recording.header)
    for event in recording.events:
        writer.write(event)
    writer.close()
    again = read_recording(tmp_path / "again.jsonl")
    assert (recording.header.version, again.header.version) == (1, 2)
    assert again.events == recording.events
    session = build_session(protocol_from(again.header.protocol), again.header.root_seed)
    assert replay_exactly(again, session).difference is None


def test_a_changed_weight_of_version_1_is_found(tmp_path):
    lines = written(ANNEALED)
    place = max(number for number, line in enumerate(lines) if line["type"] == "episode-started")
    lines[place]["w_h"] += 0.001
    recording = read_recording(sealed(tmp_path / "changed.jsonl", lines))
    result = replay_exactly(
        recording, build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    )
    assert result.difference is not None
    assert result.difference.field == "weight"


def test_what_was_recorded_is_compared():
    started = next(o for o in read_recording(GOLDEN).outputs if isinstance(o, EpisodeStarted))
    today = msgspec.structs.replace(started, trust=0.4, shaping=0.5)
    assert as_far_as_recorded(started, today) == started
    assert as_far_as_recorded(msgspec.structs.replace(started, trust=0.3), today) == today


def test_events_of_version_1_under_a_header_of_version_2_are_named(tmp_path):
    lines = written(GOLDEN)
    lines[0]["version"] = 2
    with pytest.raises(
        RecordingError, match=r"h.jsonl:2: .*this episode-started is of version 1.*says version 2"
    ):
        read_recording(sealed(tmp_path / "h.jsonl", lines))


def test_a_field_of_version_2_in_a_file_of_version_1_is_refused(tmp_path):
    lines = written(GOLDEN)
    lines[1]["trust"] = 0.5
    with pytest.raises(RecordingError, match=r"h.jsonl:2: .*unknown field `trust`"):
        read_recording(sealed(tmp_path / "h.jsonl", lines))


@pytest.mark.parametrize(
    ("version", "reason"),
    [
        (
            3,
            (
                "version 3 of the format, newer than this program, which reads up to version 2.*: update this "  # noqa: E501
                "program"
            ),
        ),
        (0, "version 0 of the format; this program reads versions 1 to 2"),
        ("two", "Expected `int`, got `str` - at `\\$.version`"),
    ],
)
def test_a_version_that_cannot_be_read_is_named_whatever_else_the_header_holds(tmp_path, version, reason):
    future = {"a field of the future": {"x": 1}} if version == 3 else {}
    header = {**written(GOLDEN)[0], "version": version, **future}
    with pytest.raises(RecordingError, match=rf"h.jsonl:1: {reason}"):
        read_recording(sealed(tmp_path / "h.jsonl", [header, {"type": "something-new"}]))


def test_a_header_whose_version_was_changed_is_told_from_one_of_that_version(tmp_path):
    changed = tmp_path / "changed.jsonl"
    changed.write_bytes(GOLDEN.read_bytes().replace(b'"version":1', b'"version":2', 1))
    with pytest.raises(
        RecordingError, match=r"changed.jsonl:1: the header was changed .* was of version 1 of"
    ):
        read_recording(changed)
    changed.write_bytes(GOLDEN.read_bytes().replace(b"2026", b"2027", 1))
    with pytest.raises(RecordingError, match=r"changed.jsonl:1: the line's chain does not follow"):
        read_recording(changed)
