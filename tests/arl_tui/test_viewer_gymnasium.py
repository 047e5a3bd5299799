"""The viewer draws recordings of Gymnasium environments, played again from their seeds and actions."""

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("gymnasium")
pytest.importorskip("pygame")

from arl_tui.viewer.pictures import NoPictures, pictures_of
from arl_tui.viewer.rendered import OTHERWISE, RenderedPictures
from core.session.protocol_reading import protocol_from
from studies.session_view.session import open_session
from tests.arl_tui.test_viewer import Looking
from tests.core.interop import own_task
from tests.core.sessions import simulated

pytestmark = pytest.mark.jit
OWN = "tests.core.interop.own_task"


def recorded(folder: Path, **domain: Any) -> Path:
    folder.mkdir()
    protocol = protocol_from(
        {
            "domain": {"type": "gymnasium", **domain},
            "session": {"episodes": 3, "unseen_between": 0, "watched_steps": 12},
            "trainer": {"knowledge": "myopic", "press_probability": 0.9, "max_presses": 9},
        }
    )
    simulated(folder, protocol)
    return folder / "session-5.jsonl"


@pytest.mark.parametrize("env", ["CartPole-v1", "FrozenLake-v1"])
def test_every_step_has_its_picture_whichever_way_one_comes_to_it(env: str, tmp_path: Path) -> None:
    session = open_session(recorded(tmp_path / "r", env=env))
    pictures = pictures_of(session)
    assert isinstance(pictures, RenderedPictures)
    times = [int(time) + 1 for time in session.steps["shown"] if time >= 0]
    forwards = [pictures.at(session.at(time)) for time in times]
    backwards = [pictures.at(session.at(time)) for time in reversed(times)]
    assert [look.view for look in forwards] == [look.view for look in reversed(backwards)]
    assert not any(look.words for look in forwards)
    # Steps are counted anew in each game.
    first = [int(row) for row in session.games["first_step"]]
    assert [forwards[row].view.steps for row in first] == [1, 1, 1]
    assert forwards[first[1] - 1].view.steps == first[1] - first[0]


async def test_the_screen_draws_it_beside_the_credit(tmp_path: Path) -> None:
    looking = Looking(recorded(tmp_path / "r", env=f"{OWN}:make", phi=f"{OWN}:phi"), tmp_path, thinks=False)
    async with looking.app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        session = looking.viewing.session
        looking.screen.transport.seek(int(session.steps["shown"][2]) + 1)
        looking.screen.draw()
        await pilot.pause()
        text = "\n".join(strip.text for strip in looking.screen._compositor.render_strips())
        drawn = next(line for line in text.splitlines() if "*" in line and "x" in line)
        assert drawn.strip("│ ").count(".") >= 7
        n = 3 - int(session.games["first_step"][int(session.steps["episode"][2])])
        assert f"step {n}, reward -{n}" in text


def test_a_game_that_comes_out_otherwise_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    session = open_session(recorded(tmp_path / "r", env=f"{OWN}:make", phi=f"{OWN}:phi"))
    # The user has changed their environment since: it begins elsewhere.
    monkeypatch.setattr(own_task.Beacon, "_seen", lambda env: {"place": 8 - env.place, "lamp": env.lamp})
    look = pictures_of(session).at(session.at(int(session.steps["shown"][0]) + 1))
    assert look.words == OTHERWISE


def test_an_environment_that_is_gone_is_said_not_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = open_session(recorded(tmp_path / "r", env=f"{OWN}:make", phi=f"{OWN}:phi"))
    monkeypatch.delattr(own_task, "make")
    pictures = pictures_of(session)
    assert isinstance(pictures, NoPictures)
    look = pictures.at(session.at(int(session.steps["shown"][0]) + 1))
    assert look.view is None
    assert "has no attribute 'make'" in look.words.replace("\n", " ")
