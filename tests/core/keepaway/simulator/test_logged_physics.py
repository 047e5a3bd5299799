"""Motion replayed from the reference server's logs: each logged cycle follows from the one before.

Logged positions have 4 decimals, so a velocity is known to 5e-5 and a displacement to 1e-4.
"""

import csv
import gzip
from itertools import pairwise

import numpy as np
import pytest

from core.keepaway.pitch import (
    BALL_ACCEL_MAX,
    BALL_DECAY,
    BALL_NOISE,
    BALL_SPEED_MAX,
    PLAYER_ACCEL_MAX,
    PLAYER_DECAY,
    PLAYER_NOISE,
    PLAYER_SPEED_MAX,
    KeepawayConfig,
)
from core.keepaway.simulator.match import referee
from core.keepaway.simulator.motion import collide, move_object
from core.numerics.streams import stream
from tests.data_folder import data_files

LOGS = data_files("keepaway", pattern="*_traj.csv.gz")
ROWS = 15_000
ROUNDING = 1.5e-4
COLLIDED = 0x400 | 0x800


@pytest.fixture(scope="module", params=LOGS, ids=lambda path: path.name.split("_traj")[0])
def log(request):
    if not LOGS:
        pytest.skip("no logged trajectories: set ARL_DATA")
    with gzip.open(request.param, "rt") as lines:
        names = next(csv.reader(lines))
        rows = np.loadtxt((line for _, line in zip(range(ROWS), lines, strict=False)), delimiter=",")
    column = {name: rows[:, k] for k, name in enumerate(names)}
    follows = (np.diff(rows[:, 0]) == 0) & (np.diff(rows[:, 1]) == 1)
    for name in [n for n in names if n.endswith("_x")]:  # put back from a dropped ball
        step = np.hypot(np.diff(column[name]), np.diff(column[name[:-1] + "y"]))
        follows &= step < 1.2 * PLAYER_SPEED_MAX
    return column, np.flatnonzero(follows)


def players_of(column):
    return sorted({name.split("_")[0] for name in column if name.endswith("_x")})


def collided(column, player, rows):
    return (column[f"{player}_state"][rows].astype(int) & COLLIDED) != 0


def free(column, after, player):
    """Return the rows in whose next cycle the player neither dashes nor collides."""
    still = column[f"{player}_dashes"][after + 1] == column[f"{player}_dashes"][after]
    return after[still & ~collided(column, player, after + 1)]


def moved(column, rows, name, limits, velocity):
    """Move logged objects by one cycle with the noise taken away; return the distance to the log."""
    x, y = (column["bx"], column["by"]) if name == "b" else (column[f"{name}_x"], column[f"{name}_y"])
    gaps = np.empty(len(rows))
    speeds = np.hypot(*velocity)[rows]
    for k, row in enumerate(rows):
        state = np.array([x[row], y[row], velocity[0][row], velocity[1][row]])
        move_object(state, np.zeros(2), *limits[:2], 0.0, limits[3], stream(1, "movement"))
        gaps[k] = np.hypot(state[0] - x[row + 1], state[1] - y[row + 1])
    return gaps, speeds


def test_a_coasting_player_moves_by_its_velocity_within_the_noise(log):
    column, after = log
    for player in players_of(column):
        rows = free(column, after, player)[:300]
        velocity = (column[f"{player}_vx"], column[f"{player}_vy"])
        limits = (PLAYER_ACCEL_MAX, PLAYER_SPEED_MAX, PLAYER_NOISE, PLAYER_DECAY)
        gaps, speeds = moved(column, rows, player, limits, velocity)
        assert (gaps <= PLAYER_NOISE * speeds + ROUNDING).all()


def test_a_free_ball_moves_by_its_velocity_within_the_noise(log):
    column, after = log
    kicks = sum(np.diff(column[f"{p}_kicks"])[after] for p in players_of(column))
    bumped = np.zeros(len(after), bool)
    for player in players_of(column):
        bumped |= (column[f"{player}_state"][after + 1].astype(int) & COLLIDED) != 0
    at_rest_by_drop = (column["bvx"][after + 1] == 0) & (column["bvy"][after + 1] == 0)
    rows = after[(kicks == 0) & ~bumped & ~at_rest_by_drop][:600]
    limits = (BALL_ACCEL_MAX, BALL_SPEED_MAX, BALL_NOISE, BALL_DECAY)
    gaps, speeds = moved(column, rows, "b", limits, (column["bvx"], column["bvy"]))
    assert (gaps <= BALL_NOISE * speeds + ROUNDING).all()


def test_velocities_decay_by_their_factors(log):
    column, after = log
    for player in players_of(column):
        rows = after[~collided(column, player, after + 1)]
        dx, dy = np.diff(column[f"{player}_x"])[rows], np.diff(column[f"{player}_y"])[rows]
        gap = np.hypot(
            column[f"{player}_vx"][rows + 1] - PLAYER_DECAY * dx,
            column[f"{player}_vy"][rows + 1] - PLAYER_DECAY * dy,
        )
        assert (gap <= ROUNDING).all()


def test_dashes_accelerate_along_the_body_by_0_006_per_power(log):
    column, after = log
    for player in players_of(column):
        dashed = np.diff(column[f"{player}_dashes"])[after] == 1
        rows = after[dashed & ~collided(column, player, after + 1)]
        body = np.radians(column[f"{player}_body"][rows])
        before = np.array([column[f"{player}_vx"][rows], column[f"{player}_vy"][rows]])
        moved_by = np.array([np.diff(column[f"{player}_x"])[rows], np.diff(column[f"{player}_y"])[rows]])
        push = moved_by - before
        along = push[0] * np.cos(body) + push[1] * np.sin(body)
        across = push[1] * np.cos(body) - push[0] * np.sin(body)
        noise = PLAYER_NOISE * (np.hypot(*before) + np.abs(along)) / (1 - PLAYER_NOISE)
        assert (np.abs(along) <= 0.6 + noise + ROUNDING).all()
        assert (np.abs(across) <= noise + ROUNDING).all()


def test_collisions_leave_a_tenth_of_the_velocity_reversed(log):
    column, after = log
    n_checked = 0
    names = players_of(column)
    for row in after:
        hit = [p for p in names if int(column[f"{p}_state"][row + 1]) & 0x800]
        if len(hit) != 2 or any(int(column[f"{p}_state"][row + 1]) & 0x400 for p in names):
            continue
        if any(column[f"{p}_dashes"][row + 1] > column[f"{p}_dashes"][row] for p in hit):
            continue
        players = np.zeros((2, 6))
        for k, p in enumerate(hit):
            v = np.array([column[f"{p}_vx"][row], column[f"{p}_vy"][row]])
            players[k, :4] = column[f"{p}_x"][row] + v[0], column[f"{p}_y"][row] + v[1], *(0.4 * v)
        ball = np.full(4, 99.0)
        hit_out = np.zeros(3, bool)
        collide(ball, players, np.zeros((3, 3)), hit_out)
        if not hit_out[1]:  # the overlap came from noise alone
            continue
        for k, p in enumerate(hit):
            speed = np.hypot(column[f"{p}_vx"][row], column[f"{p}_vy"][row])
            place = np.hypot(
                players[k, 0] - column[f"{p}_x"][row + 1], players[k, 1] - column[f"{p}_y"][row + 1]
            )
            assert place <= 2 * PLAYER_NOISE * 0.45 + ROUNDING
            assert np.hypot(column[f"{p}_vx"][row + 1], column[f"{p}_vy"][row + 1]) <= 0.05 * speed + 2e-4
        n_checked += 1
    assert n_checked > 0


def test_the_referee_ends_logged_episodes_where_the_log_does(log):
    column, _ = log
    names = players_of(column)
    keepers = [p for p in names if p.startswith("K")]
    order = keepers + [p for p in names if p.startswith("T")]
    rules = KeepawayConfig(len(keepers), len(order) - len(keepers)).rules()
    if np.abs(column["bx"]).max() > rules.half_length:
        pytest.skip("another region size")
    players = np.zeros((len(order), 6))
    status = np.zeros(5, np.int64)
    n_agree = n_episodes = 0
    starts = np.flatnonzero(np.diff(column["episode"], prepend=0))
    for start, stop in pairwise(starts):
        status[:] = 0
        early = False
        # The state at an episode's end is not logged: that row shows the next reset.
        for row in range(start + 1, stop):
            for k, p in enumerate(order):
                players[k, :2] = column[f"{p}_x"][row], column[f"{p}_y"][row]
            ball = np.array([column["bx"][row], column["by"][row], 0.0, 0.0])
            referee(ball, players, status, rules)
            early |= status[3] != 0
        taken_next = status[2] >= 4
        near_edge = max(abs(column["bx"][stop - 1]), abs(column["by"][stop - 1])) > rules.half_length - 3
        n_agree += not early and (taken_next or near_edge)
        n_episodes += 1
    assert n_episodes > 0
    assert n_agree == n_episodes
