"""The compiled simulator and the naive twin play the same match, cycle by cycle.

Both add in different orders, so equal means equal to rounding. Collisions enlarge a rounding error up to a
thousandfold, so the twin takes over the simulator's state before every cycle: each cycle is compared, not the
sum.
"""

import numpy as np
import pytest

from core.keepaway.pitch import END_REASONS, KeepawayConfig
from core.keepaway.simulator import match as m
from core.keepaway.simulator.game import step_cycle
from core.keepaway.simulator.match import new_match, open_streams, start_episode
from core.keepaway.simulator.policies import POLICIES
from tests.naive.keepaway import NaiveMatch
from tests.naive.keepaway_things import UNKNOWN

ROUNDING = 1e-9
OPTION_NAMES = ("HoldBall", "PassBall", "GoToBall", "GetOpen", "BlockPass", "SearchBall", "WatchBall")
SETTINGS = {
    "exact": KeepawayConfig(exact_state=True),
    "360": KeepawayConfig(),
    "360 unrounded": KeepawayConfig(quantise=False),
    "90": KeepawayConfig(view_angle_deg=90.0),
    "4v3 on 30 m": KeepawayConfig(4, 3, 30.0, 30.0),
    "5v4 on 35 m, 90": KeepawayConfig(5, 4, 35.0, 35.0, view_angle_deg=90.0),
    "2v1 on 15 m": KeepawayConfig(2, 1, 15.0, 12.0, exact_state=True),
}


def take_over(naive, match):
    """Give the twin the simulator's state: places, beliefs, and what its players remember."""
    for thing, row in zip([naive.ball, *naive.players], [match.ball, *match.players], strict=True):
        put(thing, row)
    for i, mind in enumerate(naive.minds):
        if not naive.config.exact_state:
            put(mind.ball, match.seen_ball[i], match.ball_age[i])
            for j, thing in enumerate(mind.players):
                put(thing, match.seen_players[i, j], match.player_age[i, j])
        mind.meet = complex(*match.meet[i, :2])
    naive.stuck_at = complex(*match.stuck[:2])


def put(thing, row, age=0):
    thing.at, thing.v = complex(row[0], row[1]), complex(row[2], row[3])
    if len(row) > 4:
        thing.body, thing.neck = float(row[4]), float(row[5])
    thing.age = UNKNOWN if age == m.NEVER_SEEN else int(age)


def compare_places(match, naive):
    ours = np.concatenate([match.ball[None], match.players[:, :4]])
    twin = [[t.at.real, t.at.imag, t.v.real, t.v.imag] for t in (naive.ball, *naive.players)]
    np.testing.assert_allclose(ours, twin, rtol=0, atol=ROUNDING)
    turned = (match.players[:, 4] - [p.body for p in naive.players] + 180) % 360 - 180
    np.testing.assert_allclose(turned, 0, atol=ROUNDING)
    np.testing.assert_allclose(match.players[:, 5], [p.neck for p in naive.players], atol=ROUNDING)


def compare(match, naive):
    compare_places(match, naive)
    options = [(OPTION_NAMES[o[m.OPTION]], o[m.TARGET], o[m.START]) for o in match.options]
    assert options == [(mind.option, mind.target, mind.start) for mind in naive.minds]
    deciding = [i for i, mind in enumerate(naive.minds) if mind.decides]
    assert list(np.flatnonzero(match.deciding)) == deciding
    for i in deciding:
        # The simulator's angle comes from an arc cosine, good to 1e-6 degrees near 0 and 180.
        np.testing.assert_allclose(match.variables[i], naive.minds[i].variables, atol=1e-5)


@pytest.mark.jit
@pytest.mark.parametrize(
    ("setting", "policy"),
    [
        ("exact", "random"),
        ("exact", "hold"),
        ("exact", "hand"),
        ("360", "random"),
        ("360", "hold"),
        ("360", "hand"),
        ("360 unrounded", "hold"),
        ("90", "hand"),
        ("4v3 on 30 m", "random"),
        ("5v4 on 35 m, 90", "hand"),
        ("2v1 on 15 m", "random"),
    ],
)
def test_the_same_draws_give_the_same_cycle(setting, policy):
    config = SETTINGS[setting]
    streams = open_streams(7, setting, policy)
    match, rules = new_match(config, streams), config.rules()
    naive = NaiveMatch(config, open_streams(7, setting, policy))
    for _ in range(50):
        compare_places(match, naive)
        take_over(naive, match)
        ended = step_cycle(match, rules, POLICIES[policy], streams)
        assert naive.play_cycle(policy) == ended
        assert END_REASONS[match.status[m.END]] == (naive.end or "ongoing")
        compare(match, naive)
        if ended:
            start_episode(match, rules, streams.placement)
            naive.start_episode()
