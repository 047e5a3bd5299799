"""The game of Tetris that is watched and judged: in a session's own pictures, at its pace."""

import itertools

import msgspec
import pytest

from arl_tui.calibration.plan import configure
from arl_tui.games.tetris.judging import N_WORST, TrialPosition, make_positions, position_of, tick_ms
from arl_tui.games.tetris.renderer import TetrisRenderer
from arl_tui.games.tetris.trial_view import BoardTrialView
from arl_tui.palette import STANDARD
from core.session.protocol import ScreenConfig
from core.tetris.game import reachable_placements
from core.tetris.picture import FALLING, GHOST, Counts, Snapshot, Wall
from core.tetris.plugin import TETRIS
from studies.reaction_time.protocol import Schedule
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.fakes import episode_started, step_taken

TICK_MS = 200


@pytest.fixture(scope="module")
def watched() -> tuple[Schedule, list[TrialPosition]]:
    (config,) = configure(("feedback-lag",), n_trials=30, n_practice=0)
    schedule = make_schedule(config, 11)
    return schedule, make_positions(schedule)


def test_good_is_the_experts_place_and_bad_one_of_the_worst(
    watched: tuple[Schedule, list[TrialPosition]],
) -> None:
    schedule, positions = watched
    assert len(positions) == len(schedule.trials)
    for plan, scene in zip(schedule.trials, positions, strict=True):
        rank, total = (int(word) for word in scene.note.rpartition("rank ")[2].split(" of "))
        if plan.condition == "good placement":
            assert rank == 1
        elif plan.condition == "bad placement":
            assert rank > total - N_WORST


def test_the_pictures_are_those_of_a_session() -> None:
    """The same piece at the same place, drawn by what draws sessions: every picture is the same."""
    wall, started = Wall(20, 10), episode_started()
    for placement, plan in reachable_placements(wall.board, 2, 20).items():
        renderer = TetrisRenderer(TETRIS.domain)  # type: ignore[arg-type]
        (opening,) = renderer.begin(started)
        taken = step_taken(0, piece=2, orientation=placement[0], column=placement[1])
        session = [tick.view for tick in renderer.act(taken)]
        counts = Counts(next_piece=renderer.picture.counts.next_piece)
        scene = position_of(wall, 2, placement, counts, "")
        assert [*scene.before, *scene.event] == session
        assert scene.waiting.codes() == opening.view.codes()  # type: ignore[union-attr]
        assert len(scene.before) == len(plan)


def test_the_drop_is_the_stimulus(watched: tuple[Schedule, list[TrialPosition]]) -> None:
    for scene in watched[1]:
        places = [picture.falling for picture in scene.before]
        assert all(place is not None for place in places)
        # Before: a row per picture at most. Then the piece falls in its column, and comes to rest.
        rows = [place.row for place in places if place is not None]
        assert all(0 <= a - b <= 1 for a, b in itertools.pairwise(rows))
        last, first = scene.before[-1].falling, scene.event[0].falling
        assert last is not None
        assert first is not None
        assert (first.column, first.orientation) == (last.column, last.orientation)
        assert first.row < last.row or len(scene.event) <= 3
        assert scene.event[-1].falling is None
        codes = scene.before[0].codes()
        assert any(code & GHOST for code in codes) or any(code & FALLING for code in codes)


def test_every_move_is_shown_for_a_whole_tick_and_the_drop_comes_with_the_end_of_the_foreperiod(
    watched: tuple[Schedule, list[TrialPosition]],
) -> None:
    schedule, positions = watched
    assert tick_ms(schedule) == TICK_MS == TETRIS.screen.tick_ms
    view = BoardTrialView(positions, STANDARD, TICK_MS, schedule.config.time_out_s)
    shown: list[Snapshot] = []
    # type: ignore[method-assign, func-returns-value]
    view.board.show = lambda picture, number=-1: bool(shown.append(picture))
    assert view.tick_ns is not None
    for plan in (plan for plan in schedule.trials if not plan.catch):
        shown.clear()
        early_ns = view.early_ns(plan)
        total_ns = round(plan.foreperiod_s * 1e9)
        assert (total_ns - early_ns) % view.tick_ns == 0
        ticks = (total_ns - early_ns) // view.tick_ns
        for tick in range(-1, ticks):
            view.wait(plan, tick)
        scene = positions[plan.index]
        seen = shown[-len(scene.before) :]
        assert seen == list(scene.before)[-len(seen) :]
        assert set(map(id, shown[: -len(scene.before)])) <= {id(scene.waiting)}
        view.present(plan)
        for tick in range(len(scene.event) + 1):
            view.follow(plan, tick)
        assert shown[-len(scene.event) - 1 :] == [*scene.event[0:], scene.event[-1]]


def test_no_piece_drops_in_a_catch_trial(watched: tuple[Schedule, list[TrialPosition]]) -> None:
    schedule, positions = watched
    view = BoardTrialView(positions, STANDARD, TICK_MS, schedule.config.time_out_s)
    shown: list[Snapshot] = []
    # type: ignore[method-assign, func-returns-value]
    view.board.show = lambda picture, number=-1: bool(shown.append(picture))
    catches = [plan for plan in schedule.trials if plan.catch]
    assert catches
    for plan in catches:
        last = int((plan.foreperiod_s + schedule.config.time_out_s) * 1000 / TICK_MS)
        for tick in range(-1, last + 1):
            view.wait(plan, tick)
        scene = positions[plan.index]
        assert {id(picture) for picture in shown} <= {id(scene.waiting), *map(id, scene.before)}
        shown.clear()


def test_the_pace_is_the_protocols() -> None:
    protocol = msgspec.structs.replace(TETRIS, screen=ScreenConfig(tick_ms=150))
    (config,) = configure(("feedback-lag",), protocol=protocol)
    assert tick_ms(make_schedule(config, 1)) == 150


def test_scenes_follow_from_the_schedule_and_survive_the_way_between_processes(
    watched: tuple[Schedule, list[TrialPosition]],
) -> None:
    schedule, positions = watched
    again = make_positions(msgspec.json.decode(msgspec.json.encode(schedule), type=Schedule))
    assert msgspec.json.decode(msgspec.json.encode(again), type=list[TrialPosition]) == positions
