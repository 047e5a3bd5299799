"""The viewer's pictures are those of the renderer that drew the session; marks know which piece is where."""

import shutil
from pathlib import Path

import pytest

from arl_tui.games.registry import screens_of
from arl_tui.viewer.pictures import BoardPictures, pictures_of
from core.events import EpisodeStarted, StepTaken
from core.recording.importers.tamer_log import IMPORTER
from core.recording.reader import read_recording
from core.session.protocol import Protocol, ScreenConfig
from core.tetris.picture import EMPTY, Snapshot
from studies.session_view.session import open_session
from tests.data_folder import data_folder
from tests.studies.session_view.made import KEEPAWAY, MS, RECORDINGS, TETRIS, live_events, write

pytestmark = pytest.mark.jit


@pytest.mark.parametrize("path", RECORDINGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_picture_of_every_step_is_the_stages(path: Path, tmp_path: Path) -> None:
    session = open_session(Path(shutil.copy(path, tmp_path)))
    assert session.protocol is not None
    renderer, pictures = screens_of(session.protocol).renderer(session.protocol), pictures_of(session)
    row = 0
    for event in read_recording(path).outputs:
        if isinstance(event, EpisodeStarted):
            renderer.begin(event)
        elif isinstance(event, StepTaken):
            ticks = renderer.act(event)
            shown = int(session.steps["shown"][row])
            until = session.following("step", shown) if row + 1 < len(session.steps) else session.end_ns
            for number, tick in enumerate(ticks):
                at = shown + number * renderer.tick_ns + 1
                if at < min(until, shown + len(ticks) * renderer.tick_ns) and session.at(at).step == row:
                    seen = pictures.at(session.at(at)).view
                    assert plain(seen) == plain(tick.view)
            row += 1
    assert row == len(session.steps)


def plain(view: object) -> object:
    """Return a picture without the number of its episode, which a viewer that goes back cannot count."""
    import msgspec

    return msgspec.structs.replace(view, episode=1) if hasattr(view, "episode") else view


@pytest.mark.parametrize("path", [TETRIS, KEEPAWAY], ids=["tetris", "keepaway"])
def test_pictures_do_not_depend_on_how_one_got_there(path: Path, tmp_path: Path) -> None:
    session = open_session(Path(shutil.copy(path, tmp_path)))
    forward, backward = pictures_of(session), pictures_of(session)
    times = range(session.start_ns, session.end_ns, (session.end_ns - session.start_ns) // 60)
    on = [plain(forward.at(session.at(at)).view) for at in times]
    back = [plain(backward.at(session.at(at)).view) for at in reversed(times)]
    assert on == back[::-1]


def test_each_settled_cell_belongs_to_a_step(tmp_path: Path) -> None:
    session = open_session(Path(shutil.copy(TETRIS, tmp_path)))
    pictures = pictures_of(session)
    for at in session.times("step"):
        look = pictures.at(session.at(int(at)))
        assert isinstance(look.view, Snapshot)
        assert look.before is not None
        for row, level in enumerate(look.before.wall.levels):
            for column, code in enumerate(level):
                known = look.before.ids[row][column]
                assert (code == EMPTY) == (known == -1)


def test_a_live_sessions_frames_are_counted(tmp_path: Path) -> None:
    """Step 1 was recorded with eight frames; an O from the top to the floor of 20 rows takes seven
    pictures."""
    pace = Protocol(screen=ScreenConfig(tick_ms=80))  # that of the frames of `live_events`
    session = open_session(write(tmp_path / "live.jsonl", live_events(), protocol=pace))
    pictures = pictures_of(session)
    assert isinstance(pictures, BoardPictures)
    views = [pictures.at(session.at((6000 + 80 * k) * MS)).view for k in range(8)]
    rows = [None if view.falling is None else view.falling.row for view in views]
    falling = [row for row in rows if row is not None]
    assert falling == sorted(falling, reverse=True)
    assert falling[-1] == 0
    assert views[-1].counts.pieces == 2


def test_an_imported_log_of_tamer_is_drawn_as_its_boards_were(tmp_path: Path) -> None:
    log = data_folder("tamer_tetris") / "130.log"
    IMPORTER.run(log, tmp_path, {})
    session = open_session(tmp_path / "130.jsonl")
    pictures = pictures_of(session)
    followed = 0
    for row in range(0, len(session.steps), 7):
        taken = session.step_taken(row)
        look = pictures.at(session.at(int(session.steps["shown"][row])))
        assert look.before is not None
        assert look.before.wall.board == tuple(taken.observed["before"])
        assert look.view.counts.next_piece == -1
        followed += any(step >= 0 for level in look.before.ids for step in level)
    assert followed > 50


def test_a_recording_without_states_says_so(tmp_path: Path) -> None:
    session = open_session(write(tmp_path / "live.jsonl", live_events()))
    session.index.header.protocol.clear()
    look = pictures_of(session).at(session.at(0))
    assert look.view is None
    assert "without the states" in look.words
