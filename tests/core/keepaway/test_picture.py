"""Pictures of the pitch, and pictures between two of them."""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.keepaway.picture import PitchFrame, PlayerView, between
from core.keepaway.pitch import NO_PLAYER, OUT, TAKEN

K1, K2, T1 = PlayerView(-5.0, 0.0, 170.0), PlayerView(5.0, 5.0, 0.0), PlayerView(0.0, 0.0, 90.0)


def picture(**changes) -> PitchFrame:
    frame = PitchFrame(
        length_m=20.0, width_m=20.0, n_keepers=2, players=(K1, K2, T1), ball=(-5.5, 0.0), cycle=30, time_s=3.0
    )
    return msgspec.structs.replace(frame, **changes)


def later(**changes) -> PitchFrame:
    return picture(**{"cycle": 31, "time_s": 3.1, **changes})


def test_halfway_everybody_has_gone_half_the_way():
    after = later(players=(PlayerView(-4.0, 0.5, 170.0), K2, T1), ball=(-4.5, 1.0))
    halfway = between(picture(), after, 0.5)
    assert halfway.players[0] == PlayerView(-4.5, 0.25, 170.0)
    assert halfway.players[1:] == (K2, T1)
    assert halfway.ball == (-5.0, 0.5)
    assert halfway.time_s == pytest.approx(3.05)


@pytest.mark.parametrize(
    ("start", "end", "halfway"),
    [(170.0, -170.0, 180.0), (-170.0, 160.0, 175.0), (-30.0, 30.0, 0.0), (0.0, 180.0, 90.0)],
)
def test_players_turn_the_short_way(start: float, end: float, halfway: float):
    before = picture(players=(PlayerView(0.0, 0.0, start), K2, T1))
    after = later(players=(PlayerView(0.0, 0.0, end), K2, T1))
    assert between(before, after, 0.5).players[0].body_deg == pytest.approx(halfway)


def test_the_ends_are_the_pictures_themselves():
    before, after = picture(), later(ball=(-4.0, 0.0))
    for share, end in ((0.0, before), (-1.0, before), (1.0, after), (1.5, after)):
        assert between(before, after, share) is end


def test_nothing_slides_into_the_next_episode():
    before, after = picture(), picture(episode=2, cycle=0, time_s=0.0, ball=(-6.0, -6.0))
    assert between(before, after, 0.99) is before
    assert between(before, after, 1.0) is after


def test_nothing_runs_backwards():
    before, after = later(), picture()
    assert between(before, after, 0.5) is before


def test_who_is_put_elsewhere_by_the_referee_does_not_slide_there():
    after = later(players=(PlayerView(4.0, 0.0, 170.0), PlayerView(5.5, 5.0, 0.0), T1), ball=(3.0, 8.0))
    halfway = between(picture(), after, 0.5)
    assert halfway.players[0] == K1
    assert halfway.players[1].x_m == pytest.approx(5.25)
    assert halfway.ball == (-5.5, 0.0)


def test_a_ball_at_full_speed_slides():
    assert between(picture(), later(ball=(-2.5, 0.0)), 0.5).ball == (-4.0, 0.0)


def test_the_option_on_screen_changes_only_with_the_picture_that_first_shows_it():
    before = picture(decider=0, holder=0)
    after = later(decider=0, target=1, holder=NO_PLAYER)
    almost = between(before, after, 0.99)
    assert (almost.decider, almost.target, almost.holder) == (0, NO_PLAYER, 0)


@given(
    st.floats(-10, 10), st.floats(-10, 10), st.floats(-179.9, 180), st.floats(-179.9, 180), st.floats(0, 1)
)
def test_every_picture_between_lies_between(x: float, y: float, start: float, end: float, share: float):
    before = picture(players=(PlayerView(x, y, start), K2, T1))
    after = later(players=(PlayerView(x + 0.6, y - 0.8, end), K2, T1))
    here = between(before, after, share).players[0]
    assert math.hypot(here.x_m - x, here.y_m - y) == pytest.approx(share, abs=1e-9)
    assert -180.0 < here.body_deg <= 180.0
    whole = abs((end - start + 180.0) % 360.0 - 180.0)
    turned = abs((here.body_deg - start + 180.0) % 360.0 - 180.0)
    assert turned == pytest.approx(share * whole, abs=1e-6)


def test_words_say_what_is_going_on():
    assert picture().caption() == "Ball is free"
    assert picture(holder=1).caption() == "K2 has the ball"
    assert picture(holder=2).caption() == "T1 has the ball"
    assert picture(holder=0, decider=0, target=1).caption() == "K1 passes to K2"
    assert picture(holder=2, decider=0, target=1).caption() == "T1 has the ball"
    assert picture(ended=OUT).caption() == "Ball out after 3.0 s"
    assert picture(ended=TAKEN, holder=2).caption() == "Ball taken after 3.0 s"


def test_a_pass_is_over_when_a_taker_has_the_ball_or_the_episode_ends():
    assert picture(decider=0, target=1).passing
    assert not picture(decider=0, target=1, holder=2).passing
    assert not picture(decider=0, target=1, ended=OUT).passing


def test_a_picture_can_be_sent_to_another_process():
    frame = picture(trail=((1.0, 2.0),), holder=1)
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(frame), type=PitchFrame) == frame


def test_a_picture_without_keepers_is_an_error():
    with pytest.raises(ValueError, match="0 keepers of 3 players"):
        picture(n_keepers=0)
