"""The last screen: what happened, and how practice went."""

import pytest
from textual.app import App

from arl_tui.app import Outcome
from arl_tui.live import Tally
from arl_tui.screens.closing import ClosingScreen
from arl_tui.words import KEEPAWAY, TETRIS, Words


def tally(practised: list[float]) -> Tally:
    return Tally(performances=[0.0, 3.0], unseen=200, practised=practised, good=2, bad=1, w_h=0.2, steps=28)


class Closing(App[None]):
    CSS_PATH = "../../arl_tui/app.tcss"

    def __init__(self, practised: list[float], words: Words = TETRIS) -> None:
        super().__init__()
        self.closing = ClosingScreen(Outcome(recording=None, tally=tally(practised), trouble=None), words)

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
