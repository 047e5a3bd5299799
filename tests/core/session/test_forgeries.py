"""Recordings that were changed and sealed anew: replay refuses what cannot have happened, with line and
reason."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

from core.events import EpisodeEnded, FrameShown, KeyPressed, PressRetracted, StepTaken, StopAsked, TimeGap
from core.feedback.keys import KeyConfig, PressGate, WrongPressPlan
from core.feedback.layouts import possible_readings
from core.recording.reader import Recording, RecordingError, read_recording
from core.session.inputs import check_inputs
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session

REFERENCE = Path(__file__).resolve().parents[3] / "recordings" / "reference"
FILES = sorted(REFERENCE.rglob("*.jsonl"))
ORIGINAL = REFERENCE / "version-2" / "tetris-linear-equation-4.jsonl"
MS = 1_000_000

Events = list
Forge = Callable[[Events], None]


def keys_of(recording: Recording) -> KeyConfig:
    return protocol_from(recording.header.protocol).keys


def with_events(recording: Recording, events: Events) -> Recording:
    return Recording(recording.path, recording.header, tuple(events), recording.complete)


def places(events: Events, kind: type, **fields) -> list[int]:
    return [
        n
        for n, event in enumerate(events)
        if isinstance(event, kind) and all(getattr(event, name) == value for name, value in fields.items())
    ]


def change(events: Events, at: int, **fields) -> None:
    events[at] = msgspec.structs.replace(events[at], **fields)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(REFERENCE)))
def test_what_was_recorded_can_have_happened(path):
    recording = read_recording(path)
    check_inputs(recording, keys_of(recording))
    for kept in range(0, len(recording.events), 9):
        check_inputs(with_events(recording, recording.events[:kept]), keys_of(recording))


def keys_exchanged(events: Events) -> None:
    for at in places(events, KeyPressed):
        change(events, at, key={"j": "f", "f": "j"}[events[at].key])


def all_praised(events: Events) -> None:
    for at in places(events, KeyPressed, value=-1.0):
        change(events, at, value=1.0)


def a_refused_press_accepted(events: Events) -> None:
    at = places(events, KeyPressed)[0]
    change(events, at, verdict="repeat")


def presses_elsewhere(events: Events) -> None:
    """Under another step than the frames tell."""
    at = places(events, KeyPressed)[1]
    change(events, at, step=events[at].step + 1)


def presses_moved_before_their_frame(events: Events) -> None:
    for at in places(events, KeyPressed):
        change(events, at, time_ns=events[at].time_ns - 2000 * MS)


def presses_moved_behind_what_took_them_in(events: Events) -> None:
    for at in places(events, KeyPressed):
        change(events, at, time_ns=events[at].time_ns + 2000 * MS)


def frames_earlier_than_their_steps(events: Events) -> None:
    for at in places(events, FrameShown):
        change(events, at, flushed_ns=max(0, events[at].flushed_ns - 20 * MS))


def frames_later_than_what_took_them_in(events: Events) -> None:
    for at in places(events, FrameShown):
        change(events, at, flushed_ns=events[at].flushed_ns + 5000 * MS)


def a_frame_of_a_step_to_come(events: Events) -> None:
    at = places(events, FrameShown)[3]
    change(events, at, step=events[at].step + 3)


def a_frame_twice(events: Events) -> None:
    at = places(events, FrameShown)[3]
    events.insert(at, events[at])


def a_press_too_many(events: Events) -> None:
    at = places(events, KeyPressed)[0]
    events.insert(at + 1, msgspec.structs.replace(events[at], time_ns=events[at].time_ns + 150 * MS))


def a_press_left_out(events: Events) -> None:
    del events[places(events, KeyPressed)[0]]


def a_press_taken_back(events: Events) -> None:
    at = places(events, KeyPressed)[0]
    events.insert(at + 1, PressRetracted(press=0, time_ns=events[at].time_ns, reason="participant"))


def more_inputs_taken_in_than_there_are(events: Events) -> None:
    change(events, places(events, EpisodeEnded)[0], inputs=10_000)


def time_goes_back(events: Events) -> None:
    change(events, places(events, StepTaken)[4], time_ns=0)


def a_time_of_no_clock(events: Events) -> None:
    change(events, places(events, KeyPressed)[0], time_ns=-5)


def a_gap_backwards(events: Events) -> None:
    at = places(events, KeyPressed)[0]
    time_ns = events[at].time_ns
    events.insert(at + 1, TimeGap(last_ns=time_ns + 5, time_ns=time_ns))


def another_alphabet(events: Events) -> None:
    change(events, places(events, KeyPressed)[0], read_as="f", layout="Russian")


FORGERIES: list[Forge] = [
    keys_exchanged, all_praised, a_refused_press_accepted, presses_elsewhere, presses_moved_before_their_frame,  # noqa: E501
    presses_moved_behind_what_took_them_in, frames_earlier_than_their_steps, frames_later_than_what_took_them_in,  # noqa: E501
    a_frame_of_a_step_to_come, a_frame_twice, a_press_too_many, a_press_left_out, a_press_taken_back,
    more_inputs_taken_in_than_there_are, time_goes_back, a_time_of_no_clock, a_gap_backwards, another_alphabet,  # noqa: E501
]  # fmt: skip


@pytest.mark.parametrize("forge", FORGERIES, ids=lambda forge: forge.__name__)
def test_a_forgery_is_refused_with_its_line(forge):
    recording = read_recording(ORIGINAL)
    events = list(recording.events)
    forge(events)
    first = next(n for n, (old, new) in enumerate(zip(recording.events, events, strict=False)) if old != new)
    with pytest.raises(
        RecordingError, match=r"\.jsonl:(\d+): .*changed after it was recorded, and sealed"
    ) as raised:
        check_inputs(with_events(recording, events), keys_of(recording))
    line = int(str(raised.value).split(".jsonl:")[1].split(":")[0])
    assert first + 2 <= line <= first + 40


def test_keys_exchanged_in_the_header_are_refused():
    recording = read_recording(ORIGINAL)
    keys = keys_of(recording)
    exchanged = msgspec.structs.replace(keys, good=keys.bad, bad=keys.good)
    with pytest.raises(RecordingError, match=r"press 0: its value is"):
        check_inputs(recording, exchanged)


def test_more_accepted_presses_than_the_budget_are_refused():
    recording = read_recording(ORIGINAL)
    with pytest.raises(RecordingError, match=r"its verdict is 'accepted'; .*follows 'no-presses-left'"):
        check_inputs(recording, msgspec.structs.replace(keys_of(recording), max_presses_per_episode=1))


def test_presses_moved_by_20_ms_are_refused_or_credited_otherwise():
    """Under a density even a press that could have been made then is shared out otherwise."""
    path = REFERENCE / "version-2" / "keepaway-exponential-equation-4.jsonl"
    recording = read_recording(path)
    events = list(recording.events)
    for at in places(events, KeyPressed):
        change(events, at, time_ns=events[at].time_ns + 20 * MS)
    forged = with_events(recording, events)
    protocol = protocol_from(recording.header.protocol)
    try:
        result = replay_exactly(forged, build_session(protocol, recording.header.root_seed))
    except RecordingError:
        return
    assert result.difference is not None


def live(events: Events, **keys) -> Recording:
    original = read_recording(ORIGINAL)
    header = msgspec.structs.replace(original.header, origin="live")
    return Recording(original.path, header, tuple(events), complete=False)


def test_a_live_screen_takes_nothing_in_behind_its_end():
    stop = StopAsked(time_ns=5, reason="participant")
    with pytest.raises(RecordingError, match=r":3: frame-shown behind the request to stop"):
        check_inputs(live([stop, FrameShown(frame=0, step=-1, flushed_ns=6)]), KeyConfig())


def test_requests_for_wrong_presses_follow_from_the_seed():
    keys = KeyConfig(wrong_press_rate=0.5)
    for seed in range(20):
        plan, gate = WrongPressPlan(0.5, seed), PressGate(keys)
        gate.episode_started()
        if plan.due(gate):
            assert gate.wrong_asked
            assert not plan.due(gate)
            break
    else:
        pytest.fail("half of all seeds ask before the first press")
    assert not WrongPressPlan(0.0, 1).due(PressGate(keys))


def test_a_key_can_only_be_read_as_its_layout_says():
    assert {reading.letter for reading in possible_readings("\N{CYRILLIC SMALL LETTER O}")} == {"j"}
    assert possible_readings("j") == frozenset()
    assert possible_readings("space") == frozenset()
    assert {reading.letter for reading in possible_readings("semicolon")} == {"q"}


def test_blank_lines_do_not_shift_the_line_that_is_named(tmp_path):
    lines = ORIGINAL.read_bytes().split(b"\n")
    path = tmp_path / "blank.jsonl"
    path.write_bytes(b"\n".join([*lines[:3], b"", *lines[3:5], b"", *lines[5:]]))
    recording = read_recording(path)
    assert [recording.line_of(n) for n in range(6)] == [2, 3, 5, 6, 8, 9]
