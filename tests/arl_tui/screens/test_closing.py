"""The last screen: what happened, and how practice went."""

from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textual.app import App

from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.tally import Tally
from arl_tui.games.keepaway.screens import WORDS as KEEPAWAY
from arl_tui.games.tetris.screens import WORDS as TETRIS
from arl_tui.screens.closing import ClosingScreen
from arl_tui.widgets.learning_curve import LearningCurve, ticks
from arl_tui.words import Words
from tests.arl_tui.widgets.test_widgets_board import contrast


def tally(practised: list[float]) -> Tally:
    return Tally(
        performances=[0.0, 3.0], unseen=200, practised=practised, good=2, bad=1, weight=0.2, steps=28
    )


class Closing(App[None]):
    CSS_PATH = "../../../arl_tui/app.tcss"

    def __init__(
        self,
        practised: list[float],
        words: Words = TETRIS,
        *,
        recording: Path | None = None,
        trouble: str | None = None,
    ) -> None:
        super().__init__()
        outcome = SessionOutcome(recording=recording, tally=tally(practised), trouble=trouble)
        self.closing = ClosingScreen(outcome, words)

    def on_mount(self) -> None:
        self.push_screen(self.closing)


@pytest.mark.parametrize("practised", [[0.5, 12.0], [0.0, 0.0, 0.0], [float(n * n) for n in range(30)]])
@pytest.mark.parametrize(("words", "label"), [(TETRIS, "lines per game"), (KEEPAWAY, "seconds per game")])
async def test_practice_is_plotted_when_there_was_more_than_one_block(practised, words, label):
    app = Closing(practised, words)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        picture = "\n".join(str(strip.text) for strip in app.screen._compositor.render_strips())
    assert label in picture
    assert any("\u2801" <= letter <= "\u28ff" for letter in picture)  # braille: a line was drawn


@pytest.mark.parametrize("practised", [[], [3.0]])
async def test_one_block_makes_no_curve(practised):
    app = Closing(practised)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        assert len(app.screen.query("LearningCurve")) == 0


@pytest.mark.parametrize("size", [(80, 24), (120, 40)], ids=str)
async def test_the_way_out_and_the_curve_fit_on_one_page_in_colours_that_can_be_read(size):
    long_path = Path("/home/somebody/studies/of-this-year/recordings/pilot") / f"P01-{'2' * 24}.jsonl"
    app = Closing([0.8, 1.2, 9.0, 31.0], recording=long_path)
    async with app.run_test(size=size) as pilot:
        await pilot.pause()
        assert app.screen.query_one(".page").max_scroll_y == 0
        curve = app.screen.query_one(LearningCurve)
        for part in ("plot--axis", "plot--tick"):
            style = curve.get_component_styles(part)
            background, _ = curve.background_colors
            assert contrast(background + style.color, background) > 4.5
        heights = {(80, 24): 7, (120, 40): 17}
        assert curve.size.height == heights[size]


async def test_where_something_failed_there_is_no_curve_and_the_way_out_is_in_sight():
    app = Closing(
        [0.8, 1.2, 9.0, 31.0], trouble="\n".join(["It has ended.", *[f"line {k}" for k in range(30)]])
    )
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        assert len(app.screen.query("LearningCurve")) == 0
        assert app.screen.query_one(".page").max_scroll_y == 0
        assert contrast(*_colours(app.screen.query_one(".trouble"))) > 4.5


def _colours(widget):
    _, _, background, text = widget.colors
    return background + text, background


@given(top=st.floats(1e-3, 1e6), most=st.integers(2, 10))
def test_ticks_are_even_few_and_reach_at_least_half_of_the_way(top: float, most: int) -> None:
    found = ticks(top, most)
    assert found[0] == 0.0
    assert 1 <= len(found) - 1 <= most
    assert top / 2 < found[-1] + 1e-9 * top
    assert found[-1] <= top * (1 + 1e-9)
    steps = [after - before for before, after in pairwise(found)]
    assert max(steps) - min(steps) < 1e-9 * top


@pytest.mark.parametrize(
    ("top", "expected"), [(1.0, [0.0, 0.4, 0.8]), (81.3, [0.0, 40.0, 80.0]), (3.2, [0.0, 2.0])]
)
def test_ticks_of_a_low_plot(top: float, expected: list[float]) -> None:
    assert ticks(top, 2) == expected
