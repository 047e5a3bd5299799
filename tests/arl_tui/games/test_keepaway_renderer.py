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
    renderer = screens_of(PROTOCOL).renderer(PROTOCOL)
    seen = []
    for output in build_session(PROTOCOL, 4).run(Silent(), ManualClock()):
        if isinstance(output, EpisodeStarted):
            seen.append((output, renderer.begin(output)))
        elif isinstance(output, StepTaken):
            seen.append((output, renderer.act(output)))
        elif isinstance(output, EpisodeEnded):
            seen.append((output, (renderer.picture,)))
    return seen


def test_every_cycle_of_an_episode_is_shown_once(shown):
    cycles: list[int] = []
    for output, ticks in shown:
        if isinstance(output, EpisodeStarted):
            cycles = []
        if isinstance(output, EpisodeEnded):
            cycles.append(ticks[0].cycle)
            assert cycles == list(range(cycles[-1] + 1))
            assert output.performance == pytest.approx(cycles[-1] * 0.1)
        else:
            cycles += [tick.view.cycle for tick in ticks]


def test_a_step_begins_with_its_decision_and_ends_before_the_next_one(shown):
    for (output, ticks), (following, _) in itertools.pairwise(shown):
        if isinstance(output, StepTaken):
            assert ticks[0].view.cycle == output.detail["cycle"]
            assert {tick.view.decider for tick in ticks} == {output.detail["keeper"]}
            assert {tick.view.target for tick in ticks} == {output.detail["target"]}
            if isinstance(following, StepTaken):
                assert ticks[-1].view.cycle == following.detail["cycle"] - 1


def test_nobody_has_decided_before_the_first_decision(shown):
    for output, ticks in shown:
        if isinstance(output, EpisodeStarted):
            assert len(ticks) > 1
            assert all((tick.view.decider, tick.view.target) == (-1, -1) for tick in ticks)


def test_each_picture_comes_with_the_one_after_it(shown):
    for _, ticks in shown:
        for tick in ticks if len(ticks) > 1 else ():
            assert tick.ahead.cycle == tick.view.cycle + 1
        for one, other in itertools.pairwise(ticks):
            assert one.ahead.players == other.view.players
            assert one.ahead.ball == other.view.ball


def test_the_final_picture_says_how_it_ended(shown):
    finals = [ticks[0] for output, ticks in shown if isinstance(output, EpisodeEnded)]
    assert all(picture.ended != ONGOING for picture in finals)
    assert [picture.episode for picture in finals] == [1, 2]


def test_slow_motion_shows_each_cycle_for_longer():
    assert screens_of(PROTOCOL).renderer(PROTOCOL).tick_ns == 2 * CYCLE_NS


def test_a_picture_travels_to_the_screen_and_back(shown):
    tick = shown[1][1][0]
    picture = Picture(number=1, step=0, view=tick.view, ahead=tick.ahead, lasts_ns=CYCLE_NS)
    again = from_worker(msgspec.msgpack.encode(picture))
    assert isinstance(again, Picture)
    assert again == picture
    assert np.isfinite(again.view.ball).all()


def test_who_chose_an_option_is_known_for_the_last_ones(shown):
    renderer = screens_of(PROTOCOL).renderer(PROTOCOL)
    last = None
    for output, _ in shown:
        if isinstance(output, EpisodeStarted):
            renderer.begin(output)
        elif isinstance(output, StepTaken):
            renderer.act(output)
            for step in filter(None, (last, output)):
                place = renderer.place_of(step.step)
                assert place == ((step.detail["keeper"], step.detail["target"]),)
            last = output
    assert renderer.place_of(10_000) == ()
