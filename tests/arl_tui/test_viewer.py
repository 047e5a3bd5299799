"""The viewer: keys, mouse, timeline, panels, tags, films, and pictures of the screen."""

import asyncio
import csv
import shutil
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from textual.events import MouseMove
from textual.geometry import Offset
from textual.pilot import Pilot

from arl_tui.cli import main
from arl_tui.viewer.app import ViewerApp
from arl_tui.viewer.pictures import pictures_of
from arl_tui.viewer.reading import Viewing, rules_of
from arl_tui.viewer.rows import Rows
from arl_tui.viewer.screen import ViewerScreen
from arl_tui.viewer.timeline import clock_text
from arl_tui.viewer.workers import Working
from core.numerics.clock import ManualClock
from core.recording.reader import RecordingError
from studies.session_view.session import open_session
from studies.session_view.tags import Tags
from studies.session_view.thinking import own_thoughts, what_if_thoughts
from studies.session_view.thoughts import Thoughts
from tests.studies.session_view.made import KEEPAWAY, MS, TETRIS, live_events, write

pytestmark = pytest.mark.jit


class Looking:
    """A viewer of a copy of a recording, at a moment of a clock that only the test moves."""

    def __init__(self, path: Path, folder: Path, *, thinks: bool = True) -> None:
        self.path = folder / path.name
        if path != self.path:
            shutil.copy(path, self.path)
        self.folder = folder
        self.clock = ManualClock()
        session = open_session(self.path)
        own = Working(Thoughts(folder / "none"), None, "no values")
        if thinks:
            own = Working(Thoughts(folder / "own"), None, own_thoughts(self.path, folder / "own"))
        self.viewing = Viewing(
            self.path, session, Tags(self.path), rules=rules_of(session), own=own, begin_what_if=self.begin
        )
        self.viewing.warm_up()
        self.screen = ViewerScreen(self.viewing, pictures_of(session), clock=self.clock, colours="truecolor")
        self.app = ViewerApp(self.screen, saved_in=folder)

    def begin(self, protocol) -> Working:
        words = what_if_thoughts(self.path, self.folder / "other", protocol)
        return Working(Thoughts(self.folder / "other"), None, words)

    @property
    def s(self) -> float:
        session = self.viewing.session
        return (self.screen.transport.time_ns - session.start_ns) / 1e9

    def text(self, name: str) -> str:
        return self.screen.query_one(f"#{name}", Rows).text

    @asynccontextmanager
    async def run(self, size: tuple[int, int] = (120, 40)) -> AsyncIterator[Pilot]:
        async with self.app.run_test(size=size) as pilot:
            await pilot.pause()
            yield pilot


@pytest.fixture
def looking(tmp_path: Path) -> Looking:
    return Looking(TETRIS, tmp_path)


# --- moving -------------------------------------------------------------------------------------------------


async def test_keys_go_by_step_press_and_game(looking: Looking) -> None:
    async with looking.run() as pilot:
        assert "step 0" in looking.text("status")
        await pilot.press("right", "right")
        assert "step 2" in looking.text("status")
        await pilot.press("left")
        assert looking.s == 1.12
        await pilot.press("right_square_bracket")
        assert looking.s == pytest.approx(2.859675186)
        await pilot.press("down")
        assert "game 2/3  step 12" in looking.text("status")
        await pilot.press("up", "full_stop", "comma")
        assert looking.s == 0.0
        await pilot.press("end")
        assert looking.s == 46.32


async def test_it_plays_at_the_speed_asked_for_and_pauses(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("space", "plus", "plus")
        looking.clock.advance_ns(1000 * MS)
        looking.screen.draw()
        assert looking.s == 4.0
        assert "playing" in looking.text("status")
        await pilot.press("space", "minus", "minus", "minus")
        looking.clock.advance_ns(1000 * MS)
        looking.screen.draw()
        assert looking.s == 4.0
        assert "x1/2" in looking.text("status")


@pytest.mark.parametrize(
    ("harm", "said"),
    [
        (Path.unlink, "No such file or directory"),
        (lambda path: path.write_bytes(b""), "the file has changed while it was looked at"),
        (lambda path: path.write_bytes(b"{}\n" * path.stat().st_size), "the file has changed while"),
    ],
    ids=["removed", "emptied", "changed"],
)
async def test_a_recording_that_goes_away_ends_the_viewer_with_the_reason(
    harm: Callable[[Path], object], said: str, looking: Looking
) -> None:
    async with looking.run():
        harm(looking.path)
        looking.app.simulate_key("end")  # `Pilot.press` would wait for the screen, which is closed
        async with asyncio.timeout(10):
            while looking.app.is_running:
                await asyncio.sleep(0.01)
    assert looking.app.return_code == 0
    assert isinstance(looking.screen.broken, OSError | RecordingError)
    assert said in str(looking.screen.broken)
    assert str(looking.path) in str(looking.screen.broken)


def test_a_fault_of_the_viewer_is_a_status(looking: Looking) -> None:
    looking.app.stop_if_it_failed()
    looking.app._return_code = 1
    with pytest.raises(click.ClickException, match="ended by a fault of its own"):
        looking.app.stop_if_it_failed()


async def test_a_press_is_found_by_its_number(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("j", "1", "0", "enter")
        assert looking.text("credit").startswith("Press 10 of 24")
        await pilot.press("j", "9", "9", "enter")
        assert "There are presses 1 to 24" in looking.text("foot")
        await pilot.press("j", "escape")
        assert looking.app.is_running
        await pilot.press("q")
    assert looking.app.return_value == "Left at 0:18.7"


async def test_the_mouse_goes_to_a_place_on_the_timeline_and_scrubs(looking: Looking) -> None:
    async with looking.run() as pilot:
        timeline = looking.screen.timeline
        width = timeline.size.width - 8
        await pilot.mouse_down(timeline, offset=(8 + width // 2, 3))
        await pilot.pause()
        assert looking.s == pytest.approx(46.32 / 2, abs=46.32 / width)
        await pilot._post_mouse_events([MouseMove], timeline, Offset(8 + width // 4, 3), 1)
        await pilot.mouse_up(timeline, offset=(8 + width // 4, 3))
        await pilot.pause()
        assert looking.s == pytest.approx(46.32 / 4, abs=46.32 / width)


async def test_the_timeline_zooms_and_follows(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("z", "z", "z")
        assert looking.screen.timeline.stretch.length_ns == pytest.approx(46.32e9 / 8)
        await pilot.press("end")
        stretch = looking.screen.timeline.stretch
        assert stretch.begin_ns <= looking.screen.transport.time_ns <= stretch.end_ns
        await pilot.press("x", "x", "x", "x")
        assert looking.screen.timeline.stretch.length_ns == pytest.approx(46.32e9)


# --- what is seen -------------------------------------------------------------------------------------------


async def test_shares_move_at_once_with_the_rule(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("j", "1", "0", "enter")
        assert "as recorded: previous" in looking.text("credit")
        assert "step 13 100%" in looking.text("credit")
        before = dict(looking.screen._board._marks)
        await pilot.press("c")
        assert "paper: gamma:2.5,0.3" in looking.text("credit")
        assert "step 14 78%" in looking.text("credit")
        assert looking.screen._board._marks != before
        await pilot.press("C", "C")
        assert "current" in looking.text("credit")
        await pilot.press("m")
        assert not looking.screen._board._marks


async def test_values_and_choices_of_a_decision(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("down", "right", "right")
        text = looking.text("thought")
        assert "Agent  policy 18, linear  trust 0.05 weight 0.05" in text
        assert text.count("◀") == 1
        assert "R alone" in text
        assert "exact replay: 69 outputs equal" in text
        ranks = {mark[0] for mark in looking.screen._board._marks.values()}
        assert "1 " in ranks


async def test_a_what_if_beside_it_and_the_decisions_that_differ(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("n")
        assert "w begins a what-if" in looking.text("foot")
        await pilot.press("c", "w")
        assert "What-if paper: gamma:2.5,0.3" in looking.text("thought")
        assert "3 of 36 decisions differ" in looking.text("thought")
        await pilot.press("n")
        assert "step 19" in looking.text("status")
        assert "◆" in looking.screen.timeline.text
        await pilot.press("n", "n", "n")
        assert "No decision behind this one differs" in looking.text("foot")
        await pilot.press("N")
        await pilot.press("w")
        assert looking.viewing.other is None


async def test_a_live_session_shows_pauses_gaps_and_refused_presses(tmp_path: Path) -> None:
    path = write(tmp_path / "live.jsonl", live_events())
    looking = Looking(path, tmp_path, thinks=False)
    async with looking.run() as pilot:
        text = looking.screen.timeline.text
        for mark in ("▲", "▒", "#", "x", "·"):
            assert mark in text
        looking.screen.transport.seek(1500 * MS)
        looking.screen.draw()
        assert looking.screen._board.covered
        await pilot.press("right_square_bracket")
        assert not looking.screen._board.covered
        assert "bad, taken back" in looking.text("credit")


async def test_keepaway_draws_bars_at_the_receivers(tmp_path: Path) -> None:
    looking = Looking(KEEPAWAY, tmp_path)
    async with looking.run() as pilot:
        await pilot.press("down", "down", "right", "right")
        bars = looking.screen._pitch._bars
        step = looking.viewing.session.at(looking.screen.transport.time_ns).step
        taken = looking.viewing.session.step_taken(step)
        assert len(bars) == 3
        if taken.detail["target"] >= 0:
            assert looking.viewing.receivers(step)[taken.action] == taken.detail["target"]


def test_receivers_are_those_that_were_recorded(tmp_path: Path) -> None:
    looking = Looking(KEEPAWAY, tmp_path)
    session, pictures = looking.viewing.session, looking.screen._pictures
    for row in range(len(session.steps)):
        pictures.at(session.at(int(session.steps["shown"][row])))
        taken = session.step_taken(row)
        if taken.detail["target"] >= 0:
            assert looking.viewing.receivers(row)[taken.action] == taken.detail["target"]


# --- tags and pictures --------------------------------------------------------------------------------------


async def test_tags_notes_and_their_table(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("right", "3", "t", *"looks away", "enter", "down", "1", "e")
        assert "2 tagged moments" in looking.text("foot")
        await pilot.press("T")
        assert "[3] looks away" in looking.text("status")
        await pilot.press("d")
    assert [tag.tag for tag in Tags(looking.path).all] == ["1"]
    rows = list(csv.DictReader(Path(f"{looking.path}.tags.csv").read_text().splitlines()))
    assert [(row["tag"], row["note"], row["game"], row["step"]) for row in rows] == [
        ("3", "looks away", "1", "1"),
        ("1", "", "2", "12"),
    ]


async def test_the_screen_is_saved_as_svg_and_png(looking: Looking) -> None:
    async with looking.run() as pilot:
        await pilot.press("p", "p")
    saved = sorted(path.name for path in looking.folder.glob("*.svg"))
    assert saved == ["tetris-linear-equation-4-0.00s-2.svg", "tetris-linear-equation-4-0.00s.svg"]
    with Image.open(looking.folder / "tetris-linear-equation-4-0.00s.png") as picture:
        assert picture.size == (120 * 9, 40 * 18)
        assert len(picture.convert("RGB").getcolors(1 << 20)) > 20


# --- the command --------------------------------------------------------------------------------------------


def run(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


def test_options_of_the_other_kind_are_refused(looking: Looking) -> None:
    done = run("watch", str(looking.path), "--policy", "hand")
    assert done.exit_code == 2
    assert "--policy: for `arl watch keepaway` only" in done.output
    done = run("watch", "keepaway", "--export", "x.gif")
    assert done.exit_code == 2
    assert "for a recording only" in done.output
    done = run("watch", "nowhere.jsonl")
    assert done.exit_code == 2
    assert "neither keepaway nor a file" in done.output


def test_damaged_tags_and_unknown_rules_are_told(looking: Looking) -> None:
    out = str(looking.folder / "film.cast")
    done = run("watch", str(looking.path), "--export", out, "--credit", "nonsense")
    assert done.exit_code == 2
    assert "unknown credit rule" in done.output
    done = run("watch", str(looking.path), "--export", out, "--scheme", "nonsense")
    assert done.exit_code == 2
    assert "unknown scheme" in done.output
    Path(f"{looking.path}.tags.json").write_text("[")
    done = run("watch", str(looking.path), "--export", out)
    assert done.exit_code == 1
    assert "these tags cannot be read" in done.output


def test_without_a_terminal_it_says_so(looking: Looking) -> None:
    done = run("watch", str(looking.path))
    assert done.exit_code == 1
    assert "needs a terminal" in done.output


def test_times_are_written_as_clocks() -> None:
    assert [clock_text(seconds * 1_000 * MS) for seconds in (0, 61, 3661)] == [
        "0:00.0",
        "1:01.0",
        "1:01:01.0",
    ]


# --- pictures -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
@pytest.mark.parametrize("path", [TETRIS, KEEPAWAY], ids=["tetris", "keepaway"])
def test_it_looks_as_it_did(snap_compare, path: Path, size: tuple[int, int], tmp_path: Path) -> None:
    looking = Looking(path, tmp_path)

    async def look(pilot: Pilot) -> None:
        await pilot.press("down", *["right"] * 3, "right_square_bracket", "c", "right")
        if path == TETRIS:
            await pilot.press("w", "n")
        await pilot.press("2")
        await pilot.press("shift+right", "shift+right", "shift+right")
        looking.screen._said = ""
        looking.screen.draw()

    assert snap_compare(looking.app, terminal_size=size, run_before=look)


def test_all_keys_are_on_one_page(snap_compare, looking: Looking) -> None:
    assert snap_compare(looking.app, terminal_size=(80, 24), press=["h"])
