"""Credit of a press: by hand, against numeric integration, and what must always hold."""

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import stats

from core.feedback.credit import (
    HORIZON_MASS,
    STILL_SHOWN_NS,
    Credit,
    CurrentStep,
    Delay,
    GammaDelay,
    PreviousStep,
    UniformDelay,
    credit,
    describe,
    parse_delay,
)
from core.numerics.clock import NS_PER_S
from tests.naive.feedback import credit_by_integration, gamma_density, uniform_density

DELAYS: list[Delay] = [
    GammaDelay(),
    GammaDelay(2.0, 0.28, 0.15),
    UniformDelay(),
    PreviousStep(),
    CurrentStep(),
]


def ns(*times_s: float) -> NDArray[np.int64]:
    return np.array([round(time_s * NS_PER_S) for time_s in times_s], dtype=np.int64)


def at_s(press_s: float, shown: NDArray[np.int64], hidden: NDArray[np.int64], delay: Delay) -> Credit:
    return credit(round(press_s * NS_PER_S), shown, hidden, delay)


def total(result: Credit) -> float:
    return float(result.shares.sum()) + result.before_first + result.in_gaps


def test_uniform_credit_by_hand() -> None:
    # Press at 1.0, delays 0.2-0.8: the window is [0.2, 0.8]. Steps [0, 0.35], [0.35, 0.6], [0.7, still].
    # 0.15/0.6 = 0.25, 0.25/0.6 = 0.41667, 0.1/0.6 = 0.16667, and the gap [0.6, 0.7] has 0.1/0.6.
    result = at_s(1.0, ns(0, 0.35, 0.7), np.array([*ns(0.35, 0.6), STILL_SHOWN_NS]), UniformDelay())
    assert result.shares == pytest.approx([0.25, 0.25 / 0.6, 0.1 / 0.6])
    assert result.in_gaps == pytest.approx(0.1 / 0.6)
    assert result.before_first == 0.0


def test_credit_before_the_first_step_is_counted_and_given_to_no_step() -> None:
    # Press at 1.0, window [0.2, 0.8], first step at 0.5: half the window lies before.
    result = at_s(1.0, ns(0.5), np.array([STILL_SHOWN_NS]), UniformDelay())
    assert result.before_first == pytest.approx(0.5)
    assert result.shares == pytest.approx([0.5])
    assert at_s(1.0, ns(), ns(), UniformDelay()).before_first == 1.0


def test_gamma_credit_by_hand() -> None:
    # Shape 1 is the exponential density: with scale 0.5 and steps [0, 0.5], [0.5, 1.0] before a press at 1.0
    # the shares are e^-1 - e^-2 = 0.2325 and 1 - e^-1 = 0.6321; e^-2 = 0.1353 lies before.
    result = at_s(1.0, ns(0, 0.5), ns(0.5, 1.0), GammaDelay(1.0, 0.5))
    assert result.shares == pytest.approx([0.23254, 0.63212], abs=1e-5)
    assert result.before_first == pytest.approx(0.13534, abs=1e-5)
    # An offset of 0.5 s: nothing on screen in the last half second can have been the reason.
    late = at_s(1.0, ns(0, 0.5), ns(0.5, 1.0), GammaDelay(1.0, 0.5, 0.5))
    assert late.shares == pytest.approx([0.63212, 0.0], abs=1e-5)


def test_the_papers_gamma_is_shape_and_scale_with_mean_075_and_mode_045() -> None:
    delay = GammaDelay()
    grid_s = np.linspace(0, 6, 60_001)
    mass = np.diff(delay.cdf(grid_s))
    centres_s = (grid_s[1:] + grid_s[:-1]) / 2
    assert mass @ centres_s == pytest.approx(2.5 * 0.3, abs=1e-4)
    assert centres_s[mass.argmax()] == pytest.approx(1.5 * 0.3, abs=1e-3)
    # P(0.2 < delay < 0.8), computed with scipy's own distribution
    assert delay.cdf(0.8) - delay.cdf(0.2) == pytest.approx(0.555, abs=5e-4)


def test_gamma_agrees_with_scipys_distribution() -> None:
    delays_s = np.linspace(-1, 5, 200)
    assert GammaDelay(3.1, 0.2, 0.15).cdf(delays_s) == pytest.approx(
        stats.gamma(3.1, loc=0.15, scale=0.2).cdf(delays_s), abs=1e-14
    )


def test_mass_beyond_the_horizon_is_a_millionth() -> None:
    for delay in (GammaDelay(), GammaDelay(0.7, 2.0, 0.3)):
        assert 1 - delay.cdf(delay.horizon_s) == pytest.approx(HORIZON_MASS, rel=1e-6)
    assert UniformDelay(0.2, 0.8).horizon_s == 0.8


def test_previous_step_gets_all_credit() -> None:
    shown, hidden = ns(0, 1, 2), np.array([*ns(1, 2), STILL_SHOWN_NS])
    assert at_s(2.5, shown, hidden, PreviousStep()).shares.tolist() == [0, 1, 0]
    assert at_s(1.0, shown, hidden, PreviousStep()).shares.tolist() == [1, 0, 0]
    first = at_s(0.5, shown, hidden, PreviousStep())
    assert (first.shares.tolist(), first.before_first) == ([0, 0, 0], 1.0)


def test_after_the_last_step_has_gone_the_previous_step_is_the_last_one() -> None:
    assert at_s(3.0, ns(0, 1), ns(1, 2), PreviousStep()).shares.tolist() == [0, 1]


def test_a_pause_does_not_make_a_step_its_own_predecessor() -> None:
    shown, hidden, steps = ns(0, 1, 5), np.array([*ns(1, 2), STILL_SHOWN_NS]), np.array([7, 8, 8])
    result = credit(6 * NS_PER_S, shown, hidden, PreviousStep(), steps=steps)
    assert result.shares.tolist() == [1, 0, 0]


def test_current_step_gets_all_credit_and_a_press_at_an_empty_screen_falls_into_a_gap() -> None:
    shown, hidden = ns(0, 2), ns(1, 3)
    assert at_s(2.0, shown, hidden, CurrentStep()).shares.tolist() == [0, 1]
    assert at_s(1.5, shown, hidden, CurrentStep()).in_gaps == 1.0
    assert at_s(-1.0, shown, hidden, CurrentStep()).before_first == 1.0


@pytest.mark.parametrize("press_s", [0.3, 1.0, 1.9, 3.2])
def test_credit_agrees_with_numeric_integration(press_s: float) -> None:
    intervals = [(0.0, 0.4), (0.5, 1.1), (1.1, 1.3), (1.8, 2.6)]
    shown, hidden = ns(*(a for a, _ in intervals)), ns(*(b for _, b in intervals))
    # The midpoint rule with 4000 points is off by less than 1e-4 at the uniform density's edges.
    gamma = credit_by_integration(press_s, intervals, lambda x: gamma_density(x, 2.5, 0.3))
    assert at_s(press_s, shown, hidden, GammaDelay()).shares == pytest.approx(gamma, abs=2e-6)
    uniform = credit_by_integration(press_s, intervals, lambda x: uniform_density(x, 0.2, 0.8))
    assert at_s(press_s, shown, hidden, UniformDelay()).shares == pytest.approx(uniform, abs=5e-4)


@st.composite
def screens(draw: st.DrawFn) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """Intervals on screen, with and without gaps, and a press anywhere."""
    pieces = draw(st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 2000)), max_size=12))
    edges_ms = np.cumsum([part for piece in pieces for part in piece], dtype=np.int64)
    hidden = edges_ms[1::2] * 1_000_000
    if len(hidden) and draw(st.booleans()):
        hidden[-1] = STILL_SHOWN_NS
    return edges_ms[::2] * 1_000_000, hidden, draw(st.integers(-1000, 30_000)) * 1_000_000


@given(screens(), st.sampled_from(DELAYS))
def test_nothing_is_lost_and_nothing_is_given_twice(
    screen: tuple[NDArray[np.int64], NDArray[np.int64], int], delay: Delay
) -> None:
    shown, hidden, press_ns = screen
    result = credit(press_ns, shown, hidden, delay)
    assert total(result) == pytest.approx(1.0, abs=1e-12)
    assert (result.shares >= 0).all()
    assert result.before_first >= 0
    assert result.in_gaps >= -1e-15


@given(screens(), st.sampled_from(DELAYS))
def test_steps_after_the_press_get_no_credit(
    screen: tuple[NDArray[np.int64], NDArray[np.int64], int], delay: Delay
) -> None:
    shown, hidden, press_ns = screen
    assert not credit(press_ns, shown, hidden, delay).shares[shown > press_ns].any()


@given(screens(), st.sampled_from(DELAYS), st.integers(-(10**18), 10**18))
def test_the_clocks_zero_does_not_matter(
    screen: tuple[NDArray[np.int64], NDArray[np.int64], int], delay: Delay, shift_ns: int
) -> None:
    shown, hidden, press_ns = screen
    moved_hidden = np.where(hidden == STILL_SHOWN_NS, hidden, np.minimum(hidden, 10**14) + shift_ns)
    one, other = (
        credit(press_ns, shown, hidden, delay),
        credit(press_ns + shift_ns, shown + shift_ns, moved_hidden, delay),
    )
    assert one.shares.tolist() == other.shares.tolist()
    assert (one.before_first, one.in_gaps) == (other.before_first, other.in_gaps)


def test_a_step_cut_in_two_gets_the_same_credit_in_sum() -> None:
    whole = at_s(2.0, ns(0.5), ns(1.9), GammaDelay()).shares
    halves = at_s(2.0, ns(0.5, 1.2), ns(1.2, 1.9), GammaDelay()).shares
    assert halves.sum() == pytest.approx(whole[0], abs=1e-14)


def test_intervals_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match="follow each other"):
        at_s(1.0, ns(0, 0.5), ns(0.7, 1.0), UniformDelay())
    with pytest.raises(ValueError, match="one end per beginning"):
        at_s(1.0, ns(0, 0.5), ns(0.7), UniformDelay())


@pytest.mark.parametrize(
    "text",
    ["gamma:2.5,0.3", "gamma:2.5,0.3,0.2", "uniform:0.2,0.8", "previous", "current", "gamma:1e-05,1e+22"],
)
def test_parsing_and_describing_are_inverse(text: str) -> None:
    assert describe(parse_delay(text)) == text


@given(st.floats(0.01, 50), st.floats(0.001, 10), st.floats(0, 5))
def test_every_gamma_survives_as_text_and_in_a_recordings_header(
    shape: float, scale_s: float, offset_s: float
) -> None:
    delay = GammaDelay(shape, scale_s, offset_s)
    assert parse_delay(describe(delay)) == delay
    assert msgspec.json.decode(msgspec.json.encode(delay), type=Delay) == delay


def test_a_name_alone_means_the_default() -> None:
    assert parse_delay("gamma") == GammaDelay()
    assert parse_delay(" uniform ") == UniformDelay(0.2, 0.8)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("gauss:1,2", "unknown credit rule 'gauss:1,2'"),
        ("gamma:2.5", "takes 2 or 3 numbers, got 1"),
        ("gamma:2.5,fast", "expected numbers"),
        ("uniform:0.8,0.2", "low_s < high_s"),
        ("gamma:-1,0.3", "shape is > 0"),
        ("gamma:2,0", "scale_s is > 0"),
        ("gamma:2,0.3,-0.1", "offset_s is >= 0"),
        ("gamma:nan,0.3", "shape is > 0"),
        ("previous:1", "takes no numbers"),
        ("", "unknown credit rule"),
    ],
)
def test_a_wrong_rule_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        parse_delay(text)
