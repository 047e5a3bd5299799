"""The viewer names a question's options, its answer and who gave it, and whose press it shows."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from arl_tui.viewer.asked import question_lines
from core.combination.config import AgentConfig, AskingConfig
from core.events import Event, QuestionAnswered, QuestionPosed, Resumed, ScreenCleared
from core.feedback.config import TrainerConfig
from core.feedback.delays import UniformDelay
from core.feedback.people import PersonConfig
from core.recording.reader import read_recording
from core.session.protocol import Protocol
from studies.session_view.questions import question_near
from studies.session_view.session import open_session
from tests.arl_tui.test_viewer import Looking
from tests.core.sessions import simulated, small_protocol
from tests.studies.session_view.made import MS, ended, started, taken, write

PEOPLE = (
    PersonConfig(name="A01", good="j", bad="f", retract="u"),
    PersonConfig(name="B02", good="w", bad="s", retract="e"),
)
DETAILS = [{"piece": 1, "orientation": 0, "column": column} for column in (0, 3)]


def posed(time_ns: int) -> QuestionPosed:
    return QuestionPosed(
        question=0,
        episode=0,
        step=1,
        time_ns=time_ns,
        inputs=0,
        options=[4, 9],
        details=DETAILS,
        disagreement=0.5,
    )


def asked(*after: Event) -> list[Event]:
    return [
        started(900 * MS),
        taken(990 * MS, 0, 0),
        posed(2000 * MS),
        ScreenCleared(time_ns=2100 * MS, reason="question"),
        *after,
    ]


ANSWERED = QuestionAnswered(
    question=0, shown_ns=2150 * MS, time_ns=4650 * MS, answer="chosen", chosen=9, press=0
)


@pytest.mark.parametrize(
    ("answer", "last", "chosen"),
    [
        (ANSWERED, "Answered after 2.50 s", 2),
        (msgspec.structs.replace(ANSWERED, answer="none", chosen=-1), "None of these after 2.50 s", None),
        (
            msgspec.structs.replace(ANSWERED, answer="time-limit", chosen=-1, press=-1),
            "No answer within the limit",
            None,
        ),
        (None, "The recording ends before an answer", None),
    ],
)
async def test_options_and_answer_are_written_in_words(
    tmp_path: Path, answer: QuestionAnswered | None, last: str, chosen: int | None
) -> None:
    rest = [] if answer is None else [answer, Resumed(time_ns=4700 * MS), ended(9000 * MS)]
    path = write(tmp_path / "asked.jsonl", asked(*rest), complete=bool(rest), protocol=Protocol())
    viewing = Looking(path, tmp_path, thinks=False).viewing
    lines = [
        "".join(text for text, _ in line) for line in question_lines(viewing, viewing.session.at(2200 * MS))
    ]
    marks = ["  ◀" if row == chosen else "" for row in (1, 2)]
    assert lines == [
        "Question 1  before step 1",
        f" 1  columns 1 to 2{marks[0][1:]}",
        f" 2  columns 4 to 5{marks[1][1:]}",
        last,
    ]
    assert question_lines(viewing, viewing.session.at(1500 * MS)) == []
    if answer is not None:
        assert question_lines(viewing, viewing.session.at(8000 * MS)) == []


def test_the_index_finds_every_question_and_its_answer(tmp_path: Path) -> None:
    asking = AskingConfig(per_episode=3, share=0.5, minimum_decisions=3, memory=50)
    protocol = small_protocol(agent=AgentConfig(asking=asking))
    simulated(tmp_path, protocol)
    path = tmp_path / "session-5.jsonl"
    recording = read_recording(path)
    every = [output for output in recording.outputs if isinstance(output, QuestionPosed)]
    answers = {event.question: event for event in recording.events if isinstance(event, QuestionAnswered)}
    assert every
    session = open_session(path)
    found = [question_near(session, question.time_ns) for question in every]
    assert found == [(question, answers.get(question.question)) for question in every]
    assert question_near(session, every[0].time_ns - 1) is None


async def test_a_press_of_several_participants_has_the_code_of_who_pressed(tmp_path: Path) -> None:
    eager = TrainerConfig(press_probability=0.9, max_presses=15, delay=UniformDelay(0.2, 0.4))
    protocol = small_protocol(people=PEOPLE, trainer=eager)
    simulated(tmp_path, protocol)
    looking = Looking(tmp_path / "session-5.jsonl", tmp_path, thinks=False)
    presses = looking.viewing.session.presses
    async with looking.app.run_test(size=(80, 24)) as pilot:
        for person, code in enumerate(("A01", "B02")):
            row = int(np.flatnonzero(presses["person"] == person)[0])
            looking.screen.transport.seek(int(presses["time"][row]))
            looking.screen.draw()
            await pilot.pause()
            text = "\n".join(strip.text for strip in looking.screen._compositor.render_strips())
            assert f"simulated  {code}" in text
