"""What was on screen, what became of presses, where the transport goes; credit strips; tags."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from core.numerics.clock import NS_PER_S, ManualClock
from studies.session_view.credit_strip import strip_of
from studies.session_view.session import SessionView, open_session
from studies.session_view.tags import Tag, Tags, TagsError, write_tags_csv
from studies.session_view.transport import SPEEDS, Transport
from tests.full_disk import files_end_at
from tests.studies.session_view.made import MS, RECORDINGS, live_events, write


@pytest.fixture
def session(tmp_path: Path) -> SessionView:
    return open_session(write(tmp_path / "live.jsonl", live_events()))


def test_time_on_screen_leaves_the_pause_out(session: SessionView) -> None:
    assert session.at(1300 * MS).visible_ns == 300 * MS
    assert session.at(1500 * MS).covered == "pause"
    assert session.at(1500 * MS).visible_ns == 400 * MS
    after = session.at(5500 * MS)
    assert (after.step, after.covered) == (0, "")
    assert after.visible_ns == 500 * MS


def test_frames_shown_again_after_a_pause_are_not_counted_twice(session: SessionView) -> None:
    assert session.frames["nth"].tolist()[1:10] == [0, 1, 2, 3, 4, -1, 5, 6, 7]
    assert session.frames_of(0) == 8


def test_what_became_of_presses(session: SessionView) -> None:
    assert [session.press_at(row).kind for row in range(4)] == [
        "good",
        "refused",
        "taken back",
        "no feedback",
    ]
    assert session.press_at(1).words == "good, refused: covered"
    assert session.press_at(2).words == "bad, taken back"


def test_stretches_of_the_timeline(session: SessionView) -> None:
    assert session.pauses == [(1400 * MS, 5400 * MS, "pause")]
    assert session.unfocused == [(6600 * MS, 6700 * MS, "")]
    assert session.gaps == [(7000 * MS, 9000 * MS, "gap")]


def test_it_goes_to_the_next_and_the_previous(session: SessionView) -> None:
    assert session.following("step", 1000 * MS) == 6000 * MS
    assert session.following("step", 6000 * MS, -1) == 1000 * MS
    assert session.following("press", 0) == 1380 * MS
    assert session.following("press", 6800 * MS) == 6800 * MS  # the last that means something
    assert session.following("frame", 1000 * MS) == 1080 * MS


class TestTransport:
    @pytest.fixture
    def clock(self) -> ManualClock:
        return ManualClock()

    @pytest.fixture
    def transport(self, session: SessionView, clock: ManualClock) -> Transport:
        return Transport(session, clock)

    def test_it_begins_paused_at_the_first_frame(self, transport: Transport, clock: ManualClock) -> None:
        clock.advance_ns(NS_PER_S)
        assert transport.tick() == 950 * MS

    @pytest.mark.parametrize("speed", SPEEDS)
    def test_it_plays_at_any_speed_up_to_the_end(
        self, speed: float, transport: Transport, clock: ManualClock
    ) -> None:
        transport.speed = speed
        transport.toggle()
        clock.advance_ns(100 * MS)
        assert transport.tick() == min(950 * MS + round(100 * MS * speed), 10_000 * MS)
        clock.advance_ns(200 * NS_PER_S)
        assert transport.tick() == 10_000 * MS
        assert not transport.playing

    def test_a_change_of_speed_does_not_jump(self, transport: Transport, clock: ManualClock) -> None:
        transport.toggle()
        clock.advance_ns(100 * MS)
        transport.faster()
        clock.advance_ns(100 * MS)
        assert transport.tick() == (950 + 100 + 200) * MS

    def test_it_jumps_to_the_nth_press(self, transport: Transport) -> None:
        assert transport.go_to_press(3)
        assert transport.time_ns == 6800 * MS
        assert not transport.go_to_press(4)
        assert not transport.go_to_press(0)

    def test_it_stays_within_the_recording(self, transport: Transport) -> None:
        transport.seek(-5)
        assert transport.time_ns == 900 * MS
        transport.seek(float("inf"))
        assert transport.time_ns == 10_000 * MS


class TestCredit:
    @pytest.mark.parametrize("path", RECORDINGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
    def test_the_recorded_rule_comes_out_as_recorded(self, path: Path, tmp_path: Path) -> None:
        session = open_session(Path(shutil.copy(path, tmp_path)))
        assert session.protocol is not None
        delay = session.protocol.agent.credit.delay
        compared = 0
        for row in range(len(session.presses)):
            press = session.press_at(row)
            if press.kind in ("good", "bad"):
                recorded = strip_of(session, press, delay, recorded=True)
                worked_out = strip_of(session, press, delay)
                assert worked_out.shares == pytest.approx(recorded.shares, abs=1e-12)
                assert worked_out.outside == pytest.approx(recorded.outside, abs=1e-9)
                compared += 1
        assert compared > 5

    @pytest.mark.parametrize(
        "delay",
        [GammaDelay(), UniformDelay(), PreviousStep(), CurrentStep(), GammaDelay(0.7, 3.0, 0.2)],
        ids=repr,
    )
    def test_shares_and_what_fell_outside_make_one(self, delay, session: SessionView) -> None:
        for row in (0, 1, 2):
            strip = strip_of(session, session.press_at(row), delay)
            assert sum(strip.shares.values()) + strip.outside == pytest.approx(1.0, abs=1e-9)
            density = strip.density(40)
            assert density.shape == (40,)
            assert density.max() == (0 if isinstance(delay, PreviousStep | CurrentStep) else 1)

    def test_by_hand(self, session: SessionView) -> None:
        # Step 0 was on screen from 1000 to 1400 and from 5410 to 6000 ms; press 2 came at 6800 ms.
        strip = strip_of(session, session.press_at(2), UniformDelay(0.2, 1.0))
        assert strip.shares == pytest.approx({0: 0.25, 1: 0.75})
        assert strip_of(session, session.press_at(2), PreviousStep()).shares == {0: 1.0}
        assert strip_of(session, session.press_at(2), CurrentStep()).shares == {1: 1.0}

    def test_nothing_is_credited_beyond_a_gap(self, tmp_path: Path) -> None:
        from tests.studies.session_view.made import pressed

        events = live_events()
        events.insert(-3, pressed(9100 * MS, 9, -1))
        session = open_session(write(tmp_path / "gap.jsonl", events))
        strip = strip_of(session, session.press_at(4), UniformDelay(2.0, 4.0))
        assert strip.shares == {}
        assert strip.outside == pytest.approx(1.0)


class TestTags:
    def test_tags_are_kept_beside_the_recording(self, session: SessionView, tmp_path: Path) -> None:
        path = tmp_path / "live.jsonl"
        tags = Tags(path)
        tags.add(Tag(2000 * MS, "3", "looks away"))
        tags.add(Tag(1000 * MS, "1"))
        assert [tag.tag for tag in Tags(path).all] == ["1", "3"]
        assert tags.near(1900 * MS, 200 * MS) == Tag(2000 * MS, "3", "looks away")
        assert tags.near(1500 * MS, 200 * MS) is None
        tags.remove(Tag(1000 * MS, "1"))
        assert Tags(path).all == [Tag(2000 * MS, "3", "looks away")]
        assert tags.path.stat().st_mode & 0o077 == 0

    def test_a_full_disk_leaves_the_tags_as_they_were(self, tmp_path: Path) -> None:
        tags = Tags(tmp_path / "live.jsonl")
        tags.add(Tag(1000 * MS, "1"))
        with files_end_at(100), pytest.raises(OSError, match="too large"):
            tags.add(Tag(2000 * MS, "3", "looks away"))
        assert tags.all == Tags(tmp_path / "live.jsonl").all == [Tag(1000 * MS, "1")]
        assert [path.name for path in tmp_path.iterdir()] == ["live.jsonl.tags.json"]

    def test_a_damaged_file_is_named_and_left_as_it_is(self, tmp_path: Path) -> None:
        place = tmp_path / "live.jsonl.tags.json"
        place.write_text("{}")
        with pytest.raises(TagsError, match="cannot be read"):
            Tags(tmp_path / "live.jsonl")
        assert place.read_text() == "{}"

    def test_the_table_holds_every_tag(self, tmp_path: Path) -> None:
        tags = [Tag(1500 * MS, "1", 'a "note", with commas'), Tag(2000 * MS, "2")]
        write_tags_csv(tmp_path / "t.csv", tags, lambda time_ns: {"game": time_ns // (1000 * MS)}, 1000 * MS)
        rows = list(csv.DictReader((tmp_path / "t.csv").read_text().splitlines()))
        assert [row["time_s"] for row in rows] == ["0.500000", "1.000000"]
        assert rows[0]["note"] == 'a "note", with commas'
        assert rows[1]["game"] == "2"


def test_times_of_presses_ascend(session: SessionView) -> None:
    assert np.all(np.diff(session.times("press")) > 0)
