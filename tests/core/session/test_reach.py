"""The fraction of a press that reaches its step: by hand, against credit itself, against the issue of a pace,
real delays."""

import csv
from dataclasses import dataclass

import msgspec
import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from core.feedback.credit import credit
from core.feedback.delays import CurrentStep, Delay, GammaDelay, PreviousStep, UniformDelay
from core.feedback.viewing import Watched
from core.keepaway.plugin import KEEPAWAY
from core.numerics.clock import NS_PER_S
from core.session.protocol import Protocol, ScreenConfig
from core.session.reach import fraction_reached, mean_time_s, reach_of
from core.tetris.pace import pictures_per_piece
from core.tetris.plugin import TETRIS
from tests.data_folder import data_folder


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredDelays:
    """The distribution of delays that were measured."""

    delays_s: NDArray[np.float64]
    """In seconds, each > 0, shape (n,) with n >= 1."""

    def cdf(self, delay_s: ArrayLike) -> NDArray[np.float64]:
        """Return the fraction of delays of at most `delay_s` seconds, element by element."""
        ranks = np.searchsorted(np.sort(self.delays_s), np.asarray(delay_s, np.float64), side="right")
        return np.asarray(ranks / len(self.delays_s), dtype=np.float64)

    @property
    def horizon_s(self) -> float:
        """The longest delay, in seconds."""
        return float(self.delays_s.max())


NEEDS_1_S = GammaDelay(8.0, 0.125)
"""A participant who needs 1.0 s on average, give or take 0.35 s."""


def seen(duration_s: float, judged_s: float | None = None, attention: float = 1.0) -> Watched:
    judged_s = duration_s if judged_s is None else judged_s
    return Watched(round(duration_s * NS_PER_S), round(judged_s * NS_PER_S), attention)


def at_tick(tick_ms: int, rule: Delay | None = None) -> Protocol:
    agent = TETRIS.agent
    if rule is not None:
        agent = msgspec.structs.replace(agent, credit=msgspec.structs.replace(agent.credit, delay=rule))
    return msgspec.structs.replace(TETRIS, screen=ScreenConfig(tick_ms=tick_ms), agent=agent)


def test_previous_step_by_hand() -> None:
    # Delays are uniform on [0, 1] s. Step 1 is the last one for 0.4 s, step 2 for the mean of 0.5 s.
    fraction = fraction_reached([seen(0.6), seen(0.4)], PreviousStep(), UniformDelay(0.0, 1.0))
    assert fraction == pytest.approx((0.4 + 0.5) / 2)


def test_step_on_screen_by_hand() -> None:
    # Judged after 0.1 s: there are 0.5 and 0.3 s left; a piece that is judged when it has landed leaves
    # nothing.
    delay = UniformDelay(0.0, 1.0)
    assert fraction_reached([seen(0.6, 0.1), seen(0.4, 0.1)], CurrentStep(), delay) == pytest.approx(0.4)
    assert fraction_reached([seen(0.6), seen(0.4)], CurrentStep(), delay) == 0.0


def test_density_by_hand() -> None:
    # Credit density 1 on [0, 1] s, every press after exactly 0.5 s: a step that was judged when it came on
    # screen and lasts 0.4 s covers the delays 0.1 to 0.5 s; one that is judged at its end covers 0.5 to 0.9
    # s.
    exactly = MeasuredDelays(np.array([0.5]))
    rule = UniformDelay(0.0, 1.0)
    assert fraction_reached([seen(0.4, 0.0)] * 3, rule, exactly) == pytest.approx(0.4, abs=0.003)
    assert fraction_reached([seen(0.4)] * 3, rule, exactly) == pytest.approx(0.4, abs=0.003)
    # One second on screen, judged at the end: delays 0.5 to 1.5 s, of which the density knows half.
    assert fraction_reached([seen(1.0)] * 3, rule, exactly) == pytest.approx(0.5, abs=0.003)


def test_steps_are_weighted_by_how_often_they_are_judged() -> None:
    delay = UniformDelay(0.0, 1.0)
    steps = [seen(0.2, 0.0, 0.25), seen(0.8, 0.0, 0.75)]
    assert fraction_reached(steps, CurrentStep(), delay) == pytest.approx(0.25 * 0.2 + 0.75 * 0.8)
    assert mean_time_s(steps) == pytest.approx(0.25 * 0.2 + 0.75 * 0.8)


def test_steps_without_time_on_screen_are_left_out() -> None:
    delay = UniformDelay(0.0, 1.0)
    steps = [seen(0.6), seen(0.0), seen(0.4)]
    assert fraction_reached(steps, PreviousStep(), delay) == fraction_reached(
        [steps[0], steps[2]], PreviousStep(), delay
    )
    with pytest.raises(ValueError, match="two steps on screen"):
        fraction_reached([seen(0.6), seen(0.0)], PreviousStep(), delay)


@pytest.mark.parametrize("rule", [PreviousStep(), CurrentStep(), GammaDelay(), UniformDelay()])
@pytest.mark.parametrize("judged_s", [0.1, None])
def test_equals_credit_of_every_single_press(rule: Delay, judged_s: float | None) -> None:
    """The slow twin: presses are made at drawn delays and credited by the function that sessions use."""
    rng = np.random.default_rng(3)
    durations_s = rng.uniform(0.1, 1.2, 400)
    hidden_ns = np.round(np.cumsum(durations_s) * NS_PER_S).astype(np.int64)
    shown_ns = np.concatenate([[0], hidden_ns[:-1]])
    delays_s = rng.gamma(2.5, 0.3, 390)
    fractions = []
    for step, delay_s in enumerate(delays_s):
        begins_s = durations_s[step] if judged_s is None else judged_s
        press_ns = int(shown_ns[step] + round((begins_s + delay_s) * NS_PER_S))
        fractions.append(credit(press_ns, shown_ns, hidden_ns, rule).shares[step])
    steps = [seen(duration_s, judged_s) for duration_s in durations_s]
    standard_error = np.std(fractions) / np.sqrt(len(fractions))
    assert fraction_reached(steps, rule, GammaDelay()) == pytest.approx(
        np.mean(fractions), abs=4 * standard_error + 1e-3
    )


def test_a_piece_of_the_default_board_takes_eight_pictures() -> None:
    pictures = pictures_per_piece(TETRIS.domain)  # type: ignore[arg-type]
    assert len(pictures) == 300
    assert np.mean(pictures) == pytest.approx(8.0, abs=0.3)


@pytest.mark.parametrize(
    ("tick_ms", "paper", "needs_1_s"), [(80, 0.49, 0.18), (150, 0.82, 0.71)], ids=["80 ms", "150 ms"]
)
def test_share_of_presses_on_a_piece_at_a_pace(tick_ms: int, paper: float, needs_1_s: float) -> None:
    """At 80 ms a tick (0.65 s a piece) half of the paper's presses come while the right piece is the last
    one."""
    protocol = at_tick(tick_ms)
    assert reach_of(protocol).fraction == pytest.approx(paper, abs=0.015)
    assert reach_of(protocol, NEEDS_1_S).fraction == pytest.approx(needs_1_s, abs=0.015)


def test_a_density_cannot_give_a_landed_piece_more_than_half() -> None:
    """The delay begins when the piece's time on screen ends: what it needs, its density gives to the next
    piece."""
    fractions = [reach_of(at_tick(tick_ms, GammaDelay())).fraction for tick_ms in (80, 150, 400)]
    assert fractions == sorted(fractions)
    assert fractions[0] == pytest.approx(0.35, abs=0.02)
    assert 0.49 < fractions[-1] < 0.5


@pytest.mark.jit
def test_options_of_keepaway() -> None:
    """A pass takes 0.64 s and is credited by the density: a third of a press reaches it, in slow motion
    more."""
    reach = reach_of(msgspec.structs.replace(KEEPAWAY, screen=ScreenConfig(speed=1.0)))
    slow = reach_of(msgspec.structs.replace(KEEPAWAY, screen=ScreenConfig(speed=0.5)))
    assert reach.fraction == pytest.approx(0.34, abs=0.02)
    assert slow.fraction == pytest.approx(0.51, abs=0.02)
    assert slow.step_s == pytest.approx(2 * reach.step_s)
    assert reach.delay == GammaDelay()


def test_real_delays() -> None:
    """5,349 real evaluations, median 1.0 s: 27 % come in time at 80 ms a tick, 60 % at 150 ms, 74 % at 200
    ms."""
    with (data_folder("evaluation_delays") / "charm.csv").open(encoding="utf-8") as file:
        delays = MeasuredDelays(np.array([float(row["delay_s"]) for row in csv.DictReader(file)]))
    assert delays.cdf(1.0) == pytest.approx(0.5, abs=0.01)
    for tick_ms, fraction in ((80, 0.265), (150, 0.60), (200, 0.74)):
        reach = reach_of(at_tick(tick_ms), delays)
        assert reach.fraction == pytest.approx(fraction, abs=0.02)
        assert reach.enough == (tick_ms == 200)
