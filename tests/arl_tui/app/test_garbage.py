"""The garbage collector is held back during a game, and memory does not grow meanwhile."""

import gc
from collections.abc import Iterator

import pytest

from arl_tui.app.garbage import ALL_EVERY, OF_PYTHON, OLDER_EVERY, SWEEP_EVERY, GarbageControl


class Knot:
    """Refers to itself, so only the collector frees it."""

    living = 0

    def __init__(self) -> None:
        self.me = self
        Knot.living += 1

    def __del__(self) -> None:
        Knot.living -= 1


@pytest.fixture
def control() -> Iterator[GarbageControl]:
    gc.collect()
    Knot.living = 0
    control = GarbageControl()
    control.first_paint()
    control.hold()
    yield control
    control.restore()


def test_nothing_is_collected_by_itself_during_a_game(control: GarbageControl) -> None:
    for _ in range(100_000):
        Knot()
    assert Knot.living == 100_000


@pytest.mark.parametrize("covered", [False, True], ids=["in a game", "in a pause"])
def test_what_frames_leave_behind_does_not_add_up(control: GarbageControl, covered: bool) -> None:
    most, shown = 0, [Knot()]
    for _ in range(40 * SWEEP_EVERY * OLDER_EVERY):
        shown = [Knot() for _ in range(3)]  # those on screen live until the next look
        control.look(covered=covered)
        most = max(most, Knot.living)
    assert len(shown) == 3
    # What was on screen at a collection survives it, and is left for the older objects' turn.
    assert most <= 3 * (max(SWEEP_EVERY, ALL_EVERY) + OLDER_EVERY) + 40 * 3 + 6


def test_a_collector_that_is_not_held_back_is_left_alone(control: GarbageControl) -> None:
    control.collect()
    Knot()
    for _ in range(10 * SWEEP_EVERY):
        control.look(covered=False)
    assert gc.isenabled()


@pytest.mark.usefixtures("nothing_frozen")
def test_what_is_left_over_from_the_start_is_frozen_and_given_back() -> None:
    control = GarbageControl()
    control.first_paint()
    assert gc.get_freeze_count() > OF_PYTHON
    control.restore()
    assert gc.get_freeze_count() == 0


@pytest.mark.usefixtures("nothing_frozen")
def test_what_another_program_has_frozen_stays_so() -> None:
    gc.freeze()
    before = gc.get_freeze_count()
    control = GarbageControl()
    control.first_paint()
    control.restore()
    # Fewer by what was let go of meanwhile; `restore` would have left none.
    assert before - 1000 < gc.get_freeze_count() <= before
