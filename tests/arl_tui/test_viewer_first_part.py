"""The viewer shows the first part of a long recording at once, and the rest when its index is there."""

import shutil
from concurrent.futures import Future
from pathlib import Path

import pytest

from arl_tui.viewer.app import ViewerApp
from arl_tui.viewer.pictures import pictures_of
from arl_tui.viewer.reading import Viewing, nothing_worked_out, rules_of
from arl_tui.viewer.rows import Rows
from arl_tui.viewer.screen import ViewerScreen
from arl_tui.viewer.timeline import Timeline
from arl_tui.viewer.workers import WholeIndex
from core.numerics.clock import ManualClock
from core.recording import sealed
from core.recording.reader import RecordingError
from studies.session_view import index
from studies.session_view.session import SessionView, open_at_once, open_session
from studies.session_view.tags import Tags
from tests.studies.session_view.made import RECORDINGS, TETRIS

pytestmark = pytest.mark.jit


@pytest.fixture(autouse=True)
def _short_ones_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index, "WORTH_PARTS", 0)
    monkeypatch.setattr(index, "FIRST_PART", 8000)
    monkeypatch.setattr(sealed, "PIECE", 8000)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return Path(shutil.copy(TETRIS, tmp_path))


@pytest.mark.parametrize("original", RECORDINGS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_the_first_part_says_what_the_whole_says_of_the_beginning(original: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(original, tmp_path))
    part = open_at_once(path)
    assert not part.index.whole
    whole = open_session(path)
    assert whole.index.whole
    assert open_at_once(path).index.whole  # its index is there now
    assert 0 < part.index.events < whole.index.events
    assert len(part.games) >= 1
    assert part.start_ns == whole.start_ns
    # What was on screen at the end of the part may end later in the whole.
    until_ns = int(part.times("frame")[-2])
    for time_ns in range(part.start_ns, until_ns, max(1, (until_ns - part.start_ns) // 50)):
        assert part.at(time_ns) == whole.at(time_ns)


def test_a_session_that_looked_at_the_first_part_looks_at_the_whole(path: Path) -> None:
    part = open_at_once(path)
    before = part.end_ns, len(part.times("press")), len(part.times("step")), part.taken_back, part.pauses
    whole = open_session(path)
    part.look_at(whole.index)
    assert (part.end_ns, len(part.times("press"))) == (whole.end_ns, len(whole.times("press")))
    assert len(part.times("step")) == len(whole.times("step")) > before[2]
    assert part.at(whole.end_ns) == whole.at(whole.end_ns)
    assert part.taken_back == whole.taken_back


def test_what_is_short_damaged_or_packed_is_opened_as_before(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = path.read_bytes()
    path.write_bytes(content.replace(b"\n", b"\r\n"))
    assert open_at_once(path).index.whole
    path.write_bytes(content[:3000].replace(b"rows", b"sows") + content[3000:])
    with pytest.raises(RecordingError):
        open_at_once(path)
    path.write_bytes(content)
    monkeypatch.setattr(index, "WORTH_PARTS", 1 << 24)
    assert open_at_once(path).index.whole


class Shown:
    """A viewer of the first part, and the future of the whole index."""

    def __init__(self, path: Path) -> None:
        self.future: Future[None] = Future()
        self.told = path.with_name("read")
        self.session: SessionView = open_at_once(path)
        self.viewing = Viewing(
            path,
            self.session,
            Tags(path),
            rules=rules_of(self.session),
            own=nothing_worked_out("no values"),
            begin_what_if=lambda protocol: nothing_worked_out("none"),
            whole=WholeIndex(self.told, self.future),
        )
        self.screen = ViewerScreen(
            self.viewing, pictures_of(self.session), clock=ManualClock(), colours="truecolor"
        )
        self.app = ViewerApp(self.screen, saved_in=path.parent)

    @property
    def status(self) -> str:
        return self.screen.query_one("#status", Rows).text


async def test_it_says_how_much_has_been_read_and_then_shows_all(path: Path) -> None:
    shown = Shown(path)
    async with shown.app.run_test(size=(120, 40)) as pilot:
        shown.told.write_text("0.420")
        await pilot.press("end")
        await pilot.pause(0.1)
        assert "reading the rest: 42%  game" in shown.status
        assert " of " not in shown.status  # how long the session is, nobody knows yet
        part_end_ns = shown.screen.transport.time_ns
        whole = open_session(path)
        shown.future.set_result(None)
        await pilot.pause(0.1)
        assert "reading" not in shown.status
        assert " of " in shown.status
        assert shown.screen.transport.time_ns == part_end_ns  # nothing moved by itself
        assert f"/{len(whole.games)}" in shown.status
        for timeline in shown.screen.query(Timeline):
            assert timeline.stretch.end_ns == whole.end_ns
        await pilot.press("end")
        assert shown.screen.transport.time_ns == whole.end_ns > part_end_ns
        assert shown.viewing.rules[0].recorded


async def test_damage_behind_the_first_part_ends_the_viewer_with_its_reason(path: Path) -> None:
    shown = Shown(path)
    async with shown.app.run_test(size=(120, 40)) as pilot:
        shown.future.set_exception(RecordingError("line 99: damaged"))
        await pilot.pause(0.2)
    assert isinstance(shown.screen.broken, RecordingError)
    assert not shown.app.is_running
