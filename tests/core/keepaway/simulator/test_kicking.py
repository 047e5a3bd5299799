"""Stopping the ball, by hand: me in the origin, facing +x, at rest; the ball ahead of me, straight on the x
axis."""

import math

import numpy as np
import pytest

from core.keepaway.pitch import ANGLE, KICK, KIND, POWER
from core.keepaway.simulator.kicking import freeze_ball

ME = np.zeros(6)


def stopped(gap_m: float, vx: float, vy: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the command that is to stop a ball, and the ball's velocity after it, without noise."""
    command = np.zeros(4)
    freeze_ball(ME, np.array([gap_m, 0.0, vx, vy]), command)
    assert command[KIND] == KICK
    # On the axis a kick loses a quarter of its rate over the 0.7 m of margin around the bodies' 0.385 m.
    accel = 0.027 * (1.0 - 0.25 * (gap_m - 0.385) / 0.7) * command[POWER]
    way = math.radians(command[ANGLE])
    return command, np.array([vx + accel * math.cos(way), vy + accel * math.sin(way)])


def test_a_ball_in_safe_reach_is_stopped_where_it_is():
    command, after = stopped(0.8, 0.0, 1.0)
    # 1 m per cycle by 0.027 (1 - 0.25 * 0.415 / 0.7) = 0.022998 per unit of power: 43.48, sent as 43.
    assert (command[POWER], command[ANGLE]) == (43.0, -90.0)
    assert after == pytest.approx([0.0, 1.0 - 43 * 0.022998], abs=1e-4)


@pytest.mark.parametrize(
    ("speed", "power", "rolls_on"),
    [
        # 0.866 m away the rate is 0.022358: 44.01 of power leave 0.0002 m per cycle, 44.72 leave 0.016, and
        # the ball, at
        # 0.882 m, would be beyond 0.8 * 1.085 = 0.868 m. It is driven to 0.7 * 1.085 = 0.7595 m: (1 + 0.1065)
        # / rate.
        (0.984, 44.0, 0.866),
        (1.0, 49.0, 0.7595),
    ],
)
def test_where_it_would_stop_follows_from_the_kick_as_it_is_sent(speed: float, power: float, rolls_on: float):
    command, after = stopped(0.866, speed, 0.0)
    assert (command[POWER], abs(command[ANGLE])) == (power, 180.0)
    assert 0.866 + after[0] == pytest.approx(rolls_on, abs=0.022)


def test_a_drive_that_is_too_much_for_one_kick_keeps_the_ball_from_passing_by():
    # Stopped with 100 of power it would be left at 1.02 m; the drive to 0.7595 m would take 108.
    command, after = stopped(1.0, 1.0, 1.9)
    assert command[POWER] == 100.0
    # What is left is along the line to me, but for the degree that is cut off.
    assert after[1] == pytest.approx(0.0, abs=2.2 * math.radians(1.0))
    assert after[0] == pytest.approx(1.0 - math.sqrt(2.107**2 - 1.9**2), abs=0.04)
