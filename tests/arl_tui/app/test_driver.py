"""The clock of flushes, with the writing thread played by hand."""

import io
import threading

import pytest

from arl_tui.app.driver import FlushClock, WatchedFile, stamped_driver
from core.numerics.clock import NS_PER_MS, ManualClock


def bench() -> tuple[ManualClock, FlushClock, WatchedFile, io.StringIO]:
    clock = ManualClock()
    flush_clock = FlushClock(clock)
    file = io.StringIO()
    return clock, flush_clock, WatchedFile(file, flush_clock), file


def test_a_mark_is_stamped_when_all_that_was_queued_before_it_has_been_flushed() -> None:
    clock, flush_clock, file, _ = bench()
    flush_clock.queued(3)
    flush_clock.mark(7)
    clock.advance_ns(10)
    file.write("abc")
    assert flush_clock.take() == []
    clock.advance_ns(10)
    file.flush()
    assert flush_clock.take() == [(7, 20)]
    assert flush_clock.take() == []


def test_a_flush_of_earlier_bytes_does_not_stamp_a_later_mark() -> None:
    clock, flush_clock, file, _ = bench()
    flush_clock.queued(2)
    flush_clock.mark(0)
    flush_clock.queued(2)
    flush_clock.mark(1)
    file.write("ab")
    clock.advance_ns(5)
    file.flush()
    assert flush_clock.take() == [(0, 5)]
    file.write("cd")
    clock.advance_ns(5)
    file.flush()
    assert flush_clock.take() == [(1, 10)]


def test_a_mark_that_comes_after_its_flush_gets_the_time_of_that_flush() -> None:
    clock, flush_clock, file, _ = bench()
    flush_clock.queued(2)
    file.write("ab")
    clock.advance_ns(5)
    file.flush()
    clock.advance_ns(50)
    file.flush()  # Nothing new: this is not when the bytes left.
    flush_clock.mark(3)
    assert flush_clock.take() == [(3, 5)]


def test_one_flush_may_bring_several_frames() -> None:
    clock, flush_clock, file, _ = bench()
    for label in range(3):
        flush_clock.queued(1)
        flush_clock.mark(label)
    file.write("abc")
    clock.advance_ns(9)
    file.flush()
    assert flush_clock.take() == [(0, 9), (1, 9), (2, 9)]


class Slow(io.StringIO):
    """A terminal that takes its time: `flush` returns later."""

    def __init__(self, clock: ManualClock, takes_ms: int, *, line_buffering: bool = False) -> None:
        super().__init__()
        self._clock, self._takes_ms, self._by_line = clock, takes_ms, line_buffering

    @property
    def line_buffering(self) -> bool:
        return self._by_line

    def write(self, text: str) -> int:
        if self._by_line and "\n" in text:
            self.flush()
        return super().write(text)

    def flush(self) -> None:
        self._clock.advance_ns(self._takes_ms * NS_PER_MS)


@pytest.mark.parametrize(("takes_ms", "stamped_ms"), [(0, 3), (9, 3), (20, 3), (21, 24), (1500, 1503)])
def test_waiting_for_the_interpreters_lock_does_not_count_waiting_for_the_terminal_does(
    takes_ms: int, stamped_ms: int
) -> None:
    clock = ManualClock()
    flush_clock = FlushClock(clock)
    file = WatchedFile(Slow(clock, takes_ms), flush_clock)
    flush_clock.queued(2)
    flush_clock.mark(1)
    file.write("ab")
    clock.advance_ns(3 * NS_PER_MS)
    file.flush()
    assert flush_clock.take() == [(1, stamped_ms * NS_PER_MS)]


def test_a_file_that_flushes_lines_by_itself_has_flushed_when_it_has_written() -> None:
    clock = ManualClock()
    flush_clock = FlushClock(clock)
    file = WatchedFile(Slow(clock, 2, line_buffering=True), flush_clock)
    flush_clock.queued(7)
    flush_clock.mark(1)
    clock.advance_ns(5)
    file.write("a\nb")
    assert flush_clock.take() == []  # Three of seven characters.
    file.write("c\nde")
    assert flush_clock.take() == [(1, 5 + 2 * NS_PER_MS)]
    flush_clock.queued(1)
    flush_clock.mark(2)
    file.write("f")
    assert flush_clock.take() == []


def test_news_is_passed_on_once_per_stamp_from_either_side() -> None:
    _, flush_clock, file, _ = bench()
    told: list[str] = []
    flush_clock.on_stamp = lambda: told.append(threading.current_thread().name)
    flush_clock.queued(1)
    flush_clock.mark(0)
    file.write("a")
    file.flush()
    flush_clock.mark(1)
    file.flush()
    assert len(told) == 2


def test_what_is_watched_is_written_unchanged() -> None:
    _, _, file, inner = bench()
    assert file.write("größe") == 5
    file.flush()
    assert inner.getvalue() == "größe"
    assert not file.closed


def test_no_stamp_is_lost_while_two_threads_work() -> None:
    flush_clock = FlushClock(ManualClock(1))
    file = WatchedFile(io.StringIO(), flush_clock)
    written = threading.Semaphore(0)

    def write_all() -> None:
        for _ in range(5_000):
            written.acquire()
            file.write("x")
            file.flush()

    writer = threading.Thread(target=write_all)
    writer.start()
    for label in range(5_000):
        flush_clock.queued(1)
        written.release()
        flush_clock.mark(label)
    writer.join()
    assert [label for label, _ in flush_clock.take()] == list(range(5_000))


def test_a_browser_keeps_textuals_own_driver(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setenv("TEXTUAL_DRIVER", "textual.drivers.web_driver:WebDriver")
    assert stamped_driver(FlushClock(ManualClock())) is None
