"""What a screen shows of a game of Keepaway: pictures of the pitch, and pictures between two of them.

Everything here is immutable and made of plain numbers, so that it can be sent to another process; no compiled
code is imported. Places in metres from the centre (x right, y down as in the soccer server), angles in
degrees from x towards y.
"""

import math

import msgspec

from core.keepaway.pitch import BALL_SPEED_MAX, CYCLE_S, END_REASONS, NO_PLAYER, ONGOING, PLAYER_SPEED_MAX
from core.plugins import View

Place = tuple[float, float]
"""x and y in metres."""
SLACK = 2.0
"""A player who moves further than this many times the top speed in a cycle was put elsewhere, and does not
slide."""


class PlayerView(msgspec.Struct, frozen=True, array_like=True):
    """Where a player is and where it faces."""

    x_m: float
    y_m: float
    body_deg: float
    """In (-180, 180]."""


class PitchFrame(msgspec.Struct, View, frozen=True, kw_only=True, array_like=True, tag="keepaway"):
    """One picture of a game, at the end of a cycle or between two."""

    length_m: float
    """Extent of the region along x."""
    width_m: float
    """Extent of the region along y."""
    n_keepers: int
    players: tuple[PlayerView, ...]
    """Keepers first."""
    ball: Place
    trail: tuple[Place, ...] = ()
    """Where the ball was in the cycles before, oldest first."""
    episode: int = 1
    """From 1."""
    cycle: int = 0
    """Whole cycles since the episode started."""
    time_s: float = 0.0
    """Simulated time since the episode started, however fast it is shown."""
    holder: int = NO_PLAYER
    """The player who can kick the ball, the nearest one where several can."""
    decider: int = NO_PLAYER
    """The keeper whose option is on screen; nobody before the first decision."""
    target: int = NO_PLAYER
    """The keeper it passes to; nobody while it holds the ball."""
    ended: int = ONGOING
    """ONGOING, OUT or TAKEN (`core.keepaway.pitch`)."""

    def __post_init__(self) -> None:
        if not 0 < self.n_keepers <= len(self.players):
            raise ValueError(
                f"a picture has keepers first, then takers: {self.n_keepers} keepers of {len(self.players)} "
                f"players"
            )

    def name(self, player: int) -> str:
        """Return K1, K2, ... for keepers and T1, ... for takers."""
        return f"K{player + 1}" if player < self.n_keepers else f"T{player - self.n_keepers + 1}"

    @property
    def taken(self) -> bool:
        """Whether a taker can kick the ball and no keeper is nearer to it."""
        return self.holder >= self.n_keepers

    @property
    def passing(self) -> bool:
        """Whether a pass is being played and no taker has the ball."""
        return self.target != NO_PLAYER and self.ended == ONGOING and not self.taken

    def caption(self) -> str:
        """Say in a few words what is going on."""
        if self.ended != ONGOING:
            return f"Ball {END_REASONS[self.ended]} after {self.time_s:.1f} s"
        if self.passing:
            return f"{self.name(self.decider)} passes to {self.name(self.target)}"
        if self.holder == NO_PLAYER:
            return "Ball is free"
        return f"{self.name(self.holder)} has the ball"


def between(before: PitchFrame, after: PitchFrame, fraction: float) -> PitchFrame:
    """Return the picture at `fraction` of the way from one to a later one of the same episode.

    Places move in a straight line and angles turn the short way; all else, and with it the option on screen,
    stays that of `before` until the fraction is 1. Nothing slides over a reset: what has been put elsewhere
    stays until then.

    Args:
        before: a picture.
        after: usually of the next cycle.
        fraction: 0 gives `before`, 1 gives `after`; what lies outside counts as the nearer end.
    """
    if fraction >= 1.0:
        return after
    n_cycles = after.cycle - before.cycle
    if fraction <= 0.0 or before.episode != after.episode or n_cycles <= 0:
        return before
    stride = SLACK * n_cycles
    players = tuple(
        _player_between(p, q, fraction) if _distance(p, q) <= stride * PLAYER_SPEED_MAX else p
        for p, q in zip(before.players, after.players, strict=True)
    )
    (ball_x, ball_y), (next_x, next_y) = before.ball, after.ball
    rolls = math.hypot(next_x - ball_x, next_y - ball_y) <= stride * BALL_SPEED_MAX
    moved = (ball_x + fraction * (next_x - ball_x), ball_y + fraction * (next_y - ball_y))
    return msgspec.structs.replace(
        before,
        players=players,
        ball=moved if rolls else before.ball,
        trail=(*before.trail, before.ball) if rolls else before.trail,
        time_s=before.time_s + fraction * n_cycles * CYCLE_S,
    )


def _distance(p: PlayerView, q: PlayerView) -> float:
    return math.hypot(q.x_m - p.x_m, q.y_m - p.y_m)


def _player_between(p: PlayerView, q: PlayerView, fraction: float) -> PlayerView:
    return PlayerView(
        p.x_m + fraction * (q.x_m - p.x_m),
        p.y_m + fraction * (q.y_m - p.y_m),
        _wrap(p.body_deg + fraction * _wrap(q.body_deg - p.body_deg)),
    )


def _wrap(angle_deg: float) -> float:
    """Return the same direction in (-180, 180]."""
    return 180.0 - (180.0 - angle_deg) % 360.0
