"""Pictures of a session of Keepaway: which belong to which step."""

import itertools

import msgspec
import numpy as np
import pytest

from arl_tui.app.link import Picture, from_worker
from arl_tui.games.registry import screens_of
from core.events import EpisodeEnded, EpisodeStarted, StepTaken
from core.keepaway.pitch import CYCLE_NS, ONGOING, KeepawayConfig
from core.keepaway.plugin import KEEPAWAY
from core.numerics.clock import ManualClock
from core.session.protocol import ScreenConfig, SessionConfig
from core.session.session import build_session

PROTOCOL = msgspec.structs.replace(
    KEEPAWAY,
    domain=KeepawayConfig(exact_state=True),
    session=SessionConfig(episodes=2, unseen_between=0, watched_steps=500),
    screen=ScreenConfig(speed=0.5),
)


class Silent:
    """A participant who only watches."""

    def during(self, step: int) -> list:
        return []


@pytest.fixture(scope="module")
def shown() -> list[tuple[object, tuple]]:
    """Each output with the pictures it brings."""
    stage = screens_of(PROTOCOL).renderer(PROTOCOL)
    seen = []
    for output in build_session(PROTOCOL, 4).run(Silent(), ManualClock()):
        if isinstance(output, EpisodeStarted):
            seen.append((output, stage.begin(output)))
        elif isinstance(output, StepTaken):
            seen.append((output, stage.act(output)))
        elif isinstance(output, EpisodeEnded):
            seen.append((output, (stage.picture,)))
    return seen


def test_every_cycle_of_an_episode_is_shown_once(shown):
    cycles: list[int] = []
    for output, shots in shown:
        if isinstance(output, EpisodeStarted):
            cycles = []
        if isinstance(output, EpisodeEnded):
            cycles.append(shots[0].cycle)
            assert cycles == list(range(cycles[-1] + 1))
            assert output.performance == pytest.approx(cycles[-1] * 0.1)
        else:
            cycles += [shot.view.cycle for shot in shots]


def test_a_step_begins_with_its_decision_and_ends_before_the_next_one(shown):
    for (output, shots), (following, _) in itertools.pairwise(shown):
        if isinstance(output, StepTaken):
            assert shots[0].view.cycle == output.detail["cycle"]
            assert {shot.view.decider for shot in shots} == {output.detail["keeper"]}
            assert {shot.view.target for shot in shots} == {output.detail["target"]}
            if isinstance(following, StepTaken):
                assert shots[-1].view.cycle == following.detail["cycle"] - 1


def test_nobody_has_decided_before_the_first_decision(shown):
    for output, shots in shown:
        if isinstance(output, EpisodeStarted):
            assert len(shots) > 1
            assert all((shot.view.decider, shot.view.target) == (-1, -1) for shot in shots)


def test_each_picture_comes_with_the_one_after_it(shown):
    for _, shots in shown:
        for shot in shots if len(shots) > 1 else ():
            assert shot.ahead.cycle == shot.view.cycle + 1
        for one, other in itertools.pairwise(shots):
            assert one.ahead.players == other.view.players
            assert one.ahead.ball == other.view.ball


def test_the_final_picture_says_how_it_ended(shown):
    finals = [shots[0] for output, shots in shown if isinstance(output, EpisodeEnded)]
    assert all(picture.ended != ONGOING for picture in finals)
    assert [picture.episode for picture in finals] == [1, 2]


def test_slow_motion_shows_each_cycle_for_longer():
    assert screens_of(PROTOCOL).renderer(PROTOCOL).tick_ns == 2 * CYCLE_NS


def test_a_picture_travels_to_the_screen_and_back(shown):
    shot = shown[1][1][0]
    picture = Picture(number=1, step=0, view=shot.view, ahead=shot.ahead, lasts_ns=CYCLE_NS)
    again = from_worker(msgspec.msgpack.encode(picture))
    assert isinstance(again, Picture)
    assert again == picture
    assert np.isfinite(again.view.ball).all()


def test_who_chose_an_option_is_known_for_the_last_ones(shown):
    stage = screens_of(PROTOCOL).renderer(PROTOCOL)
    last = None
    for output, _ in shown:
        if isinstance(output, EpisodeStarted):
            stage.begin(output)
        elif isinstance(output, StepTaken):
            stage.act(output)
            for step in filter(None, (last, output)):
                place = stage.place_of(step.step)
                assert (place.player, place.target) == (step.detail["keeper"], step.detail["target"])
            last = output
    assert stage.place_of(10_000).player == -1
