"""The pitch: physical constants, the size of the game, and the columns of the arrays that hold its state.

Sources: RoboCup soccer server 15.2.2 (defaults) in keepaway mode; UT Austin keepaway players 0.6 for the
numbers of the players' own skills. Lengths in metres, speeds in metres per cycle, angles in degrees, one
cycle = 100 ms.
"""

from typing import Annotated, Final, NamedTuple

import msgspec

from core.configuration.fields import number
from core.plugins import DomainConfig

CYCLE_NS: Final = 100_000_000
"""Duration of one cycle in nanoseconds."""
CYCLE_S: Final = 0.1
NO_PLAYER: Final = -1
"""In place of a player's number."""
SESSION_CYCLE_LIMIT: Final = 36_000
"""Longest episode of sessions and their experiments, cycles (an hour): a ball that is never lost would never
end."""
AUTOPLAY_CYCLE_LIMIT: Final = 1_000_000
"""The same where benchmark policies or Sarsa play alone, cycles (28 hours)."""
"""Duration of one cycle in seconds."""
CYCLES_PER_S: Final = 10

# Columns of the state arrays. A ball is (X, Y, VX, VY); a player adds BODY and NECK.
X: Final = 0
Y: Final = 1
VX: Final = 2
VY: Final = 3
BODY: Final = 4
"""Global direction of the body, degrees in (-180, 180]."""
NECK: Final = 5
"""Direction of the neck relative to the body, degrees in [-90, 90]."""
BALL_COLUMNS: Final = 4
PLAYER_COLUMNS: Final = 6

# Columns of a command: what a player asks for in one cycle.
KIND: Final = 0
POWER: Final = 1
ANGLE: Final = 2
NECK_TURN: Final = 3
COMMAND_COLUMNS: Final = 4
NOTHING: Final = 0.0
DASH: Final = 1.0
TURN: Final = 2.0
KICK: Final = 3.0

# Bodies.
PLAYER_RADIUS: Final = 0.3
BALL_RADIUS: Final = 0.085
TOUCH_DISTANCE: Final = PLAYER_RADIUS + BALL_RADIUS
"""Centre distance at which player and ball touch."""
KICK_MARGIN: Final = 0.7
KICK_DISTANCE: Final = TOUCH_DISTANCE + KICK_MARGIN
"""Centre distance below which a player can kick the ball."""

# Players.
PLAYER_DECAY: Final = 0.4
PLAYER_NOISE: Final = 0.1
PLAYER_SPEED_MAX: Final = 1.05
PLAYER_ACCEL_MAX: Final = 1.0
DASH_RATE: Final = 0.006
"""Acceleration per unit of dash power, forwards and backwards. (Server 15's back_dash_rate 0.6 does not act
in the reference runs: their logs show backward dashes of full strength.)"""
MAX_POWER: Final = 100.0
INERTIA: Final = 5.0
TURN_NOISE: Final = 0.1
NECK_MAX_DEG: Final = 90.0

# Ball.
BALL_DECAY: Final = 0.94
BALL_NOISE: Final = 0.05
BALL_SPEED_MAX: Final = 3.0
BALL_ACCEL_MAX: Final = 2.7
KICK_RATE: Final = 0.027
"""Acceleration per unit of kick power with the ball straight ahead and touching."""
KICK_NOISE: Final = 0.1

# Referee and resets.
TAKE_CYCLES: Final = 4
"""Counted cycles of taker possession after which the episode ends."""
CORNER_BOX: Final = 3.0
BALL_INSET: Final = 4.0
STUCK_AREA: Final = 3.0
"""The ball is stuck while it stays this near to one place."""
STUCK_CYCLES: Final = 100
"""Cycles after which a stuck ball is dropped."""
DROP_DISTANCE: Final = 9.15 + PLAYER_RADIUS
"""Distance to which players are put back from a dropped ball."""

ONGOING: Final = 0
OUT: Final = 1
TAKEN: Final = 2
END_REASONS: Final = ("ongoing", "out", "taken")
"""Names of the values of an episode's status."""


class Rules(NamedTuple):
    """The size of the game and how players see it: what kernels need of `KeepawayConfig`."""

    n_keepers: int
    n_takers: int
    half_length: float
    half_width: float
    exact_state: bool
    """Players know positions, velocities and angles exactly in every cycle."""
    view_angle: float
    """Width of the field of view in degrees; 360 sees all round."""
    quantise: bool
    """Seen distances, directions and their changes are rounded as the server does."""
    fixed_phases: bool
    """When players see does not change from episode to episode."""


SeePhase = Annotated[int, number(ge=0, le=2)]


class KeepawayConfig(msgspec.Struct, DomainConfig, frozen=True, forbid_unknown_fields=True, tag="keepaway"):
    """A Keepaway task; the defaults are the paper's (section 3.3): 3v2 on 20 m x 20 m."""

    n_keepers: Annotated[int, number("keepers", ge=2, le=11)] = 3
    """Keepers: the team that keeps the ball (section 3.3: 3)."""
    n_takers: Annotated[int, number("takers", ge=1, le=11)] = 2
    """Takers: the team that wants the ball (section 3.3: 2)."""
    length_m: Annotated[float, number("metres", ge=10, le=200, usual=(10, 120))] = 20.0
    """Extent of the region along x."""
    width_m: Annotated[float, number("metres", ge=10, le=200, usual=(10, 120))] = 20.0
    """Extent of the region along y."""
    exact_state: bool = False
    """True: every player knows the exact state in every cycle (the server's `fullstate`)."""
    view_angle_deg: Annotated[float, number("degrees", gt=0, le=360)] = 360.0
    """Field of view when the state is not exact: 360 (the reference's default) or 90 (the server's)."""
    quantise: bool = True
    """False: what is seen is seen exactly, but still only in two of three cycles."""
    see_phases: tuple[SeePhase, ...] | None = None
    """Of each player's visual messages (0, 1 or 2, keepers first), kept over episodes; None draws them per
    episode."""

    def __post_init__(self) -> None:
        if not 2 <= self.n_keepers <= 11 or not 1 <= self.n_takers <= 11:
            raise ValueError(
                f"need 2..11 keepers and 1..11 takers, got {self.n_keepers} keepers and {self.n_takers} "
                f"takers"
            )
        if min(self.length_m, self.width_m) < 4 * CORNER_BOX - 2:
            raise ValueError(
                f"a region needs at least 10 m x 10 m for its corner boxes, got {self.length_m} x "
                f"{self.width_m}"
            )
        if not 0 < self.view_angle_deg <= 360:
            raise ValueError(f"a field of view is in (0, 360] degrees, got {self.view_angle_deg}")
        phases = self.see_phases
        if phases is not None and (len(phases) != self.n_players or not set(phases) <= {0, 1, 2}):
            raise ValueError(f"need {self.n_players} phases of 0, 1 or 2, got {phases and list(phases)}")

    @property
    def n_players(self) -> int:
        """Keepers and takers together; keepers have the lower indices."""
        return self.n_keepers + self.n_takers

    @property
    def n_actions(self) -> int:
        """Hold, and a pass to each of the other keepers."""
        return self.n_keepers

    def rules(self) -> Rules:
        """Return the kernels' form of this configuration."""
        return Rules(
            int(self.n_keepers),
            int(self.n_takers),
            float(self.length_m) / 2,
            float(self.width_m) / 2,
            bool(self.exact_state),
            float(self.view_angle_deg),
            bool(self.quantise),
            self.see_phases is not None,
        )
