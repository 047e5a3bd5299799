"""Clocks."""

import time

import pytest

from core.numerics.clock import ManualClock, MonotonicClock, seconds, wall_time_utc


def test_the_monotonic_clock_is_the_one_key_times_come_from():
    before = time.monotonic()
    now_s = seconds(MonotonicClock().now_ns())
    assert before <= now_s <= time.monotonic()


def test_a_manual_clock_moves_only_when_told_to():
    clock = ManualClock(5)
    assert clock.now_ns() == 5
    clock.advance_ns(10)
    clock.advance_to_ns(12)  # in its past: it stays
    assert clock.now_ns() == 15


def test_a_manual_clock_refuses_to_go_back():
    with pytest.raises(ValueError, match="cannot go back by 3 ns"):
        ManualClock().advance_ns(-3)


def test_wall_time_is_utc():
    assert wall_time_utc().endswith("+00:00")
