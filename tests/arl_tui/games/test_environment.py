"""A Gymnasium environment on screen: its pictures as data, and in half blocks."""

import msgspec
import numpy as np
import pytest

from arl_tui.app.link import Picture, _from_worker
from arl_tui.games.registry import screens_of
from core.session.protocol import DEFAULTS
from tests.arl_tui.fakes import episode_started, step_taken

pytest.importorskip("gymnasium")
pytest.importorskip("pygame")


def test_pictures_are_small_travel_as_data_and_follow_the_actions() -> None:
    renderer = screens_of(DEFAULTS["gymnasium:MountainCar-v0"]).renderer(DEFAULTS["gymnasium:MountainCar-v0"])
    (first,) = renderer.begin(episode_started(0))
    step = msgspec.structs.replace(step_taken(0), detail={"action": 2, "time": 0}, reward=-1.0)
    for _ in range(30):
        (tick,) = renderer.act(step)
    assert len(tick.view.pixels) == 3 * tick.view.width * tick.view.height
    assert (tick.view.width, tick.view.steps, tick.view.reward) == (42, 30, -30.0)
    assert tick.view.pixels != first.view.pixels
    sent = msgspec.msgpack.encode(Picture(number=1, step=0, view=tick.view))
    assert _from_worker.decode(sent).view == tick.view


def test_a_picture_is_made_smaller_by_means_of_blocks() -> None:
    from arl_tui.games.gymnasium.renderer import smaller

    picture = np.zeros((80, 84, 3), np.uint8)
    picture[:, ::2] = 200
    small = smaller(picture)
    assert small.shape == (40, 42, 3)
    assert (small == 100).all()
