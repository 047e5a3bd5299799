"""Leading a participant through a sitting: what is asked, in which order, and what is left on the disk."""

import pytest

from arl_tui.study.pages import BreakPage, ConsentPage, NoticePage, TextPage
from arl_tui.study.presenter import Played
from arl_tui.study.question_pages import Answered, QuestionPage
from arl_tui.study.run import run_sitting
from core.numerics.clock import ManualClock
from studies.lab.enrolment import NotNow, enrol
from studies.lab.folder import participant_folder
from studies.lab.ledger import Declined, Enrolled, Ledger, SittingEnded
from studies.lab.progress import progress
from studies.lab.questions import Choice, FreeText, Likert, Number
from studies.lab.read import load_study
from studies.lab.sitting_log import ConsentAnswered, FileRecorded, QuestionAnswered, StepEnded, read_sitting

STUDY = """
name = "small"
seed = 5
participants = 4
[protocol.session]
episodes = 2
[conditions.linear.agent.scheme]
type = "linear"
[conditions.annealed.agent.scheme]
type = "annealed"
[assignment]
type = "latin-square"
[[sittings]]
name = "day 1"
steps = [
  { type = "page", text = "hello.md" },
  { type = "consent", text = "consent.md", statements = ["I agree."], optional = ["Share it."], version = "2" },
  { type = "block" },
  { type = "break", shortest_s = 1 },
  { type = "block" },
  { type = "questionnaire", questions = "trust" },
  { type = "debriefing", text = "thanks.md" },
]
"""  # noqa: E501
AGREES = {"I agree.": True, "Share it.": False}


class Scripted:
    """A participant who agrees and answers everything, unless told otherwise."""

    def __init__(self, clock, *, consent=AGREES, leave_at=None, plays=None):
        self.clock = clock
        self.consent = consent
        self.leave_at = leave_at
        """A kind of page that is left with None, or "close" for a closed window at the first question."""
        self.plays = plays or {}
        """Condition to how its block ends."""
        self.shown = []
        self.calls = []

    def pages(self, pages, on_result=lambda number, result: None):
        results = []
        for number, make in enumerate(pages):
            page = make()
            self.shown.append(type(page).__name__)
            result = self.answer(page)
            on_result(number, result)
            results.append(result)
            if result is None or result is False:
                break
        return results, False

    def answer(self, page):
        self.clock.advance_ns(1)
        if self.leave_at == type(page).__name__:
            return None
        if isinstance(page, ConsentPage):
            return self.consent
        if isinstance(page, QuestionPage):
            question = page.question
            match question:
                case Likert():
                    answer = 4
                case Choice():
                    answer = question.options[0]
                case Number():
                    answer = question.lowest
                case FreeText():
                    answer = "words"
            return Answered(answer, 1, 2)
        assert isinstance(page, TextPage | BreakPage | NoticePage)
        return True

    def play(self, call):
        self.calls.append(call)
        how = self.plays.get(call.condition, "finished")
        return Played(how=how, file=f"{call.condition}.jsonl", games=(1.0, 3.0), presses=4, unit="lines")


@pytest.fixture
def clock():
    return ManualClock()


@pytest.fixture
def loaded(tmp_path):
    for name in ("hello", "consent", "thanks"):
        (tmp_path / f"{name}.md").write_text(f"# {name}\n")
    (tmp_path / "study.toml").write_text(STUDY)
    return load_study(tmp_path / "study.toml")


@pytest.fixture
def ledger(tmp_path, loaded):
    return Ledger(tmp_path / "data", study="small", seed=5)


def run(loaded, ledger, presenter, code="P1"):
    return run_sitting(loaded, ledger, code, presenter, software={"arl-tui": "test"}, clock=presenter.clock)


def log_of(ledger, attempt=""):
    return read_sitting(participant_folder(ledger.folder, "P1") / f"sitting-1{attempt}.jsonl")


def test_a_participant_goes_from_consent_to_thanks_in_the_order_of_their_place(loaded, ledger, clock):
    presenter = Scripted(clock)
    result = run(loaded, ledger, presenter)
    assert result.how == "finished"
    person = progress(ledger.lines()).participants["P1"]
    assert [call.condition for call in presenter.calls] == list(person.order)
    header, lines = log_of(ledger)
    assert (header.order, header.place) == (person.order, 0)
    assert [line.step for line in lines if isinstance(line, StepEnded)] == list(range(7))
    assert sum(isinstance(line, QuestionAnswered) for line in lines) == len(
        loaded.questionnaires["trust"].questions
    )


def test_blocks_have_seeds_of_their_own_and_say_where_they_belong(loaded, ledger, clock):
    presenter = Scripted(clock)
    run(loaded, ledger, presenter)
    first, second = presenter.calls
    assert first.seed != second.seed
    assert (first.facts["condition"], first.facts["place"], first.facts["step"]) == (
        first.condition,
        "0",
        "2",
    )


def test_consent_is_recorded_with_text_version_and_every_answer(loaded, ledger, clock):
    run(loaded, ledger, Scripted(clock))
    consent = next(line for line in log_of(ledger)[1] if isinstance(line, ConsentAnswered))
    assert (consent.text, consent.text_version, consent.answers) == ("# consent\n", "2", AGREES)


def test_who_declines_leaves_nothing_but_a_count(loaded, ledger, clock):
    result = run(loaded, ledger, Scripted(clock, consent=False))
    assert result.how == "declined"
    assert [type(line) for line in ledger.lines()[1:]] == [Declined]
    assert not (ledger.folder / "participants").exists()


def test_who_leaves_before_consent_leaves_nothing_at_all(loaded, ledger, clock):
    result = run(loaded, ledger, Scripted(clock, leave_at="TextPage"))
    assert result.how == "nothing"
    assert len(ledger.lines()) == 1
    assert not (ledger.folder / "participants").exists()


def test_a_stopped_sitting_says_so_and_goes_on_where_it_was_left(loaded, ledger, clock):
    first = Scripted(clock, leave_at="BreakPage")
    assert run(loaded, ledger, first).how == "stopped"
    ended = [line for line in ledger.lines() if isinstance(line, SittingEnded)]
    assert [line.how for line in ended] == ["stopped"]
    second = Scripted(clock)
    assert run(loaded, ledger, second).how == "finished"
    assert second.shown[0] == "BreakPage"
    assert [call.condition for call in first.calls + second.calls] == list(
        progress(ledger.lines()).participants["P1"].order
    )
    assert sum(isinstance(line, Enrolled) for line in ledger.lines()) == 1
    assert log_of(ledger, "-attempt-2")[0].attempt == 1


def test_a_block_that_ends_early_is_not_done(loaded, ledger, clock):
    order = None

    class Closes(Scripted):
        def play(self, call):
            nonlocal order
            order = call.condition
            super().play(call)
            return Played(how="window-closed", file="cut.jsonl")

    assert run(loaded, ledger, Closes(clock)).how == "window-closed"
    files = [line for line in log_of(ledger)[1] if isinstance(line, FileRecorded)]
    assert [(line.file, line.ended) for line in files] == [("cut.jsonl", "window-closed")]
    again = Scripted(clock)
    run(loaded, ledger, again)
    assert again.calls[0].condition == order


def test_an_answer_is_on_the_disk_before_the_next_question_comes(loaded, ledger, clock):
    class Killed(Scripted):
        asked = 0

        def answer(self, page):
            if isinstance(page, QuestionPage):
                self.asked += 1
                if self.asked == 3:
                    raise KeyboardInterrupt
            return super().answer(page)

    with pytest.raises(KeyboardInterrupt):
        run(loaded, ledger, Killed(clock))
    assert sum(isinstance(line, QuestionAnswered) for line in log_of(ledger)[1]) == 2


def test_the_last_page_shows_ones_own_numbers_but_not_the_condition(loaded, ledger, clock):
    pages = []

    class Keeps(Scripted):
        def answer(self, page):
            pages.append(page)
            return super().answer(page)

    run(loaded, ledger, Keeps(clock))
    remarks = " ".join(pages[-1]._remarks)
    assert "[b]4[/] games" in remarks
    assert "[b]8[/] keys" in remarks
    assert not any(name in remarks for name in loaded.study.conditions)


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("P/1", "code has up to 32 letters"),
        ("..", "letters, digits"),
        ("p1", "P1 takes part already"),
    ],
)
def test_a_new_participant_s_code_is_checked_before_anything_is_shown(loaded, ledger, code, reason):
    enrol(loaded.study, ledger, "P1")
    clock = ManualClock()
    presenter = Scripted(clock)
    with pytest.raises(NotNow, match=reason):
        run_sitting(loaded, ledger, code, presenter, software={}, clock=clock)
    assert presenter.shown == []
    assert not (ledger.folder / "participants").exists()


def test_codes_of_earlier_participants_go_on_as_they_are(loaded, ledger):
    enrol(loaded.study, ledger, "J \u00fc")
    clock = ManualClock()
    assert (
        run_sitting(loaded, ledger, "J \u00fc", Scripted(clock), software={}, clock=clock).how == "finished"
    )
