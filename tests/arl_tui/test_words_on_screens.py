"""No participant's page has a word that is not in the catalogue, and every page fits in every language."""

import gettext
import re
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest
from textual.app import App
from textual.geometry import Size
from textual.screen import Screen

from arl_tui import language
from arl_tui.app.link import Preparing, TakenFor
from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.plain_app import PlainApp
from arl_tui.app.tally import Tally
from arl_tui.calibration import pages as calibration
from arl_tui.calibration.fitting import Fitted
from arl_tui.calibration.plan import TASKS, Part, Unfinished, configure
from arl_tui.calibration.texts import practice_word
from arl_tui.games.registry import BUILT_IN, screens_called, words_of
from arl_tui.language import later, tr
from arl_tui.screens.closing import ClosingScreen
from arl_tui.screens.covers import BreakScreen, HelpScreen, PauseScreen, SmallWindowScreen, StopScreen
from arl_tui.screens.practice import PracticeHelp, PracticeScreen
from arl_tui.screens.practice_keepaway import ENDS, KeeperHelp
from arl_tui.screens.welcome import WelcomeScreen
from arl_tui.study import pages as study
from arl_tui.study import words as study_words
from arl_tui.study.question_pages import QuestionPage
from arl_tui.widgets.pitch_drawing import caption_of
from core.keepaway.picture import PitchFrame, PlayerView
from core.keepaway.pitch import END_REASONS, OUT, TAKEN
from core.numerics.clock import ManualClock
from core.recording.recorder import Kept
from core.session.protocol import DEFAULTS, Protocol
from studies.lab.questions import Choice, FreeText, Likert, Number, Scale
from studies.reaction_time.protocol import TrialRecord
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.driving import app_for, begin, settle
from tests.arl_tui.fakes import FakeLink, episode_ended
from tests.arl_tui.test_participants import task_delay

ASIDE = re.compile(r"\{[^}]*\}|\[[^\]]*\]")
PSEUDO = str.maketrans(
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ",
    "αβγδεζηθικλμνξοπρστυφχψωϐϑΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩΆΈ",
)
"""Every letter becomes another one: what is still Latin was not looked up."""
NOT_WORDS = {"P01", "F1"}


class Pseudo(gettext.NullTranslations):
    """A language in which no word has a Latin letter; placeholders and markup stay."""

    def gettext(self, message: str) -> str:
        kept = ASIDE.findall(message)
        parts = [part.translate(PSEUDO) for part in ASIDE.split(message)]
        return "".join(part + aside for part, aside in zip(parts, [*kept, ""], strict=True))

    def ngettext(self, msgid1: str, msgid2: str, n: int) -> str:
        return self.gettext(msgid1 if n == 1 else msgid2)


@pytest.fixture
def pseudo(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(language, "catalogue_of", lambda code: Pseudo())
    # Big letters are drawn, and exist in those that languages need.
    monkeypatch.setattr("arl_tui.widgets.feedback_bar.big", lambda word, narrow=False: (word,) * 3)
    language.use("en")


class Shown(PlainApp[None]):
    """Shows pages."""

    CSS_PATH = Path(language.__file__).parent / "app.tcss"


def drawn(app: App) -> str:
    return "\n".join(strip.text for strip in app.screen._compositor.render_strips())


def latin(text: str) -> list[str]:
    return [word for word in re.findall(r"[A-Za-z][A-Za-z0-9]{2,}", text) if word not in NOT_WORDS]


def schedule(task: str):
    (config,) = configure([task])
    return make_schedule(config, 3)


TALLY = Tally(
    performances=[0.0, 3.0],
    unseen=200,
    practised=[1.0, 2.0],
    good=2,
    bad=1,
    taken_back=1,
    weight=0.2,
    steps=28,
)
PARTS = [Part(schedule(name)) for name in TASKS]
FITTED = Fitted(delays=(task_delay(n_observed=12),), failures={"feedback lag": "x"})


def welcome(game: str, *, wrong: float = 0.0, **options) -> Callable[[], Screen]:
    protocol = DEFAULTS[game]
    protocol = msgspec.structs.replace(
        protocol, keys=msgspec.structs.replace(protocol.keys, wrong_press_rate=wrong)
    )
    return lambda: WelcomeScreen(protocol, "P01", **{"simulated": False, **options})


PAGES: dict[str, Callable[[], Screen]] = {
    **{f"welcome-{game}": welcome(game) for game in BUILT_IN},
    "welcome-practice": welcome("tetris", practice=True),
    "welcome-in-a-part": welcome("tetris", part="2/3"),
    "welcome-going-on": welcome("tetris", games_done=1),
    "welcome-wrong": welcome("tetris", wrong=0.1),
    "welcome-simulated": welcome("tetris", simulated=True),
    **{
        f"help-{game}": lambda game=game: HelpScreen(
            DEFAULTS[game], screens_called(game).words_for(DEFAULTS[game])
        )
        for game in BUILT_IN
    },
    "pause": lambda: PauseScreen(gap_s=12.0),
    "stop": StopScreen,
    "break-in-session": lambda: BreakScreen(3, 9),
    "small-window": lambda: SmallWindowScreen(Size(90, 30)),
    "closing": lambda: ClosingScreen(
        SessionOutcome(Path("x"), TALLY, kept=Kept(recorded=9, written=9, synced=9)),
        words_of("tetris"),
        show_weight=True,
    ),
    "closing-practice": lambda: ClosingScreen(
        SessionOutcome(Path("x"), TALLY), words_of("keepaway"), practice=True
    ),
    "closing-in-a-study": lambda: ClosingScreen(
        SessionOutcome(Path("x"), TALLY), words_of("tetris"), in_study=True
    ),
    "closing-lost": lambda: ClosingScreen(
        SessionOutcome(Path("x"), TALLY, kept=Kept(recorded=9, written=7, synced=5)), words_of("gymnasium")
    ),
    "closing-nothing": lambda: ClosingScreen(SessionOutcome(None, Tally()), words_of("tetris")),
    "play-yourself": PracticeScreen,
    "help-yourself-tetris": lambda: PracticeHelp(3),
    "help-yourself-keepaway": lambda: KeeperHelp(3, 3),
    "hindrance": lambda: calibration.HindrancePage(
        [later("a network connection (SSH)"), later("a terminal multiplexer (tmux)")]
    ),
    "old": lambda: calibration.OldSessionPage(Unfinished(tuple(PARTS), 3, 30.0)),
    "calibration": lambda: calibration.WelcomePage(PARTS[:3], "P01", resumed=True),
    **{
        f"instruction-{name}": lambda part=part: calibration.InstructionPage(
            part.schedule, part.schedule.blocks[0], resumed=False
        )
        for name, part in zip(TASKS, PARTS, strict=True)
    },
    "scored": lambda: calibration.InstructionPage(
        PARTS[0].schedule, PARTS[0].schedule.blocks[-1], resumed=False
    ),
    "rest": lambda: calibration.BreakPage(10, 40),
    "trial-pause": calibration.PausePage,
    "summary": lambda: calibration.SummaryPage(FITTED, finished=False, trouble=None),
    "study-stop": lambda: study.StopPage("P01"),
    "decline": study.DeclinePage,
    "consent": lambda: study.ConsentPage("1.", ["1"], ["2"], code="P01", part="1"),
    "break": lambda: study.BreakPage("", shortest_s=9, longest_s=99, code="P01", clock=ManualClock(0)),
    "notice": lambda: study.NoticePage(tr(study_words.THANKS), "", ["1"], code="P01"),
    **{
        f"question-{kind}": lambda question=question: QuestionPage(
            question, number=1, count=2, code="P01", clock=ManualClock(0)
        )
        for kind, question in {
            "likert": Likert(id="l", text="1?", points=7),
            "scale": Scale(id="s", text="1?", low="1", high="2"),
            "choice": Choice(id="c", text="1?", options=("1", "2")),
            "several": Choice(id="m", text="1?", options=("1", "2"), several=True),
            "number": Number(id="n", text="1?", lowest=1, highest=2),
            "optional": FreeText(id="o", text="1?", required=False),
            "text": FreeText(id="t", text="1?"),
        }.items()
    },
}


async def test_no_word_of_a_page_is_outside_the_catalogue(pseudo: None) -> None:
    found: dict[str, list[str]] = {}
    app = Shown()
    async with app.run_test(size=(120, 50)) as pilot:
        for name, page in PAGES.items():
            await app.push_screen(page())
            if name in ("question-likert", "question-number", "question-text"):
                await pilot.press("enter")  # it says what is missing
            await pilot.pause()
            if words := latin(drawn(app)):
                found[name] = words
            if app.screen.is_modal or len(app.screen_stack) > 1:
                app.pop_screen()
    assert found == {}


@pytest.mark.parametrize("code", language.LANGUAGES)
async def test_every_page_fits_into_the_smallest_window(code: str) -> None:
    too_long: dict[str, str] = {}
    app = Shown(language=code)
    async with app.run_test(size=(80, 24)) as pilot:
        for name, make in PAGES.items():
            if name.startswith(("question", "play-", "welcome-wrong", "welcome-simulated")):
                continue
            await app.push_screen(make())
            await pilot.pause()
            if any(page.max_scroll_y > 0 for page in app.screen.query(".page")):
                too_long[name] = drawn(app)
            app.pop_screen()
    assert list(too_long) == [], "\n".join(too_long.values())


async def test_no_word_of_a_session_is_outside_the_catalogue(
    pseudo: None, monkeypatch: pytest.MonkeyPatch, protocol: Protocol, link: FakeLink, tmp_path: Path
) -> None:
    protocol = msgspec.structs.replace(
        protocol, screen=msgspec.structs.replace(protocol.screen, show_weight=True)
    )
    monkeypatch.setattr("arl_tui.app.gaps.GapWatch.look", lambda self: None)  # a busy machine is no gap
    app = app_for(protocol, link, tmp_path)
    async with app.run_test(size=(120, 40)) as pilot:
        link.say(Preparing(compiled=3, needed=10, fraction=0.3))
        await settle(pilot)
        assert latin(drawn(app)) == []
        worker = await begin(pilot, link, protocol, steps=1)
        for key in ("j", "j", "f", "x", "u"):
            await pilot.press(key)
            if key == "j":
                link.say(TakenFor(press=0, value=1.0, step=0, place=((0, 0),)))
            await settle(pilot)
            assert latin(drawn(app)) == [], key
        app.play.feedback.show_saving(True)
        app.play.feedback.ask_wrong(True)
        app.play.show_silence(3.0)
        await settle(pilot)
        assert latin(drawn(app)) == []
        app.play.show_silence(None)
        link.say(episode_ended())
        worker.show(1, worker.renderer.picture)
        await settle(pilot)
        assert latin(drawn(app)) == []


@pytest.mark.parametrize("status", ["ok", "anticipation", "time-out", "wrong key", "repeat"])
@pytest.mark.parametrize("task", ["simple", "feedback lag"])
def test_no_word_after_a_practice_trial_is_outside_the_catalogue(
    pseudo: None, status: str, task: str
) -> None:
    record = TrialRecord(
        trial=0,
        block=0,
        task=task,
        practice=True,
        catch=False,
        condition="",
        stimulus="",
        expected_keys=("j",),
        foreperiod_s=1.0,
        started_ns=0,
        asked_ns=1,
        flushed_ns=2,
        key="j",
        key_ns=3,
        rt_s=0.3,
        status=status,
        early_presses=0,
        other_presses=0,
        frame_interval_ns=1,
        time_out_s=1.0,
        ended_ns=4,
    )
    nothing = msgspec.structs.replace(record, expected_keys=())
    words = [practice_word(each) for each in (record, nothing, msgspec.structs.replace(nothing, key=None))]
    words.append(practice_word(msgspec.structs.replace(nothing, catch=True)))
    assert latin(re.sub(r"\[[^\]]*\]", "", " ".join(words))) == []


@pytest.mark.parametrize(
    ("changes", "caption"),
    [
        ({"ended": OUT, "time_s": 3.0}, "Ball im Aus nach 3.0 s"),
        ({"ended": TAKEN, "time_s": 3.0}, "Ball verloren nach 3.0 s"),
        ({"decider": 0, "target": 1}, "K1 passt zu K2"),
        ({"holder": 0}, "K1 hat den Ball"),
        ({}, "Ball ist frei"),
    ],
)
def test_captions_of_the_pitch_are_those_of_the_picture(changes: dict, caption: str) -> None:
    players = tuple(PlayerView(float(k), 0.0, 0.0) for k in range(5))
    frame = PitchFrame(length_m=20.0, width_m=20.0, n_keepers=3, players=players, ball=(0.0, 0.0), **changes)
    assert caption_of(frame) == frame.caption()
    language.use("de")
    assert caption_of(frame) == caption


def test_the_ends_of_an_episode_are_those_of_the_game():
    assert ENDS == END_REASONS


def test_the_ends_of_a_likert_row_are_those_of_the_question():
    question = Likert(id="l", text="1?")
    assert (question.low, question.high) == study_words.ENDS_OF_A_LIKERT_ROW
