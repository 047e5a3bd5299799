"""Pictures of the pitch that several tests draw."""

import msgspec

from core.keepaway.picture import PitchFrame, PlayerView

PASSING = PitchFrame(
    length_m=20.0,
    width_m=20.0,
    n_keepers=3,
    players=(
        PlayerView(-6.0, -5.0, 30.0),
        PlayerView(8.0, -7.0, 180.0),
        PlayerView(7.0, 8.0, -100.0),
        PlayerView(-4.0, 0.0, -70.0),
        PlayerView(0.0, 4.0, -45.0),
    ),
    ball=(-2.0, -5.4),
    trail=((-5.4, -4.8), (-5.0, -4.9), (-4.2, -5.0), (-3.4, -5.1), (-2.6, -5.3)),
    episode=3,
    cycle=70,
    time_s=7.0,
    decider=0,
    target=1,
)
"""K1 passes to K2; the ball is on its way."""
HOLDING = msgspec.structs.replace(PASSING, ball=(-5.5, -4.4), trail=(), holder=0, target=-1)
"""K1 holds the ball."""
