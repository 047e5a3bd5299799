"""Windows, themes, no colours, stretches and blocks: what a participant sees, and what is asked of them."""

import os
from pathlib import Path

import msgspec
import pytest
from textual.geometry import Size

from arl_tui.app.link import Practised, Ready
from arl_tui.app.plain_app import PlainApp
from arl_tui.palette import HIGH_CONTRAST, SIXTEEN, palette_for
from arl_tui.screens.covers import BreakScreen
from arl_tui.screens.play import MOVES_S, PlayScreen
from arl_tui.session_app import ArlApp
from arl_tui.themes import NAMES, ThemeError, theme_in_use
from arl_tui.widgets.blocks import enlarged, lines_per_block
from core.events import ScreenCleared
from core.recording.schema import to_plain
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from core.session.protocol_reading import protocol_from
from core.session.session import build_session
from tests.arl_tui.driving import SIZE, Worker, app_for, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started, session_ended
from tests.arl_tui.widgets.test_widgets_board import contrast


def screen_text(app: PlainApp) -> str:
    return "\n".join(strip.text for strip in app.screen._compositor.render_strips())


def with_screen(protocol: Protocol, **changes: object) -> Protocol:
    screen = msgspec.structs.replace(protocol.screen, **changes)
    session = msgspec.structs.replace(protocol.session, episodes=4)
    return msgspec.structs.replace(protocol, screen=screen, session=session)


# --- size ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("window", "lines"),
    [((80, 24), 1), ((200, 42), 1), ((200, 43), 2), ((97, 60), 1), ((98, 60), 2), ((200, 63), 3)],
)
def test_blocks_are_as_large_as_whole_lines_allow(window: tuple[int, int], lines: int) -> None:
    # 20 rows of 2 lines and 3 lines around them make 43; 10 columns of 4 and 58 around them make 98.
    assert lines_per_block(Size(10, 20), Size(58, 3), Size(*window)) == lines


def test_a_texture_is_drawn_over_the_whole_block() -> None:
    assert enlarged("==", 2, last=False) == "===="
    assert enlarged("[]", 3, last=True) == "[    ]"
    assert [enlarged(" ▕", 2, last=last) for last in (False, True)] == ["   ▕", "▁▁▁▕"]


@pytest.mark.parametrize(("size", "lines"), [((80, 24), 1), ((120, 40), 1), ((200, 60), 2)])
async def test_the_board_grows_with_the_window(
    app: ArlApp, link: FakeLink, protocol: Protocol, size: tuple[int, int], lines: int
) -> None:
    async with app.run_test(size=size) as pilot:
        await begin(pilot, link, protocol, steps=2)
        board = app.play.panel.game_widget()
        assert (board.size.width, board.size.height) == (20 * lines, 20 * lines)
        await pilot.resize_terminal(*SIZE)
        await settle(pilot)
        assert (board.size.width, board.size.height) == (20, 20)
        await pilot.resize_terminal(*size)
        await settle(pilot)
        assert board.lines_per_block == lines
        first, last = board.render_line(20 * lines - lines), board.render_line(20 * lines - 1)
        assert first.cell_length == last.cell_length == 20 * lines


async def test_a_grown_board_is_stamped_once_per_step(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=(200, 60)) as pilot:
        await begin(pilot, link, protocol, steps=3)
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    steps = [event.step for event in recorded(tmp_path).events if type(event).__name__ == "FrameShown"]
    assert [step for step in steps if step >= 0] == [0, 1, 2]


# --- themes and colours -------------------------------------------------------------------------------------


def test_the_environment_overrules_the_protocol() -> None:
    assert theme_in_use("light", {}) == "light"
    assert theme_in_use("light", {"ARL_THEME": "high-contrast"}) == "high-contrast"
    assert theme_in_use("light", {"ARL_THEME": ""}) == "light"
    with pytest.raises(ThemeError, match=r"no theme 'pink' \(ARL_THEME\): choose one of dark, light, high"):
        theme_in_use("light", {"ARL_THEME": "pink"})


@pytest.mark.parametrize("theme", NAMES)
async def test_the_protocol_s_theme_is_shown(
    theme: str, protocol: Protocol, link: FakeLink, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ARL_THEME", raising=False)
    app = app_for(with_screen(protocol, theme=theme), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        assert app.theme == f"arl-{theme}"
        style = app.welcome.query_one("#call").rich_style
        assert style.color is not None
        assert style.bgcolor is not None
        from textual.color import Color

        assert contrast(Color.from_rich_color(style.color), Color.from_rich_color(style.bgcolor)) > 7


def test_a_theme_chooses_the_board_s_palette() -> None:
    assert palette_for("standard", "truecolor", theme="light").name == "standard-light"
    assert palette_for("colour-blind", "256", theme="light").name == "colour-blind-light"
    assert palette_for("standard", "truecolor", theme="high-contrast") is HIGH_CONTRAST
    assert palette_for("standard", "standard", theme="light") is SIXTEEN


async def test_no_color_gives_textures_and_reaches_the_next_app(
    protocol: Protocol, link: FakeLink, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    app = app_for(protocol, link, tmp_path)
    assert os.environ["NO_COLOR"] == "1"  # a study runs one app after another
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=2)
        assert app.play.panel.board.palette is HIGH_CONTRAST
        worker.step(2, column=4)
        await settle(pilot)
        text = screen_text(app)
        assert "[][]" in text  # the pieces of the test's worker are squares
        colours = {
            (colour.red, colour.green, colour.blue)
            for strip in app.screen._compositor.render_strips()
            for segment in strip.apply_filter(app._filters[-1], app.screen.background_colors[1])
            if segment.style is not None and segment.style.color is not None
            for colour in [segment.style.color.get_truecolor()]
        }
    assert all(red == green == blue for red, green, blue in colours), colours


def test_settings_of_this_version_leave_recordings_as_they_were() -> None:
    assert set(to_plain(Protocol())["screen"]) == {
        "tick_ms",
        "speed",
        "pause_between_episodes_s",
        "count_down_s",
        "mark_presses",
        "show_weight",
        "palette",
    }
    changed = Protocol(screen=ScreenConfig(theme="light", games_per_block=2))
    assert to_plain(changed)["screen"]["theme"] == "light"
    assert protocol_from(to_plain(changed)) == changed
    assert protocol_from(to_plain(Protocol())) == Protocol()


# --- nothing asks for presses when there is nothing to judge ------------------------------------------------


async def test_nothing_asks_for_presses_between_games(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol, steps=1)
        assert "presses left" in screen_text(app)
        assert " good" in screen_text(app)
        link.say(episode_ended(), Practised(done=1, count=3))
        await settle(pilot)
        text = screen_text(app)
        assert "nothing to judge now" in text
        assert "presses left" not in text
        assert " good" not in text
        assert "1 of 3 games" in text
        worker.start_episode()
        await settle(pilot)
        assert "presses left" in screen_text(app)


async def test_nothing_asks_for_presses_in_the_count_down(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    app = app_for(with_screen(protocol, count_down_s=1), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol)
        assert "presses left" not in screen_text(app)
        await pilot.pause(1.3)
        assert "presses left" in screen_text(app)


async def test_a_budget_that_is_used_up_leaves_only_taking_back(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        for _ in range(2):
            await pilot.press("j")
            await pilot.pause(0.25)
        await settle(pilot)
        text = screen_text(app)
        assert "0 of 2 presses left" in text
        assert "take back" in text
        assert " good " not in text


async def test_something_moves_while_unseen_games_are_played(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    assert MOVES_S <= 2.0
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, protocol, steps=1)
        link.say(episode_ended(), Practised(done=1, count=3))
        await settle(pilot)
        before = screen_text(app)
        await pilot.pause(2 * MOVES_S)
        assert screen_text(app) != before


def test_the_bar_of_unseen_games_is_true(protocol: Protocol) -> None:
    session = build_session(protocol, 3)
    heard: list[tuple[int, int]] = []
    session.after_unseen = lambda done, count: heard.append((done, count))

    class Nobody:
        def during(self, step: int) -> list[object]:
            return []

    from core.numerics.clock import ManualClock

    list(session.run(Nobody(), ManualClock()))
    assert heard == [(1, 3), (2, 3), (3, 3)]


# --- stretches and blocks -----------------------------------------------------------------------------------


async def play_games(pilot, link: FakeLink, worker: Worker, count: int) -> None:
    for _ in range(count):
        link.say(episode_ended())
        await settle(pilot)
        worker.start_episode()
        await settle(pilot)


async def test_games_of_a_stretch_follow_one_another_without_a_count_down(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    app = app_for(with_screen(protocol, count_down_s=1, games_per_stretch=2), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        await pilot.pause(1.2)
        await play_games(pilot, link, worker, 1)
        assert not app.play.panel.game_widget().covered  # game 2
        await play_games(pilot, link, worker, 1)
        assert app.play.panel.game_widget().covered  # game 3 begins a stretch
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    reasons = [event.reason for event in recorded(tmp_path).events if isinstance(event, ScreenCleared)]
    assert reasons == ["count-down", "count-down"]


async def test_a_break_between_blocks_waits_for_the_participant(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    app = app_for(with_screen(protocol, games_per_block=2), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, protocol)
        await play_games(pilot, link, worker, 1)
        assert app.screen is app.play
        await play_games(pilot, link, worker, 1)
        assert isinstance(app.screen, BreakScreen)
        assert "2 of 4 games are done" in screen_text(app)
        await pilot.press("j")
        await pilot.pause(0.5)
        assert isinstance(app.screen, BreakScreen)
        await pilot.press("space")
        await settle(pilot)
        assert app.screen is app.play
        assert not app.live.gate.covered
        link.say(episode_ended(), session_ended())
        await settle(pilot)
    reasons = [event.reason for event in recorded(tmp_path).events if isinstance(event, ScreenCleared)]
    assert reasons == ["pause"]


async def test_a_game_that_begins_before_its_screen_is_there_is_not_said_to_be_practised(
    link: FakeLink, tmp_path: Path
) -> None:
    protocol = Protocol(
        session=SessionConfig(episodes=2, unseen_between=100), screen=ScreenConfig(count_down_s=0)
    )
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1))
        await pilot.pause()
        app.begin()
        link.say(episode_started())  # the screen is mounted after this
        await settle(pilot)
        await pilot.pause(0.6)
        assert isinstance(app.screen, PlayScreen)
        assert "Practising" not in text_of(app)
