"""What participant and experimenter see of pace, preparation and weight."""

from pathlib import Path

import msgspec
import pytest
from textual.pilot import Pilot

from arl_tui.app.link import Preparing, Ready
from arl_tui.app.outcome import SessionOutcome
from arl_tui.games.pace import pace_facts, pace_warning
from arl_tui.screens.play import PlayScreen
from arl_tui.screens.welcome import AT_SCREEN_S, WelcomeScreen
from arl_tui.session_app import ArlApp
from core.keepaway.plugin import KEEPAWAY
from core.numerics.clock import NS_PER_S, ManualClock
from core.recording.schema import to_plain
from core.session import reach
from core.session.protocol import DEFAULTS, ENOUGH_REACH, Protocol, ScreenConfig
from core.session.protocol_reading import protocol_from
from tests.arl_tui.driving import SIZE, app_for, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started, session_ended

LOW = Ready(warm_up_ns=1, reach=0.49, step_s=0.65)
HIGH = Ready(warm_up_ns=1, reach=0.92, step_s=1.63)


@pytest.mark.jit
@pytest.mark.parametrize("game", DEFAULTS)
def test_at_the_default_pace_a_press_usually_reaches_its_step(game: str) -> None:
    found = reach.reach_of(DEFAULTS[game])
    assert found.fraction >= ENOUGH_REACH
    assert pace_warning(DEFAULTS[game], Ready(warm_up_ns=1, reach=found.fraction, step_s=found.step_s)) == ""


def test_the_warning_says_the_figure_the_step_and_what_to_change() -> None:
    fast = Protocol(screen=ScreenConfig(tick_ms=80))
    text = pace_warning(fast, LOW)
    for part in ("49%", "piece", "0.65 s", "gamma:2.5,0.3", "previous", "tick_ms is 80"):
        assert part in text
    assert "speed is 0.2" in pace_warning(KEEPAWAY, LOW)
    assert (
        pace_warning(fast, HIGH) == pace_warning(fast, None) == pace_warning(fast, Ready(warm_up_ns=1)) == ""
    )


def test_a_protocol_that_says_nothing_has_the_new_pace_and_a_recorded_one_its_own() -> None:
    assert protocol_from({}).screen.tick_ms == 200
    assert protocol_from({"domain": {"type": "keepaway"}}).screen.speed == 0.2
    assert (
        protocol_from({"domain": {"type": "keepaway"}, "screen": {"palette": "sixteen"}}).screen.speed == 0.2
    )
    old = to_plain(Protocol(screen=ScreenConfig(tick_ms=80)))
    assert protocol_from(old).screen.tick_ms == 80


async def test_a_pace_that_misses_is_said_before_the_start_and_kept_in_the_header(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        assert "experimenter" not in text_of(app)
        link.say(LOW)
        await pilot.pause()
        assert "For the experimenter: at this pace about 49%" in text_of(app)
        assert app.screen.query_one(".page").max_scroll_y == 0
        await pilot.press("enter")
        await settle(pilot)
        link.say(episode_started(), episode_ended(), session_ended())
        await settle(pilot)
        assert "xperimenter" not in text_of(app)
        await pilot.press("enter")
    assert app.return_value is not None
    assert "49%" in app.return_value.warning
    assert recorded(tmp_path).header.source == pace_facts(LOW)


@pytest.mark.parametrize("game", DEFAULTS)
async def test_the_first_page_says_which_share_of_a_press_reaches_its_step(
    game: str, link: FakeLink, tmp_path: Path
) -> None:
    app = app_for(DEFAULTS[game], link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(HIGH)
        await pilot.pause()
        text = text_of(app)
        assert "Enter" in text
        assert "For the experimenter: about 92% of a press reaches its" in text
        assert app.screen.query_one(".page").max_scroll_y == 0


async def test_the_first_page_says_how_far_it_is(app: ArlApp, link: FakeLink) -> None:
    async with app.run_test(size=SIZE) as pilot:
        link.say(Preparing(compiled=12, needed=53))
        await pilot.pause()
        assert "12 of about 53 parts" in text_of(app)
        await pilot.press("enter")
        link.say(Preparing(compiled=30, needed=53))
        await pilot.pause()
        assert "30 of about 53 parts" in text_of(app)
        assert "Please wait" in text_of(app)


@pytest.mark.parametrize("game", DEFAULTS)
async def test_the_warning_fits_on_the_first_page(game: str, link: FakeLink, tmp_path: Path) -> None:
    app = app_for(DEFAULTS[game], link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(LOW)
        await pilot.pause()
        assert "slower" in screen_text(app)
        assert "to start" in screen_text(app)
        assert app.screen.query_one(".page").max_scroll_y == 0


async def test_a_page_that_did_not_fit_fits_in_a_larger_window(link: FakeLink, tmp_path: Path) -> None:
    # A bar made the text one line longer than this window, and so it stayed.
    app = app_for(DEFAULTS["gymnasium"], link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(LOW)
        await pilot.pause()
        await pilot.resize_terminal(SIZE[0], SIZE[1] - 3)
        await pilot.pause(0.1)
        assert "more below" in screen_text(app)
        await pilot.resize_terminal(*SIZE)
        await pilot.pause(0.1)
        assert "slower" in screen_text(app)


@pytest.mark.parametrize(("waited_s", "starts"), [(AT_SCREEN_S - 1, True), (AT_SCREEN_S + 1, False)])
async def test_no_game_begins_in_front_of_nobody(
    app: ArlApp, link: FakeLink, waited_s: float, starts: bool
) -> None:
    clock = app.welcome._clock = ManualClock()
    async with app.run_test(size=SIZE) as pilot:
        await pilot.press("enter")
        clock.advance_ns(round(waited_s * NS_PER_S))
        link.say(HIGH)
        await pilot.pause()
        assert isinstance(app.screen, PlayScreen if starts else WelcomeScreen)
        if not starts:
            assert "Ready." in text_of(app)
            await pilot.press("enter")
            await pilot.pause()
            assert isinstance(app.screen, PlayScreen)


# --- the weight ---------------------------------------------------------------------------------------------


def screen_text(app: ArlApp) -> str:
    return "\n".join(strip.text for strip in app.screen._compositor.render_strips())


async def play_two_games(
    pilot: Pilot[SessionOutcome], app: ArlApp, link: FakeLink, protocol: Protocol
) -> tuple[str, str]:
    """Return the screen in the second game, and at the end: the weight is 0.02, the trust 0.25."""
    worker = await begin(pilot, link, protocol, steps=1)
    link.say(episode_ended())
    link.say(msgspec.structs.replace(episode_started(1), weight=0.02))
    worker.step(1, column=4)
    await pilot.pause(0.4)  # figures are redrawn four times a second
    during = screen_text(app)
    link.say(episode_ended(1), session_ended())
    await settle(pilot)
    return during, screen_text(app)


async def test_the_participant_does_not_see_the_weight(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        during, end = await play_two_games(pilot, app, link, protocol)
    for text in (during, end):
        assert not any(
            word in text for word in ("Influence", "Weight", "listens", "0.02", "0.25", "25%", "2%")
        )


async def test_a_setting_shows_the_weight_in_use_and_is_recorded(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    screen = msgspec.structs.replace(protocol.screen, show_weight=True)
    protocol = msgspec.structs.replace(protocol, screen=screen)
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        during, end = await play_two_games(pilot, app, link, protocol)
    assert "Influence" in during
    assert "0.02" in during
    assert "0.25" not in during + end  # the trust, which under annealed is no weight
    assert "Weight of your feedback in the last game: 0.02" in end
    assert recorded(tmp_path).header.protocol["screen"]["show_weight"] is True


async def test_no_name_of_a_file_is_on_the_last_page(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    folder = tmp_path / "annealed-arm"
    app = app_for(msgspec.structs.replace(protocol, name="annealed"), link, folder)
    async with app.run_test(size=SIZE) as pilot:
        texts = [screen_text(app)]
        await begin(pilot, link, protocol, steps=1)
        texts.append(screen_text(app))
        link.say(episode_ended(), session_ended())
        await settle(pilot)
        texts.append(screen_text(app))
    assert not any("annealed" in text or ".jsonl" in text for text in texts)
