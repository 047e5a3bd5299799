"""CPU time per picture of the pitch: `pytest -m benchmark_run tests/benchmarks/test_pitch_speed.py -s -n
0`."""

import statistics
import time

import msgspec
import pytest
from rich.segment import Segment
from textual.app import App, ComposeResult

from arl_tui.widgets.pitch import PitchWidget
from arl_tui.widgets.pitch_drawing import draw, fit
from arl_tui.widgets.pitch_ink import DETAILS, Detail
from core.keepaway.picture import PitchFrame, PlayerView, between
from tests.arl_tui.pitches import PASSING

MOST_MS = 3.0
"""A tenth of the time that a frame has at 30 frames per second."""
FRAMES = 300


def film() -> list[PitchFrame]:
    """Return pictures in which everybody moves, three per cycle."""
    moved = tuple(PlayerView(p.x_m + 0.5, p.y_m - 0.4, p.body_deg + 9) for p in PASSING.players)
    after = msgspec.structs.replace(PASSING, players=moved, ball=(-0.3, -5.7), cycle=PASSING.cycle + 1)
    return [between(PASSING, after, k / FRAMES) for k in range(FRAMES)]


@pytest.mark.benchmark_run
@pytest.mark.parametrize("size", [(80, 24), (120, 40), (200, 60)])
@pytest.mark.parametrize("detail", DETAILS)
def test_a_picture_is_drawn_fast_enough(detail: Detail, size: tuple[int, int]):
    shape = fit(20.0, 20.0, *size)
    assert shape is not None
    times = []
    for frame in film():
        start = time.process_time_ns()
        draw(frame, shape, detail)
        times.append((time.process_time_ns() - start) / 1e6)
    print(
        f"{detail} {size}: median {statistics.median(times):.2f} ms, p95 "
        f"{sorted(times)[int(0.95 * FRAMES)]:.2f} ms"
    )
    assert statistics.median(times) < MOST_MS


class OnePitch(App[None]):
    """A pitch and nothing else."""

    def __init__(self, detail: Detail) -> None:
        super().__init__()
        self.pitch = PitchWidget(detail=detail)

    def compose(self) -> ComposeResult:
        yield self.pitch


@pytest.mark.benchmark_run
@pytest.mark.parametrize("detail", DETAILS)
async def test_a_picture_is_shown_fast_enough(detail: Detail):
    app = OnePitch(detail)
    async with app.run_test(size=(120, 40)) as pilot:
        pictures = film()
        app.pitch.show(pictures[0], 0)
        await pilot.pause()
        lines: list[Segment] = []
        start = time.process_time_ns()
        for k, frame in enumerate(pictures):
            app.pitch.show(frame, k)
            lines = [segment for y in range(40) for segment in app.pitch.render_line(y)]
        each_ms = (time.process_time_ns() - start) / 1e6 / FRAMES
        assert lines
    print(f"{detail} 120 x 40, drawn and made into strips: {each_ms:.2f} ms")
    assert each_ms < MOST_MS
