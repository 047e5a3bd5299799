"""Compiled credit against `core.feedback.credit`, and the incomplete gamma function against scipy's."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import gammainc

from core.feedback.compiled_credit import credit_rule, gamma_mass, share_out
from core.feedback.credit import STILL_SHOWN_NS, credit
from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay

DELAYS = [
    GammaDelay(),
    GammaDelay(0.7, 1.3),
    GammaDelay(40.0, 0.02, 0.25),
    UniformDelay(),
    PreviousStep(),
    CurrentStep(),
]


@given(st.floats(0.05, 200.0), st.floats(0.0, 500.0))
@settings(max_examples=300)
def test_the_incomplete_gamma_function_is_scipys(shape, x):
    assert gamma_mass(shape, math.lgamma(shape), x) == pytest.approx(gammainc(shape, x), rel=1e-10, abs=1e-13)


def test_no_delay_is_shorter_than_the_offset():
    assert gamma_mass(2.5, math.lgamma(2.5), -0.1) == 0.0


@given(
    st.sampled_from(DELAYS),
    st.lists(st.tuples(st.integers(0, 900), st.integers(0, 300)), min_size=0, max_size=25),
    st.booleans(),
    st.integers(0, 3000),
)
@settings(max_examples=300)
def test_shares_are_those_of_the_assigner(delay, pairs, still_shown, later_ms):
    # Each pair: how long a step is shown, and the gap after it, in ms; 0 for two decisions at once.
    shown, hidden, now = [], [], 0
    for long_ms, gap_ms in pairs:
        shown.append(now * 1_000_000)
        now += long_ms
        hidden.append(now * 1_000_000)
        now += gap_ms if gap_ms > 150 else 0
    if still_shown and hidden:
        hidden[-1] = STILL_SHOWN_NS
    press_ns = (now + later_ms) * 1_000_000 + 123
    expected = credit(press_ns, np.array(shown, np.int64), np.array(hidden, np.int64), delay)
    room = 32
    ring = [np.zeros(room, np.int64), np.zeros(room, np.int64), np.full(room, 9.9)]
    for array, values in zip(ring, (shown, hidden), strict=False):
        array[: len(values)] = values
    first, before_first, in_gaps = share_out(
        credit_rule(delay), press_ns, ring[0], ring[1], len(shown), ring[2]
    )
    ours = np.zeros(len(shown))
    ours[first:] = ring[2][first : len(shown)]
    np.testing.assert_allclose(ours, expected.shares, rtol=0, atol=1e-12)
    assert before_first == pytest.approx(expected.before_first, abs=1e-12)
    assert in_gaps == pytest.approx(expected.in_gaps, abs=1e-12)
    assert ours.sum() + before_first + in_gaps == pytest.approx(1.0)


def test_a_ring_that_has_gone_round_gives_the_same_shares_as_a_long_list():
    delay, room, n_steps = GammaDelay(), 64, 1000
    shown = np.arange(n_steps, dtype=np.int64) * 100_000_000
    hidden = shown + 100_000_000
    press_ns = int(hidden[-1]) + 40_000_000
    ring = np.zeros(room, np.int64), np.zeros(room, np.int64), np.zeros(room)
    for step in range(n_steps):
        ring[0][step % room], ring[1][step % room] = shown[step], hidden[step]
    first, _, _ = share_out(credit_rule(delay), press_ns, *ring[:2], n_steps, ring[2])
    expected = credit(press_ns, shown, hidden, delay).shares
    assert expected[:first].sum() == 0.0
    ours = [ring[2][step % room] for step in range(first, n_steps)]
    np.testing.assert_allclose(ours, expected[first:], atol=1e-12)
