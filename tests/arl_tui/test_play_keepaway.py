"""A session of Keepaway with a faked worker: what is seen of it, and which pictures count as seen."""

from collections.abc import Iterable
from pathlib import Path

import msgspec
import pytest
from textual.pilot import Pilot
from textual.widgets import Static

from arl_tui.app.link import Picture, Ready, TakenFor
from arl_tui.app.outcome import SessionOutcome
from arl_tui.games.keepaway.panel import KeepawayPanel
from arl_tui.palette import STANDARD
from arl_tui.screens.covers import SmallWindowScreen
from arl_tui.session_app import ArlApp
from core.combination.config import AskingConfig
from core.events import EpisodeEnded, FrameShown, StepTaken
from core.keepaway.picture import PitchFrame
from core.keepaway.pitch import TAKEN
from core.keepaway.plugin import KEEPAWAY
from core.recording.reader import read_recording
from core.session.protocol import Protocol, ScreenConfig
from tests.arl_tui.driving import app_for, recorded, settle
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started, session_ended
from tests.arl_tui.pitches import HOLDING, PASSING
from tests.arl_tui.test_words_on_screens import drawn

SIZE = (80, 24)
SECOND = 1_000_000_000
MOVED = msgspec.structs.replace(
    PASSING, ball=(0.0, -5.7), cycle=PASSING.cycle + 1, time_s=PASSING.time_s + 0.1
)


@pytest.fixture
def protocol() -> Protocol:
    return msgspec.structs.replace(
        KEEPAWAY,
        session=msgspec.structs.replace(KEEPAWAY.session, episodes=3),
        screen=ScreenConfig(speed=1.0, count_down_s=0),
    )


@pytest.fixture
def app(
    protocol: Protocol, link: FakeLink, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterable[ArlApp]:
    # Pictures must not depend on the terminal that the tests are run in.
    monkeypatch.setattr("arl_tui.session_app.palette_for", lambda *_, **__: STANDARD)
    monkeypatch.setattr("arl_tui.widgets.pitch.detail_for", lambda: "ascii")
    return app_for(protocol, link, tmp_path)


class Worker:
    """Plays the worker's part."""

    def __init__(self, link: FakeLink) -> None:
        self.link = link
        self.pictures = 0

    def show(self, step: int, view: PitchFrame, ahead: PitchFrame | None = None) -> None:
        lasts_ns = SECOND if ahead is not None else 0
        self.link.say(Picture(number=self.pictures, step=step, view=view, ahead=ahead, lasts_ns=lasts_ns))
        self.pictures += 1

    def decide(self, step: int) -> None:
        self.link.say(
            StepTaken(
                episode=0,
                step=step,
                time_ns=0,
                inputs=0,
                action=1,
                environment_action=1,
                human_action=-1,
                detail={"keeper": 0, "cycle": 70, "target": 1},
                reward=0.1,
            )
        )


async def begin(pilot: Pilot[SessionOutcome], link: FakeLink) -> Worker:
    """Bring the app to a running episode."""
    link.say(Ready(warm_up_ns=1))
    await pilot.press("enter")
    await pilot.pause()
    worker = Worker(link)
    link.say(episode_started())
    worker.show(-1, HOLDING)
    await pilot.pause(0.05)
    return worker


def pitch_text(app: ArlApp) -> str:
    panel = app.play.panel
    assert isinstance(panel, KeepawayPanel)
    return "\n".join(panel.pitch.render_line(y).text for y in range(panel.pitch.size.height))


def score(app: ArlApp) -> str:
    return str(app.screen.query_one("#score", Static).content)


def frames(folder: Path) -> list[FrameShown]:
    (path,) = folder.glob("*.jsonl")
    return [event for event in read_recording(path).events if isinstance(event, FrameShown)]


async def test_the_first_screen_says_who_is_who_and_what_to_judge(app: ArlApp):
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        text = " ".join(" ".join(str(static.content) for static in app.screen.query(Static)).split())
    assert "The keepers ([b]K[/]) pass a ball among themselves" in text
    assert "2 presses in each game" in text
    assert "practise on their own" not in text


async def test_the_game_its_time_and_the_presses_left_stand_in_the_boundary(app: ArlApp, link: FakeLink):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        assert "Game 1" in pitch_text(app)
        assert "7.0 s" in pitch_text(app)
        assert "2 presses left" in pitch_text(app)
        worker.decide(0)
        worker.show(0, PASSING)
        await pilot.pause(0.05)
        assert "K1 passes to K2" in pitch_text(app)
        await pilot.press("j")
        assert "1 press left" in pitch_text(app)
        await pilot.press("u")
        assert "2 presses left" in pitch_text(app)


async def test_what_lies_between_two_cycles_is_drawn_but_is_no_picture_of_its_own(
    app: ArlApp, link: FakeLink, tmp_path: Path
):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        worker.decide(0)
        worker.show(0, PASSING, MOVED)
        await pilot.pause(0.05)
        before = pitch_text(app)
        for _ in range(200):
            await pilot.pause(0.02)
            if pitch_text(app) != before:
                break
        assert pitch_text(app) != before
        worker.show(0, MOVED)
        await pilot.pause(0.1)
    assert [frame.step for frame in frames(tmp_path)] == [-1, 0, 0]


async def test_an_option_that_looks_like_the_one_before_is_seen_all_the_same(
    app: ArlApp, link: FakeLink, tmp_path: Path
):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        for step in range(3):
            worker.decide(step)
            worker.show(step, HOLDING)
            await pilot.pause(0.05)
    assert [frame.step for frame in frames(tmp_path)] == [-1, 0, 1, 2]


async def test_the_last_picture_and_the_score_stay_until_the_next_game(app: ArlApp, link: FakeLink):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        ended = msgspec.structs.replace(HOLDING, ended=TAKEN, holder=3)
        link.say(episode_ended(performance=7.0))
        worker.show(-1, ended)
        await pilot.pause(0.05)
        assert "Game over" in pitch_text(app)
        assert "Ball taken after 7.0 s" in pitch_text(app)
        assert "Kept       7.0 s" in score(app)
        assert "Game       1 of 3" in score(app)
        link.say(episode_started(episode=1))
        worker.show(-1, HOLDING)
        await pilot.pause(0.05)
        assert "Game 2" in pitch_text(app)
        assert "Game       2 of 3" in score(app)


async def test_after_a_pause_the_picture_is_seen_once_more(app: ArlApp, link: FakeLink, tmp_path: Path):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        worker.decide(0)
        worker.show(0, PASSING)
        await pilot.pause(0.05)
        await pilot.press("p")
        await pilot.pause(0.05)
        await pilot.press("p")
        await pilot.pause(0.1)
    assert [frame.step for frame in frames(tmp_path)] == [-1, 0, 0]


async def test_long_regions_need_wide_windows(link: FakeLink, tmp_path: Path):
    task = msgspec.structs.replace(KEEPAWAY.domain, length_m=60.0)
    protocol = msgspec.structs.replace(KEEPAWAY, domain=task)
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1))
        await pilot.press("enter")
        await pilot.pause()
        assert isinstance(app.play.panel, KeepawayPanel)
        assert app.play.panel.needed.width == 98
        await pilot.pause()
        assert isinstance(app.screen, SmallWindowScreen)
        await pilot.resize_terminal(98, 24)
        await pilot.pause()
        assert app.screen is app.play


async def test_only_the_newest_games_are_listed(app: ArlApp, link: FakeLink):
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        for episode, seconds in enumerate((3.0, 30.5, 4.0, 5.0)):
            link.say(EpisodeEnded(**{**as_fields(episode_ended(episode)), "performance": seconds}))
        worker.show(-1, PASSING)
        await pilot.pause(0.05)
        assert "Kept       30.5 4.0 5.0 s" in score(app)
        assert "Best       30.5 s" in score(app)
        assert max(len(line) for line in score(app).splitlines()) <= 31


def as_fields(event: EpisodeEnded) -> dict[str, object]:
    return {name: getattr(event, name) for name in event.__struct_fields__}


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_a_session_of_keepaway_looks_as_it_did(
    snap_compare, app: ArlApp, link: FakeLink, size: tuple[int, int]
):
    async def play(pilot: Pilot[SessionOutcome]) -> None:
        worker = await begin(pilot, link)
        link.say(episode_ended(performance=9.3))
        link.say(episode_started(episode=1))
        worker.show(-1, HOLDING)
        worker.decide(0)
        worker.show(0, PASSING)
        await pilot.pause(0.05)

    assert snap_compare(app, terminal_size=size, run_before=play)


async def test_a_press_marks_who_chose_and_is_no_frame(
    app: ArlApp, link: FakeLink, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("arl_tui.widgets.pitch.MARK_S", 0.3)
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link)
        worker.decide(0)
        worker.show(0, PASSING)
        await pilot.pause(0.05)
        await pilot.press("f")
        link.say(TakenFor(press=0, value=-1.0, step=0, place=((0, 1),)))
        await pilot.pause(0.05)
        assert "-K1" in screen_text(app)
        assert "K2-" in screen_text(app)
        assert app.play.feedback.note == "Counted for K1's pass to K2"
        for _ in range(40):
            await pilot.pause(0.05)
            if "-K1" not in screen_text(app):
                break
        assert "-K1" not in screen_text(app)
        link.say(session_ended())
        await pilot.pause(0.1)
    shown = [event.step for event in recorded(tmp_path).events if isinstance(event, FrameShown)]
    assert shown.count(0) == 1


def screen_text(app: ArlApp) -> str:
    drawn = app.play.panel.pitch.drawn_frame
    text = "\n".join(strip.text for strip in app.screen._compositor.render_strips())
    app.play.panel.pitch.drawn_frame = drawn  # looking is no drawing
    return text


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_a_marked_option_looks_as_it_did(snap_compare, app: ArlApp, link: FakeLink, size: tuple[int, int]):
    async def play(pilot: Pilot[SessionOutcome]) -> None:
        worker = await begin(pilot, link)
        worker.decide(0)
        worker.show(0, PASSING)
        await pilot.press("j")
        link.say(TakenFor(press=0, value=1.0, step=0, place=((0, 1),)))
        await pilot.pause(0.05)

    assert snap_compare(app, terminal_size=size, run_before=play)


@pytest.mark.parametrize("language", ["en", "de"])
async def test_the_start_key_is_in_sight_below_questions_and_a_warning_of_the_pace(
    link: FakeLink, tmp_path: Path, language: str
) -> None:
    """In the smallest window the text is longer than the page: it scrolls, and the keys stay."""
    replace = msgspec.structs.replace
    protocol = replace(
        KEEPAWAY,
        agent=replace(KEEPAWAY.agent, asking=AskingConfig(per_episode=3)),
        keys=replace(KEEPAWAY.keys, wrong_press_rate=0.1),
        screen=replace(KEEPAWAY.screen, language=language),
    )
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=(80, 24)) as pilot:
        link.say(Ready(warm_up_ns=1, reach=0.3, step_s=0.5))
        await pilot.pause()
        text = drawn(app)
        call = "to start" if language == "en" else "Beginnen mit"
        assert call in text
        assert "↓" in text  # more below
        await pilot.press("pagedown", "pagedown")
        await settle(pilot)
        assert "For the experimenter" in drawn(app)
        assert call in drawn(app)
