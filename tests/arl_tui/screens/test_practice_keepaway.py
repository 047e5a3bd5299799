"""Practice of Keepaway on the screen: it explains itself, takes passes, pauses and ends."""

import msgspec
from textual.widgets import Static

from arl_tui.screens.practice import PracticeApp, PracticeHelp
from arl_tui.screens.practice_keepaway import KeeperHelp, KeeperPracticeScreen
from arl_tui.screens.watch import WatchApp
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import ONGOING, TAKEN
from core.numerics.clock import ManualClock
from core.tetris.game import Primitive
from tests.arl_tui.pitches import HOLDING

S = 1_000_000_000
CYCLES = 5


class Match:
    """Games of five cycles; notes what is wished for."""

    def __init__(self) -> None:
        self.wishes: list[int] = []
        self.frame: PitchFrame = msgspec.structs.replace(HOLDING, episode=1, cycle=0)

    def pass_to(self, keeper: int) -> None:
        self.wishes.append(keeper)

    def step(self) -> PitchFrame:
        if self.frame.ended != ONGOING:
            return self.next_episode()
        cycle = self.frame.cycle + 1
        self.frame = msgspec.structs.replace(
            self.frame, cycle=cycle, time_s=cycle / 10, ended=TAKEN if cycle == CYCLES else ONGOING
        )
        return self.frame

    def next_episode(self) -> PitchFrame:
        self.frame = msgspec.structs.replace(HOLDING, episode=self.frame.episode + 1, cycle=0)
        return self.frame

    def values(self) -> tuple[tuple[str, float], ...]:
        return ()


def practice(clock: ManualClock, games: int = 2) -> tuple[WatchApp, KeeperPracticeScreen, Match]:
    match = Match()
    view = KeeperPracticeScreen(keepers=3, games=games, length_m=20.0, width_m=20.0, speed=1.0, clock=clock)
    return WatchApp(view, lambda: match), view, match


async def test_it_explains_itself_first_and_time_stands_still() -> None:
    clock = ManualClock()
    app, view, match = practice(clock)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause(0.2)
        assert isinstance(app.screen, KeeperHelp)
        text = "\n".join(str(widget.render()) for widget in app.screen.query(Static))
        assert "pass to K3" in text
        assert view.playback.paused
        await pilot.press("space")
        await pilot.pause()
        assert not view.playback.paused
        await pilot.press("2", "9")
        assert match.wishes == [1]
        await pilot.press("h")
        await pilot.pause()
        assert isinstance(app.screen, KeeperHelp)
        await pilot.press("q")
        await pilot.pause(0.1)
    assert app.return_value == "No game was played to its end."


async def test_it_ends_after_its_games() -> None:
    clock = ManualClock()
    app, view, _ = practice(clock)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause(0.2)
        await pilot.press("space")
        await pilot.pause()
        for _ in range(20):
            clock.advance_ns(S)
            view.draw()
            await pilot.pause()
            if not view.is_current:
                break
    assert app.return_value.startswith("2 games")


async def test_practice_of_tetris_explains_itself_and_ends_after_its_games() -> None:
    app = PracticeApp(seed=4, clock=ManualClock(), games=1, explain=True)
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        assert isinstance(app.screen, PracticeHelp)
        await pilot.press("space")
        await pilot.pause()
        for _ in range(10):
            app.practice.game.step(Primitive.DROP)
        await pilot.press("space", "space")
        assert app.practice.game.over
        await pilot.press("n")
        await pilot.pause()
    assert app.return_value == app.practice.game.lines


async def test_help_stops_the_pieces_and_q_leaves_from_it() -> None:
    app = PracticeApp(seed=4, clock=ManualClock())
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.press("h")
        await pilot.pause()
        assert isinstance(app.screen, PracticeHelp)
        assert not app.practice._gravity.running
        await pilot.press("h")
        await pilot.pause()
        assert app.practice._gravity.running
        await pilot.press("h")
        await pilot.pause()
        await pilot.press("q")
        await pilot.pause()
    assert app.return_value == 0
