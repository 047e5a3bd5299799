"""The study's own pages: keys do what the last line says, and nothing is answered before it was on screen."""

import pytest

from arl_tui.study.own_numbers import Numbers, own_numbers
from arl_tui.study.page_app import PageApp
from arl_tui.study.pages import BreakPage, ConsentPage, NoticePage, TextPage
from arl_tui.study.question_pages import QuestionPage
from core.numerics.clock import ManualClock, MonotonicClock
from studies.lab.questions import Choice, FreeText, Likert, Number, Press, Scale

LONG = "\n\n".join(f"Paragraph {number}." for number in range(40))


async def results_of(pages, keys, size=(80, 24)):
    app = PageApp(pages)
    async with app.run_test(size=size) as pilot:
        await pilot.pause(0.3)
        for key in keys:
            await pilot.press(key)
            await pilot.pause()
    return app.results


def consent(text="Short."):
    return [lambda: ConsentPage(text, ["I agree."], ["Share it."], code="P1")]


async def test_a_short_text_is_left_with_enter():
    assert await results_of([lambda: TextPage("Short.", code="P1")], ["enter"]) == [True]


async def test_enter_reads_on_until_all_of_a_long_text_was_on_screen():
    assert await results_of([lambda: TextPage(LONG, code="P1")], ["enter"]) == []
    assert await results_of([lambda: TextPage(LONG, code="P1")], ["enter"] * 12) == [True]


async def test_stopping_asks_first():
    page = [lambda: TextPage("Short.", code="P1")]
    assert await results_of(page, ["q", "n"]) == []
    assert await results_of(page, ["q", "y"]) == [None]


async def test_consent_needs_an_answer_to_every_statement():
    assert await results_of(consent(), ["enter"]) == []
    assert await results_of(consent(), ["y", "enter"]) == []
    assert await results_of(consent(), ["y", "n", "enter"]) == [{"I agree.": True, "Share it.": False}]


async def test_statements_cannot_be_answered_before_the_text_was_on_screen():
    assert await results_of(consent(LONG), ["y", "y", "enter"]) == []


async def test_not_agreeing_to_what_is_needed_declines_after_a_question():
    assert await results_of(consent(), ["n", "y", "enter"]) == []
    assert await results_of(consent(), ["n", "y", "enter", "enter"]) == [False]
    assert await results_of(consent(), ["n", "y", "enter", "b", "up", "up", "y", "enter"]) == [
        {"I agree.": True, "Share it.": True}
    ]


async def test_a_break_cannot_be_left_before_its_shortest_time():
    assert (
        await results_of(
            [lambda: BreakPage("", shortest_s=60, longest_s=90, code="P1", clock=MonotonicClock())], ["enter"]
        )
        == []
    )
    assert await results_of(
        [lambda: BreakPage("", shortest_s=0, longest_s=90, code="P1", clock=MonotonicClock())], ["enter"]
    ) == [True]


async def test_thanks_can_be_left_by_any_of_its_keys():
    for key in ("enter", "q"):
        assert await results_of([lambda: NoticePage("Thanks", "", ["P1"], code="P1")], [key]) == [True]


LIKERT = Likert(id="l", text="It [was] easy.", points=7)
SCALE = Scale(id="s", text="How hard?", low="easy", high="hard", step=5)
CHOICE = Choice(id="c", text="Which?", options=("one", "two", "three"))
SEVERAL = Choice(id="m", text="Which?", options=("one", "two", "three"), several=True)
NUMBER = Number(id="n", text="How old?", lowest=18, highest=99, required=False)
TEXT = FreeText(id="t", text="Why?")


@pytest.mark.parametrize(
    ("question", "keys", "answer"),
    [
        (LIKERT, ["5", "enter"], 5),
        (LIKERT, ["right", "right", "enter"], 5),
        (LIKERT, ["left", "enter"], 4),
        (LIKERT, ["9", "2", "enter"], 2),
        (SCALE, ["right", "enter"], 55),
        (SCALE, ["left", "left", "enter"], 40),
        (CHOICE, ["2", "enter"], "two"),
        (CHOICE, ["down", "down", "enter"], "three"),
        (SEVERAL, ["1", "3", "enter"], ("one", "three")),
        (SEVERAL, ["space", "down", "space", "space", "enter"], ("one",)),
        (NUMBER, ["1", "9", "enter"], 19.0),
        (NUMBER, ["ctrl+n"], None),
        (TEXT, ["n", "q", "enter"], "nq"),
    ],
)
async def test_questions_are_answered_with_the_keyboard(question, keys, answer):
    page = [lambda: QuestionPage(question, number=1, count=1, code="P1", clock=ManualClock(7))]
    results = await results_of(page, keys)
    assert [(result.answer, result.shown_ns) for result in results] == [(answer, 7)]


@pytest.mark.parametrize(
    ("question", "keys"),
    [
        (LIKERT, ["enter"]),
        (SCALE, ["enter"]),
        (CHOICE, ["enter"]),
        (TEXT, ["enter"]),
        (NUMBER, ["1", "enter"]),
    ],
)
async def test_no_question_is_left_without_an_allowed_answer(question, keys):
    page = [lambda: QuestionPage(question, number=1, count=1, code="P1", clock=ManualClock())]
    assert await results_of(page, keys) == []


async def test_a_result_is_handed_over_before_the_next_page_comes():
    seen = []
    pages = [lambda: TextPage("One.", code="P1"), lambda: TextPage("Two.", code="P1")]
    app = PageApp(pages, on_result=lambda number, result: seen.append((number, len(app.results))))
    async with app.run_test() as pilot:
        await pilot.pause(0.3)
        await pilot.press("enter")
        await pilot.pause(0.3)
        await pilot.press("enter")
    assert seen == [(0, 0), (1, 1)]


PRESS = Press(id="p", text="Please press K now.", key="k")


@pytest.mark.parametrize(("keys", "answer"), [(["k"], "k"), (["enter", "space", "K"], "k"), (["j"], "j")])
async def test_an_instructed_press_is_answered_by_the_first_letter(keys, answer):
    page = [lambda: QuestionPage(PRESS, number=1, count=1, code="P1", clock=ManualClock())]
    (result,) = await results_of(page, keys)
    assert result.answer == answer


def test_the_last_page_tells_one_s_own_numbers_block_by_block():
    one = Numbers(blocks=[(0.0, 1.0, 2.0, 6.0, 5.0, 10.0)], presses=7, taken_back=2, unit="lines")
    assert list(own_numbers(one)) == [
        "You watched [b]6[/] games and pressed [b]7[/] keys that counted. You took [b]2[/] presses back.",
        "Lines per game at the beginning: [b]0.5[/]. At the end: [b]7.5[/].",
    ]
    two = Numbers(blocks=[(1.0,), (2.0, 4.0)], presses=1, unit="lines")
    assert list(own_numbers(two))[1].splitlines() == [
        "Block 1: lines per game at the beginning [b]1[/], at the end [b]1[/].",
        "Block 2: lines per game at the beginning [b]2[/], at the end [b]4[/].",
    ]
    assert list(own_numbers(Numbers())) == []


async def test_every_word_of_a_long_statement_of_consent_is_on_screen():
    statement = "I have read this page to its very end and all of my questions have been answered."
    app = PageApp([lambda: ConsentPage("Short.", [statement], [], code="P1")])
    async with app.run_test(size=(80, 24)) as pilot:
        await pilot.pause(0.3)
        drawn = [line.text for line in app.screen._compositor.render_strips()]
    assert statement in " ".join(" ".join(drawn).replace("│", " ").split())
