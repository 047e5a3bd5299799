"""Whatever happens in front of a live screen, replay does not refuse what was recorded of it."""

import contextlib
from pathlib import Path

import msgspec
from hypothesis import given, settings
from hypothesis import strategies as st

from core.events import Input, Output, QuestionPosed, TimeGap
from core.feedback.asking_config import AskingConfig
from core.feedback.keys import KeyConfig
from core.recording.reader import Recording, RecordingError
from core.recording.schema import Header
from core.session.inputs import check_inputs
from tests.arl_tui.app.test_live import MS, Bench
from tests.arl_tui.fakes import episode_ended, episode_started, step_taken

ASKING = AskingConfig(per_episode=9, limit_s=1.0)
KEYS = KeyConfig(max_presses_per_episode=3, wrong_press_rate=0.3)
WORDS = st.sampled_from(
    ["press", "press", "press", "show", "show", "step", "step", "again", "cover", "uncover", "count-down", "gap", "focus",  # noqa: E501
     "episode", "wait", "taken in", "ask", "ask", "look", "take down"]
)  # fmt: skip
KEY = st.sampled_from(
    [
        "j",
        "f",
        "u",
        "x",
        "space",
        "J",
        "1",
        "2",
        "0",
        "\N{CYRILLIC SMALL LETTER O}",
        "\N{CYRILLIC SMALL LETTER A}",
    ]
)


class Room(Bench):
    """A bench whose worker says true times, and how many inputs it has taken in."""

    def __init__(self, seed: int) -> None:
        super().__init__(KEYS, seed, asking=ASKING)
        self.step = -1
        self.shown = -1
        self.taken_in = 0
        self.read_ns = 0
        self.asked = 0

    def say_output(self, output: Output) -> None:
        self.link.say(msgspec.structs.replace(output, time_ns=self.clock.now_ns(), inputs=self.taken_in))

    def happen(self, word: str, key: str, ms: int) -> None:
        self.clock.advance_ns(ms * MS)
        now_ns = self.clock.now_ns()
        match word:
            case "press":
                # The key was read a while ago, after the key before.
                self.read_ns = max(self.read_ns, now_ns - ms // 2 * MS)
                self.live.key_pressed(key, self.read_ns)
            case "show" | "again":
                step = self.step if word == "show" else self.shown
                self.stamps.append((self.live.painted(step), now_ns))
                self.shown = step
            case "step" if self.shown == self.step:  # the player waits until each step has been seen
                self.step += 1
                self.say_output(step_taken(self.step))
            case "ask" if not self.live.gate.covered:
                posed = QuestionPosed(
                    question=self.asked, episode=0, step=self.step + 1, time_ns=now_ns, inputs=self.taken_in,
                    options=[4, 2], details=[{}, {}], disagreement=0.5,
                )  # fmt: skip
                self.asked += 1
                self.say_output(posed)
                self.live.pose(posed)
                self.stamps.append((self.live.question_painted(), now_ns))
            case "look":
                self.live.look_at_question()
            case "take down":
                self.live.take_question_down()
            case "cover":
                self.live.take_question_down()
                self.live.cover("pause")
            case "uncover" if self.live.question is None:
                self.live.uncover()
            case "count-down" if self.live.question is None:
                self.live.count_down()
            case "gap":
                gap = TimeGap(last_ns=now_ns - ms * MS, time_ns=now_ns)
                self.live.find_gap = lambda found=[gap]: found.pop() if found else None
                self.live.notice_gap()
                self.live.take_question_down()
                self.live.cover("gap")
            case "focus":
                self.live.focus(ms % 2 == 0)
            case "episode":
                self.say_output(episode_ended())
                self.say_output(episode_started(1))
            case "taken in":
                self.live.collect_frames()
                self.taken_in = len([event for event in self.sink.events if isinstance(event, Input)])


def header(seed: int) -> Header:
    return Header(
        origin="live", created_utc="2026-11-22T10:00:00+00:00", clock="manual", clock_resolution_ns=1, started_ns=0,  # noqa: E501
        participant="P01", root_seed=seed, protocol={}, software={},
    )  # fmt: skip


@settings(max_examples=150, deadline=None)
@given(
    st.lists(st.tuples(WORDS, KEY, st.sampled_from([0, 1, 30, 50, 90, 250, 600, 1500])), max_size=60),
    st.integers(0, 3),
    st.booleans(),
)
def test_what_a_live_screen_records_is_not_refused(happenings, seed, stopped):
    room = Room(seed)
    room.live.begin(room.sink)
    room.say_output(episode_started())
    for word, key, ms in happenings:
        room.happen(word, key, ms)
    if stopped:
        room.live.stop()
    recording = Recording(Path("room.jsonl"), header(seed), tuple(room.sink.events), complete=False)
    check_inputs(recording, KEYS, ASKING)


NUMBERS = st.integers(-2, 6) | st.integers(-(2**63), 2**63 - 1)
ANY = st.deferred(lambda: NUMBERS | st.floats(allow_nan=False) | st.none() | st.text(max_size=3))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.tuples(WORDS, KEY, st.sampled_from([0, 50, 250])), max_size=20), st.data())
def test_any_other_values_are_taken_or_refused(happenings, data):
    """Never another error than the documented one."""
    room = Room(1)
    room.live.begin(room.sink)
    room.say_output(episode_started())
    for word, key, ms in happenings:
        room.happen(word, key, ms)
    events = list(room.sink.events)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(0, len(events) - 1))
        event = events[at]
        name = data.draw(st.sampled_from(event.__struct_fields__))
        kind = type(event)
        try:
            events[at] = msgspec.convert(
                {**msgspec.to_builtins(event), name: data.draw(ANY), "type": kind.__struct_config__.tag}, kind
            )
        except msgspec.ValidationError:
            continue
    with contextlib.suppress(RecordingError):
        check_inputs(Recording(Path("room.jsonl"), header(1), tuple(events), complete=False), KEYS)
