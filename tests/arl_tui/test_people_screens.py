"""The screens of several people, and of graded feedback, in the app with a worker that is a test's."""

from collections.abc import Sequence
from pathlib import Path

import pytest
from msgspec.structs import replace
from textual.app import App, ComposeResult
from textual.containers import Vertical

from arl_tui.app.link import TakenFor
from arl_tui.screens.covers import HelpScreen, PauseScreen
from arl_tui.widgets.feedback_bar import FeedbackBar
from arl_tui.widgets.people_bar import PeopleBar
from core.events import KeyPressed, PressRetracted, StopAsked, TimeGap
from core.feedback.keys import KeyConfig
from core.feedback.people import PersonConfig
from core.session.protocol import Protocol
from tests.arl_tui.driving import SIZE, app_for, begin, recorded, settle, text_of
from tests.arl_tui.fakes import FakeLink, episode_ended, session_ended

PEOPLE = (
    PersonConfig(name="A01", good="j", bad="f", retract="u"),
    PersonConfig(name="B02", good="w", bad="p", retract="e", max_presses_per_episode=1),
    PersonConfig(name="C03", graded=("x", "c", "v", "b", "n"), retract="m"),
)
GRADED = KeyConfig(graded=("d", "f", "g", "h", "j"))


def crowd(protocol: Protocol) -> Protocol:
    return replace(protocol, people=PEOPLE, keys=KeyConfig(max_presses_per_episode=2))


def lines(bar: FeedbackBar) -> list[str]:
    return [bar.render_line(y).text.strip() for y in range(bar.size.height)]


async def test_each_person_is_answered_in_lines_of_their_own(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    app = app_for(crowd(protocol), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, crowd(protocol), steps=1)
        bar = app.play.feedback
        assert isinstance(bar, PeopleBar)
        await pilot.press("j", "p", "v")
        assert [bar.said_to(person)[0] for person in range(3)] == ["GOOD", "BAD", "NEITHER"]
        link.say(TakenFor(press=1, value=-1.0, step=0))
        await settle(pilot)
        assert bar.said_to(1) == ("BAD", "for the marked piece")
        await pilot.press("w")
        assert bar.said_to(1) == ("", "No presses left in this game: not counted")
        await pilot.press("m")
        assert bar.said_to(2)[0] == "TAKEN BACK"
        assert bar.said_to(0)[0] == "GOOD"
        shown = lines(bar)
        assert "●○  J good F bad U back" in shown
        assert "○  W good P bad E back" in shown
        assert "●●  X -- C - V 0 B + N ++ M back" in shown
        await pilot.press("z")
        assert bar.border_subtitle == "This key has no meaning here"
        app.live.give_up("end of the test")
        await settle(pilot)
    presses = [event for event in recorded(tmp_path).events if isinstance(event, KeyPressed)]
    assert [(press.key, press.person) for press in presses] == [
        ("j", 0), ("p", 1), ("v", 2), ("w", 1), ("m", 2), ("z", -1),
    ]  # fmt: skip
    back = [event for event in recorded(tmp_path).events if isinstance(event, PressRetracted)]
    assert [event.press for event in back] == [2]


async def test_a_letter_of_a_person_pauses_nothing_and_the_help_page_names_everybodys_keys(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    app = app_for(crowd(protocol), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, crowd(protocol), steps=1)
        await pilot.press("p")
        assert app.screen is app.play
        await pilot.press("f1")
        assert isinstance(app.screen, HelpScreen)
        text = "\n".join(str(part.render()) for part in app.screen.query("Static"))
        for person in PEOPLE:
            assert person.name in text
        assert "so many presses in each game: A01 2, B02 1, C03 2" in text


class OneBar(App[None]):
    """A bar in a box."""

    def __init__(self, bar: FeedbackBar, width: int) -> None:
        super().__init__()
        self.bar, self.width = bar, width

    def compose(self) -> ComposeResult:
        with Vertical() as box:
            box.styles.width = self.width
            yield self.bar


@pytest.mark.parametrize("width", [35, 53])
@pytest.mark.parametrize("n", [2, 3, 4, 5, 8])
async def test_any_number_of_people_fits_into_any_side_panel(n: int, width: int) -> None:
    letters = "abcdefghijklmnopqrstuvwxyz"
    people: Sequence[tuple[str, KeyConfig]] = [
        (f"P{k:02}", KeyConfig(good=letters[3 * k], bad=letters[3 * k + 1], retract=letters[3 * k + 2]))
        for k in range(n)
    ]
    bar = PeopleBar(people)
    async with OneBar(bar, width).run_test():
        shown = lines(bar)
        assert len(shown) == FeedbackBar.LINES_HIGH
        for name, keys in people:
            assert any(name in line for line in shown)
            assert any(keys.good.upper() in line for line in shown)
        assert {bar.render_line(y).cell_length for y in range(bar.size.height)} == {width - 2}


@pytest.mark.parametrize(
    ("key", "word"), [("d", "VERY BAD"), ("f", "BAD"), ("g", "NEITHER"), ("h", "GOOD"), ("j", "VERY GOOD")]
)
async def test_each_grade_is_answered_with_its_word(
    key: str, word: str, link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    graded = replace(protocol, keys=GRADED)
    app = app_for(graded, link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, graded, steps=1)
        await pilot.press(key)
        await settle(pilot)  # until the press is in the file
        bar = app.play.feedback
        assert (bar.word, bar.presses_left) == (word, 4)
        assert lines(bar)[-1].split() == ["d", "--", "f", "-", "g", "0", "h", "+", "j", "++", "u", "back"]
        assert app.screen is app.play  # h is a grade, not the help page
        await pilot.press("u")
        await settle(pilot)
        assert bar.word == "TAKEN BACK"


async def test_the_words_of_grades_can_be_drawn_large() -> None:
    for keys in (GRADED, KeyConfig()):
        bar = FeedbackBar(keys, hold_s=0)
        async with OneBar(bar, 90).run_test():
            for value in keys.meanings.values():
                press = KeyPressed(
                    press=0, time_ns=0, key="x", value=value, frame=0, step=0, verdict="accepted"
                )
                bar.show_press(press, 3)
                assert all(line for line in lines(bar)[:2])


async def test_a_gap_in_time_pauses_a_game_of_several_people_and_it_goes_on(
    link: FakeLink, protocol: Protocol, tmp_path: Path
) -> None:
    """Presses before, at a gap under whose page a game begins, and after it."""
    app = app_for(crowd(protocol), link, tmp_path)
    async with app.run_test(size=SIZE) as pilot:
        worker = await begin(pilot, link, crowd(protocol), steps=1)
        await pilot.press("j", "p")
        now_ns = app.live._clock.now_ns()
        gaps = [TimeGap(last_ns=now_ns, time_ns=now_ns + 1)]
        app.live.find_gap = lambda: gaps.pop() if gaps else None
        app.live.notice_gap()
        await settle(pilot)
        assert isinstance(app.screen, PauseScreen)
        await pilot.press("w")
        worker.start_episode()
        await settle(pilot)
        await pilot.press("space")
        await settle(pilot)
        assert app.screen is app.play
        app.live.uncover()
        await pilot.press("j", "x")
        bar = app.play.feedback
        assert isinstance(bar, PeopleBar)
        assert [bar.said_to(person)[0] for person in (0, 2)] == ["GOOD", "VERY BAD"]
        app.live.give_up("end of the test")
        await settle(pilot)
    verdicts = [e.verdict for e in recorded(tmp_path).events if isinstance(e, KeyPressed) and e.person >= 0]
    assert verdicts[2:] == ["covered", "accepted", "accepted"]


@pytest.mark.parametrize("several", [False, True])
async def test_practice_ends_when_everybody_has_pressed_both_keys_on_time(
    link: FakeLink, protocol: Protocol, tmp_path: Path, several: bool
) -> None:
    """What counts is the step that was on screen: a press for none is not on time."""
    played = crowd(protocol) if several else protocol
    app = app_for(played, link, tmp_path, practice=True)
    everybody = range(len(played.keys_of_people))
    async with app.run_test(size=SIZE) as pilot:
        await begin(pilot, link, played, steps=1)
        for person in everybody:
            link.say(TakenFor(press=0, value=1.0, step=0, person=person))
            link.say(TakenFor(press=1, value=-1.0, step=-1, person=person))
        link.say(episode_ended())
        await settle(pilot)
        assert app.live.phase == "running"
        for person in everybody:
            link.say(TakenFor(press=2, value=-1.0, step=0, person=person))
        link.say(episode_ended(1))
        await settle(pilot)
        assert [sent.reason for sent in link.sent if isinstance(sent, StopAsked)] == ["practised"]
        link.say(session_ended())
        await settle(pilot)
        assert "That was the practice" in text_of(app)
        assert "to go on" in text_of(app)
