"""The game of Tetris that is watched and judged."""

import msgspec
import pytest

from arl_tui.calibration.plan import configure
from arl_tui.calibration.scenes import HOVER_HEIGHT, N_WORST, Scene, hover_path, make_scenes
from core.streams import stream
from core.tetris.game import FallingPiece, Primitive, at_rest, landing_row, moved
from core.tetris.picture import FALLING, GHOST, Wall
from studies.reaction_time.protocol import Schedule
from studies.reaction_time.schedule import make_schedule


@pytest.fixture(scope="module")
def watched() -> tuple[Schedule, list[Scene]]:
    (config,) = configure(("feedback-lag",), n_trials=30, n_practice=0)
    schedule = make_schedule(config, 11)
    return schedule, make_scenes(schedule)


def test_good_is_the_experts_place_and_bad_one_of_the_worst(watched: tuple[Schedule, list[Scene]]) -> None:
    schedule, scenes = watched
    assert len(scenes) == len(schedule.trials)
    for plan, scene in zip(schedule.trials, scenes, strict=True):
        rank, total = (int(word) for word in scene.note.rpartition("rank ")[2].split(" of "))
        if plan.condition == "good placement":
            assert rank == 1
        elif plan.condition == "bad placement":
            assert rank > total - N_WORST


def test_a_piece_hovers_by_primitives_and_drops_straight_down(watched: tuple[Schedule, list[Scene]]) -> None:
    for scene in watched[1]:
        board = scene.wall.board
        for before, after in zip(scene.hover, scene.hover[1:], strict=False):
            ways = [before, *(moved(board, before, each) for each in Primitive if each is not Primitive.DROP)]
            assert after in ways
        assert at_rest(board, scene.hover[-1]) == scene.landed
        assert {place.row for place in scene.hover} == {scene.wall.rows - HOVER_HEIGHT}


def test_the_last_place_is_seen_for_less_than_a_tick_before_the_drop(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    for plan, scene in zip(*((watched[0].trials, watched[1])), strict=True):
        if not plan.catch:
            before_ms = plan.foreperiod_s * 1000 - (len(scene.hover) - 1) * 150
            assert 0 <= before_ms < 150


def test_pictures_do_not_tell_where_the_piece_would_land(watched: tuple[Schedule, list[Scene]]) -> None:
    scene = watched[1][0]
    codes = scene.hovering(0).codes()
    assert [code & (FALLING | GHOST) for code in codes if code & (FALLING | GHOST)] == [FALLING] * 4


def test_the_event_marks_the_piece_that_dropped_and_where_it_came_from(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    for scene in watched[1]:
        before, after = scene.hovering(10**6).codes(), scene.event().codes()
        hovered = [at for at, code in enumerate(before) if code & FALLING]
        assert [at for at, code in enumerate(after) if code & GHOST] == hovered
        landed = [at for at, code in enumerate(after) if code & FALLING]
        assert [at % 10 for at in landed] == [at % 10 for at in hovered]
        assert max(hovered) < min(landed)


def test_scenes_follow_from_the_schedule_and_survive_the_way_between_processes(
    watched: tuple[Schedule, list[Scene]],
) -> None:
    schedule, scenes = watched
    again = make_scenes(msgspec.json.decode(msgspec.json.encode(schedule), type=Schedule))
    assert msgspec.json.decode(msgspec.json.encode(again), type=list[Scene]) == scenes


def test_a_place_that_no_drop_reaches_is_an_error() -> None:
    wall = Wall(20, 10)
    row = landing_row(wall.board, 1, 0, 3)
    with pytest.raises(ValueError, match="cannot be reached"):
        hover_path(wall, FallingPiece(1, 0, row + 1, 3), 4, rng=stream(1, "test"))
