"""Questions of the agent in the app: drawn with their keys, answered once, and recorded with their time."""

from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from textual.pilot import Pilot

from arl_tui.app.link import AskNow, Ready
from arl_tui.app.outcome import SessionOutcome
from arl_tui.screens.covers import PauseScreen
from arl_tui.screens.question import CHOSEN, NOT_CHOSEN
from arl_tui.session_app import ArlApp
from core.combination.config import AgentConfig, AskingConfig
from core.events import FrameShown, KeyPressed, QuestionAnswered, QuestionPosed, Resumed, ScreenCleared
from core.session.protocol import DEFAULTS, Protocol
from tests.arl_tui.driving import SIZE, Worker, app_for, recorded, settle
from tests.arl_tui.fakes import FakeLink

ANTICIPATED_S = 0.15


@pytest.fixture
def protocol(protocol: Protocol) -> Protocol:
    asking = AskingConfig(per_episode=2, limit_s=30.0)
    return msgspec.structs.replace(protocol, agent=AgentConfig(asking=asking))


def ask(worker: Worker, question: int = 0) -> QuestionPosed:
    """Pose a question as the worker does, about three places of an O on an empty floor."""
    columns = (0, 3, 6)
    posed = QuestionPosed(
        question=question,
        episode=0,
        step=1,
        time_ns=0,
        inputs=0,
        options=[4, 7, 9],
        details=[{"piece": 1, "orientation": 0, "column": column} for column in columns],
        disagreement=0.6,
    )
    worker.link.say(posed)
    worker.show(-1, worker.renderer.picture)
    places = [worker.renderer.place_of_option(detail) for detail in posed.details]
    worker.link.say(AskNow(question=question, places=tuple(places)))
    return posed


async def until(pilot: Pilot[SessionOutcome], met: Callable[[], bool]) -> None:
    """Wait for something, however busy the machine is."""
    for _ in range(600):
        if met():
            return
        await pilot.pause(0.05)
    raise AssertionError("it has not come")


async def running(pilot: Pilot[SessionOutcome], app: ArlApp, link: FakeLink, protocol: Protocol) -> Worker:
    await until(pilot, lambda: link.listening and app.screen is app.welcome and app.screen.is_active)
    link.say(Ready(warm_up_ns=1))
    for tenth in range(600):
        if app.screen is app.play and app.live.phase == "running":
            break
        # A second key on a game that has begun would be told as one without a meaning.
        if tenth % 50 == 0 and app.screen is app.welcome:
            await pilot.press("enter")
        await pilot.pause(0.1)
    worker = Worker(link, protocol)
    worker.start_episode()
    await settle(pilot)
    worker.step(0)
    await settle(pilot)
    return worker


async def read(pilot: Pilot[SessionOutcome], app: ArlApp) -> None:
    """Wait until a question is on screen for long enough to be read."""
    await until(pilot, lambda: app.live.question is not None and app.live.question.is_shown)
    await pilot.pause(ANTICIPATED_S)


async def answered(pilot: Pilot[SessionOutcome], app: ArlApp) -> None:
    await until(pilot, lambda: app.live.question is None)
    await settle(pilot)


async def end(pilot: Pilot[SessionOutcome], app: ArlApp) -> None:
    app.live.give_up("end of the test")
    await until(pilot, lambda: app._outcome is not None)


def answers(folder: Path) -> list[QuestionAnswered]:
    return [event for event in recorded(folder).events if isinstance(event, QuestionAnswered)]


async def test_a_question_is_drawn_with_its_keys_and_its_answer_is_recorded_with_the_keys_time(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await running(pilot, app, link, protocol)
        ask(worker)
        await read(pilot, app)
        bar = app.play.query_one("#question")
        assert bar.display
        assert not app.play.feedback.display
        assert "columns 4 to 5" in str(bar.render())
        board = app.play.panel.board
        assert board.render_line(17).text.rstrip() == "1111"  # on the piece that has just landed
        # How a block itself is drawn hangs on the terminal.
        assert board.render_line(18).text[4:].rstrip() == "  2222  3333"
        await pilot.press("2")
        await answered(pilot, app)
        assert not bar.display
        assert app.play.feedback.display
        assert app.play.feedback.note == ""
        assert str(app.play.query_one("#status").render()) == CHOSEN
        assert board.render_line(18).text[4:].strip() == ""
        await end(pilot, app)
    events = recorded(tmp_path).events
    (answer,) = answers(tmp_path)
    (press,) = (event for event in events if isinstance(event, KeyPressed))
    assert (answer.answer, answer.chosen, answer.press) == ("chosen", 7, press.press)
    assert answer.time_ns == press.time_ns
    assert answer.time_ns - answer.shown_ns > 0.1e9
    kinds = [type(event) for event in events]
    assert kinds.index(ScreenCleared) < kinds.index(QuestionAnswered) < kinds.index(Resumed)
    # Nothing that was drawn under the question counts as a frame of the game.
    covered = events[kinds.index(ScreenCleared) : kinds.index(Resumed)]
    assert not any(isinstance(event, FrameShown) for event in covered)
    assert [message for message in link.sent if isinstance(message, QuestionAnswered)] == [answer]


async def test_other_keys_do_not_answer_and_are_told_which_do(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await running(pilot, app, link, protocol)
        ask(worker)
        await read(pilot, app)
        await pilot.press("j")
        bar = app.play.query_one("#question")
        await until(pilot, lambda: "Press 1, 2, 3 or 0" in str(bar.render()))
        await pilot.press("0")
        await answered(pilot, app)
        assert str(app.play.query_one("#status").render()) == NOT_CHOSEN
        await end(pilot, app)
    (answer,) = answers(tmp_path)
    assert (answer.answer, answer.chosen) == ("none", -1)
    judged = next(
        event for event in recorded(tmp_path).events if isinstance(event, KeyPressed) and event.key == "j"
    )
    assert judged.verdict == "covered"


async def test_a_page_over_a_question_takes_it_down_and_brings_it_back(
    app: ArlApp, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await running(pilot, app, link, protocol)
        ask(worker)
        await read(pilot, app)
        await pilot.press("p")
        await until(pilot, lambda: isinstance(app.screen, PauseScreen))
        await pilot.press("1")  # no answer: nothing can be read
        await pilot.press("p")
        await read(pilot, app)
        await pilot.press("3")
        await answered(pilot, app)
        await end(pilot, app)
    (answer,) = answers(tmp_path)
    assert answer.chosen == 9
    reasons = [event.reason for event in recorded(tmp_path).events if isinstance(event, ScreenCleared)]
    assert reasons == ["question", "pause", "question"]
    resumed = [event.time_ns for event in recorded(tmp_path).events if isinstance(event, Resumed)]
    assert answer.shown_ns > resumed[1]


async def test_a_question_that_comes_under_a_page_waits_for_it(
    app: ArlApp, link: FakeLink, protocol: Protocol
) -> None:
    async with app.run_test(size=SIZE) as pilot:
        worker = await running(pilot, app, link, protocol)
        await pilot.press("p")
        await until(pilot, lambda: isinstance(app.screen, PauseScreen))
        ask(worker)
        await settle(pilot)
        assert app.live.question is None
        await pilot.press("p")
        await until(pilot, lambda: app.live.question is not None)


async def test_a_question_without_an_answer_is_taken_back(
    protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    asking = AskingConfig(per_episode=2, limit_s=0.4)
    app = app_for(msgspec.structs.replace(protocol, agent=AgentConfig(asking=asking)), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        worker = await running(pilot, app, link, protocol)
        ask(worker)
        await until(pilot, lambda: any(isinstance(sent, QuestionAnswered) for sent in link.sent))
        assert app.live.question is None
        await end(pilot, app)
    (answer,) = answers(tmp_path)
    assert (answer.answer, answer.chosen, answer.press) == ("time-limit", -1, -1)
    assert answer.time_ns - answer.shown_ns >= 0.4e9


async def test_the_first_page_says_that_there_will_be_questions(app: ArlApp, protocol: Protocol) -> None:
    async with app.run_test(size=SIZE) as pilot:
        await pilot.pause()
        text = "\n".join(str(widget.render()) for widget in app.screen.query("Static"))
        assert "answer the computer's questions" in text


@pytest.mark.parametrize(
    ("game", "reach"), [("tetris", 0.9), ("tetris", 0.3), ("keepaway", 0.9), ("gymnasium", 0.3)]
)
async def test_the_start_key_is_in_sight_in_the_smallest_window(
    game: str, reach: float, link: FakeLink, tmp_path: Path
) -> None:
    default = DEFAULTS[game]
    agent = msgspec.structs.replace(default.agent, asking=AskingConfig(per_episode=2))
    app = app_for(msgspec.structs.replace(default, agent=agent), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        link.say(Ready(warm_up_ns=1, reach=reach, step_s=0.5))  # below 0.7 comes a warning
        await pilot.pause()
        call = app.screen.query_one("#call")
        assert call.region.y < SIZE[1] - 1  # above the frame of the page
