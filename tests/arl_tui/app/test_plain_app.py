"""What all apps have in common, on a machine that is too busy to look at the clock in time."""

import itertools
import os

import pytest
from textual import _time, events
from textual.geometry import Size
from textual.screen import Screen

from arl_tui.app.once import after
from arl_tui.app.plain_app import PlainApp, trust_the_terminal
from arl_tui.screens.covers import SmallWindowScreen


class Listening(Screen[None]):
    """Notes every size that it is told of."""

    def __init__(self) -> None:
        super().__init__()
        self.sizes: list[Size] = []

    def on_resize(self, event: events.Resize) -> None:
        self.sizes.append(event.size)


class Sized(PlainApp[None]):
    def __init__(self) -> None:
        super().__init__()
        self.listening = Listening()

    def on_mount(self) -> None:
        self.push_screen(self.listening)


@pytest.fixture
def busy(monkeypatch):
    """Return what makes the machine busy: from then on 10 ms pass between any two looks at the clock."""

    def become_busy() -> None:
        moments = itertools.count(_time.get_time(), 0.010)
        monkeypatch.setattr(_time, "get_time", lambda: next(moments))

    return become_busy


async def test_changes_of_size_are_heard_of_on_a_busy_machine(busy):
    app = Sized()
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause()
        busy()
        for size in (Size(60, 20), Size(100, 30)):
            await pilot.resize_terminal(*size)
            await pilot.pause()
            assert app.listening.sizes[-1] == size


async def test_what_is_to_happen_after_a_while_happens_on_a_busy_machine(busy):
    app = Sized()
    done = []
    async with app.run_test() as pilot:
        busy()
        after(app, 0.005, lambda: done.append("ours"))
        # Why `arl_tui.app.once` is there: as soon as this fails, Textual's own timers can be used again.
        app.set_timer(0.005, lambda: done.append("Textual's"))
        await pilot.pause(0.1)
    assert done == ["ours"]


async def test_what_is_cancelled_does_not_happen():
    app = Sized()
    done = []
    async with app.run_test() as pilot:
        after(app, 0.005, lambda: done.append("cancelled")).cancel()
        after(app, 0.005, lambda: done.append("not cancelled"))
        await pilot.pause(0.1)
    assert done == ["not cancelled"]


async def test_a_page_about_a_small_window_leaves_where_the_window_has_grown_before_it_came():
    app = Sized()
    async with app.run_test(size=(80, 24)) as pilot:
        app.push_screen(SmallWindowScreen(Size(80, 24)))
        await pilot.pause(0.05)
        assert app.screen is app.listening


@pytest.mark.parametrize(("size", "kept"), [((120, 40), False), ((0, 0), True), (None, True)], ids=str)
def test_exported_sizes_count_only_where_the_terminal_does_not_tell_its_own(monkeypatch, size, kept):
    def told(_descriptor):
        if size is None:
            raise OSError("Inappropriate ioctl for device")
        return os.terminal_size(size)

    monkeypatch.setattr(os, "get_terminal_size", told)
    for name in ("COLUMNS", "LINES"):
        monkeypatch.setenv(name, "80")
    trust_the_terminal()
    assert [name in os.environ for name in ("COLUMNS", "LINES")] == [kept, kept]
