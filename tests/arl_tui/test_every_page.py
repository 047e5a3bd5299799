"""Every page that a participant meets, as it looks: 80x24 dark in every run, the other windows by `-m slow`.

Where the environment variable ARL_PICTURES names a folder, each page is also saved there as a PNG file.
"""

import hashlib
import os
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from textual.app import App
from textual.pilot import Pilot
from textual.screen import Screen

from arl_tui.app.link import Practised, Preparing, Ready, TakenFor
from arl_tui.app.outcome import SessionOutcome
from arl_tui.app.session_setup import SessionSetup
from arl_tui.app.tally import Tally
from arl_tui.calibration import pages as calibration
from arl_tui.calibration.plan import new_parts
from arl_tui.games.registry import words_of
from arl_tui.palette import palette_for
from arl_tui.screens import covers
from arl_tui.screens.closing import ClosingScreen
from arl_tui.session_app import build_app
from arl_tui.study.page_app import PageApp
from arl_tui.study.pages import BreakPage, ConsentPage, DeclinePage, NoticePage, StopPage, TextPage
from arl_tui.study.question_pages import QuestionPage
from arl_tui.viewer.raster import Cells, picture_of
from arl_tui.viewer.screenshot import screen_cells
from core.feedback.keys import KeyConfig
from core.keepaway.plugin import KEEPAWAY
from core.numerics.clock import ManualClock
from core.session.protocol import Protocol, ScreenConfig, SessionConfig
from studies.lab.questions import Choice, FreeText, Likert, Number, Scale
from tests.arl_tui.calibrating import quick, setup
from tests.arl_tui.driving import Worker, settle
from tests.arl_tui.fakes import FakeLink, episode_ended, episode_started
from tests.arl_tui.pitches import HOLDING, PASSING
from tests.arl_tui.test_play_keepaway import Worker as KeepawayWorker

TETRIS = Protocol(
    keys=KeyConfig(max_presses_per_episode=5),
    session=SessionConfig(episodes=5, unseen_between=100),
    screen=ScreenConfig(count_down_s=3),
)
KEEPAWAY_20 = msgspec.structs.replace(
    KEEPAWAY, screen=msgspec.structs.replace(KEEPAWAY.screen, reduced_motion=True, count_down_s=0)
)
NOW = msgspec.structs.replace(TETRIS, screen=ScreenConfig(count_down_s=0, reduced_motion=True))
CONSENT = "\n\n".join(["# Information", "You watch a computer play and judge it by key presses."] * 3)
Drive = Callable[[Pilot[Any], FakeLink], Awaitable[None]]
CODE = "P7K2"


async def nothing(pilot: Pilot[Any], link: FakeLink) -> None:
    await pilot.pause()


async def unchanging(pilot: Pilot[Any]) -> None:
    """Wait until all that was said has been drawn: until three looks in a row see the same."""
    seen: list[Cells] = []
    while len(seen) < 3 or seen[-3:] != [seen[-1]] * 3:
        await pilot.pause(0.1)
        seen.append(screen_cells(pilot.app))
        assert len(seen) < 100, "the screen keeps changing"


async def ready(pilot: Pilot[Any], link: FakeLink) -> None:
    link.say(Ready(warm_up_ns=1, reach=0.92, step_s=1.6))
    await pilot.pause()


async def overview(pilot: Pilot[Any], link: FakeLink) -> None:
    await ready(pilot, link)
    await pilot.press("f2")
    await pilot.pause()


async def preparing(pilot: Pilot[Any], link: FakeLink) -> None:
    link.say(Preparing(compiled=12, needed=40, fraction=0.3))
    await pilot.press("enter")
    await pilot.pause()


async def begun(pilot: Pilot[Any], link: FakeLink) -> Worker:
    await ready(pilot, link)
    await pilot.press("enter")
    await pilot.pause()
    worker = Worker(link, NOW)
    worker.start_episode()
    await settle(pilot)
    for step, column in enumerate((0, 4, 7, 2)):
        worker.step(step, column=column)
        await settle(pilot)
    await unchanging(pilot)
    return worker


async def tetris(pilot: Pilot[Any], link: FakeLink) -> None:
    await begun(pilot, link)


async def marked(pilot: Pilot[Any], link: FakeLink) -> None:
    await begun(pilot, link)
    await pilot.press("j")
    link.say(TakenFor(press=0, value=1.0, step=2, place=((0, 7), (0, 8), (1, 7), (1, 8))))
    await settle(pilot)


async def used_up(pilot: Pilot[Any], link: FakeLink) -> None:
    await begun(pilot, link)
    for _ in range(5):
        await pilot.press("f")
        await pilot.pause(0.3)
    await pilot.pause(1.6)
    await unchanging(pilot)


async def practising(pilot: Pilot[Any], link: FakeLink) -> None:
    await begun(pilot, link)
    link.say(episode_ended(performance=3.0), Practised(done=38, count=100))
    await settle(pilot)


async def keepaway(pilot: Pilot[Any], link: FakeLink) -> None:
    await ready(pilot, link)
    await pilot.press("enter")
    await pilot.pause()
    worker = KeepawayWorker(link)
    link.say(episode_started())
    worker.show(-1, HOLDING)
    worker.decide(0)
    worker.show(0, PASSING)
    await settle(pilot)


async def keepaway_between(pilot: Pilot[Any], link: FakeLink) -> None:
    await keepaway(pilot, link)
    link.say(episode_ended(performance=9.3), Practised(done=7, count=20))
    await settle(pilot)


def session(protocol: Protocol, **facts: Any) -> Callable[[Path, FakeLink], App[Any]]:
    def make(folder: Path, link: FakeLink) -> App[Any]:
        given = SessionSetup(protocol=protocol, root_seed=5, participant=CODE, recordings=folder, **facts)
        return build_app(given, link)

    return make


def page(make: Callable[[], Screen[Any]]) -> Callable[[Path, FakeLink], App[Any]]:
    return lambda folder, link: PageApp([make])


def question(asked: Any) -> Callable[[Path, FakeLink], App[Any]]:
    return page(lambda: QuestionPage(asked, number=3, count=10, code=CODE, clock=ManualClock()))


def closing(**changes: Any) -> Callable[[], Screen[Any]]:
    tally = Tally(
        performances=[0.0, 3.0, 2.0, 7.0], unseen=300, practised=[0.4, 3.0, 8.0], good=9, bad=6, steps=180
    )
    tally.taken_back = 2
    outcome = SessionOutcome(recording=None, tally=tally, **changes)
    return lambda: ClosingScreen(outcome, words_of("tetris"))


def keys(*names: str) -> Drive:
    async def press(pilot: Pilot[Any], link: FakeLink) -> None:
        for name in names:
            await pilot.press(name)
        await pilot.pause(0.3)

    return press


async def a_moment(pilot: Pilot[Any], link: FakeLink) -> None:
    await pilot.pause(0.4)  # Markdown is laid out in a task of its own


PARTS = new_parts(setup(Path(), quick("simple", n_trials=40), quick("feedback-lag", n_trials=40)))
LIKERT = Likert(id="l", text="The computer did what I wanted it to do.", points=7)
SCALE = Scale(id="s", text="How mentally demanding was the task?", low="very low", high="very high")
CHOICE = Choice(id="c", text="Which hand do you write with?", options=("right", "left", "both"))
NUMBER = Number(id="n", text="How old are you?", lowest=18, highest=110, unit="years", required=False)
WORDS = FreeText(id="w", text="What did you try to teach?")
LONG = "\n\n".join(f"## Part {k}\n\nA paragraph that says something about the study." for k in range(12))
WRONG = msgspec.structs.replace(KEEPAWAY_20, keys=KeyConfig(max_presses_per_episode=2, wrong_press_rate=0.1))

PAGES: dict[str, tuple[Callable[[Path, FakeLink], App[Any]], Drive]] = {
    "welcome-tetris": (session(TETRIS), ready),
    "welcome-tetris-preparing": (session(TETRIS), preparing),
    "welcome-keepaway": (session(KEEPAWAY_20), ready),
    "welcome-keepaway-longest": (session(WRONG, part="Block 2 of 3", practice=True), ready),
    "overview": (session(TETRIS), overview),
    "tetris": (session(NOW, part="Block 2 of 3"), tetris),
    "tetris-marked": (session(NOW), marked),
    "tetris-budget-used-up": (session(NOW), used_up),
    "tetris-between-games": (session(NOW), practising),
    "keepaway": (session(KEEPAWAY_20, part="Block 2 of 3"), keepaway),
    "keepaway-between-games": (session(KEEPAWAY_20), keepaway_between),
    "pause": (page(covers.PauseScreen), nothing),
    "pause-after-gap": (page(lambda: covers.PauseScreen(gap_s=42.0)), nothing),
    "break-in-session": (page(lambda: covers.BreakScreen(10, 40)), nothing),
    "help": (page(lambda: covers.HelpScreen(TETRIS, words_of("tetris"))), nothing),
    "help-keepaway": (page(lambda: covers.HelpScreen(WRONG, words_of("keepaway"))), nothing),
    "stop": (page(covers.StopScreen), nothing),
    "thanks": (page(closing()), a_moment),
    "trouble": (page(closing(trouble="The learner's process was ended by signal 9.")), nothing),
    "study-text": (page(lambda: TextPage(CONSENT, code=CODE, part="Part 1 of 9")), a_moment),
    "study-long-text": (page(lambda: TextPage(LONG, code=CODE, part="Part 1 of 9")), a_moment),
    "study-consent": (
        page(lambda: ConsentPage(CONSENT, ["I agree to take part."], ["My data may be shared."], code=CODE)),
        keys("enter", "enter", "y"),
    ),
    "study-decline": (page(DeclinePage), nothing),
    "study-stop": (page(lambda: StopPage(CODE)), nothing),
    "study-break": (
        page(
            lambda: BreakPage(
                "", shortest_s=60, longest_s=600, code=CODE, clock=ManualClock(), part="Part 5 of 9"
            )
        ),
        a_moment,
    ),
    "study-thanks": (
        page(
            lambda: NoticePage("Thank you!", "You have helped us.", ["Your code is [b]P7K2[/]."], code=CODE)
        ),
        a_moment,
    ),
    "question-likert": (question(LIKERT), keys("5")),
    "question-scale": (question(SCALE), keys("right", "right")),
    "question-choice": (question(CHOICE), keys("2")),
    "question-number": (question(NUMBER), keys("2", "7")),
    "question-text": (question(WORDS), keys("n", "o")),
    "calibration-welcome": (page(lambda: calibration.WelcomePage(PARTS, CODE, resumed=False)), nothing),
    "calibration-instruction": (
        page(
            lambda: calibration.InstructionPage(PARTS[1].schedule, PARTS[1].schedule.blocks[0], resumed=False)
        ),
        nothing,
    ),
    "calibration-break": (page(lambda: calibration.BreakPage(20, 40)), nothing),
    "calibration-pause": (page(calibration.PausePage), nothing),
}
"""By name: what makes the app, and what is done before it is looked at."""

WINDOWS = ((80, 24), (120, 40), (200, 60))
LOOKS = [
    *((size, theme) for theme in ("dark", "light") for size in WINDOWS),
    (WINDOWS[0], "high-contrast"),
]
"""The first by default, the others by name."""
PICTURES = Path(__file__).parent / "__pages__"
"""One file for a page in a window: its text, and below it a fingerprint of its colours in each theme."""


@pytest.fixture
def plain_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures must not depend on the terminal that the tests are run in."""

    def in_true_colour(wanted: str, _system: object, **look: Any) -> object:
        return palette_for(wanted, "truecolor", **look)

    monkeypatch.setattr("arl_tui.session_app.palette_for", in_true_colour)
    monkeypatch.setattr("arl_tui.widgets.pitch.detail_for", lambda: "braille")
    # A machine that is held up for a second would show the page that says so.
    monkeypatch.setattr("arl_tui.app.gaps.GapWatch.look", lambda _watch: None)
    monkeypatch.setattr("arl_tui.app.live_session.LiveSession.silent_s", lambda _session: 0.0)
    monkeypatch.setattr("textual.widgets.Input.cursor_blink", False)
    monkeypatch.delenv("NO_COLOR", raising=False)


def looks() -> Iterator[Any]:
    for size, theme in LOOKS:
        marks = [] if (size, theme) == LOOKS[0] else [pytest.mark.slow]
        yield pytest.param(size, theme, id=f"{size[0]}x{size[1]}-{theme}", marks=marks)


@pytest.mark.parametrize(("size", "theme"), looks())
@pytest.mark.parametrize("name", PAGES)
async def test_a_page_looks_as_it_did(
    plain_terminal: None,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    request: pytest.FixtureRequest,
    name: str,
    size: tuple[int, int],
    theme: str,
) -> None:
    monkeypatch.setenv("ARL_THEME", theme)
    make, drive = PAGES[name]
    link = FakeLink()
    app = make(tmp_path, link)
    async with app.run_test(size=size) as pilot:
        await drive(pilot, link)
        cells = screen_cells(app)
    if "ARL_PICTURES" in os.environ:
        stem = f"{name}-{size[0]}x{size[1]}-{theme}"
        folder = Path(os.environ["ARL_PICTURES"])
        folder.mkdir(parents=True, exist_ok=True)
        picture_of(cells).save(folder / f"{stem}.png")
    path = PICTURES / f"{stem_of(name, size, theme)}.txt"
    text, colours = written(cells)
    known_text, known_colours = known(path)
    if request.config.getoption("update_snapshots"):
        write(path, text, known_colours | {theme: colours})
        return
    assert text == known_text, f"look at it with ARL_PICTURES=FOLDER, then --snapshot-update ({path.name})"
    assert colours == known_colours[theme], "the colours have changed: look at it with ARL_PICTURES=FOLDER"


def stem_of(name: str, size: tuple[int, int], theme: str) -> str:
    """Return the name of a page's file: high contrast has one of its own, since it draws blocks otherwise."""
    return f"{name}-{size[0]}x{size[1]}" + ("-high-contrast" if theme == "high-contrast" else "")


def written(cells: Cells) -> tuple[str, str]:
    """Return a screen's text, and a fingerprint of all its colours."""
    text = "\n".join("".join(letter for letter, *_ in line).rstrip() for line in cells)
    looks = repr([[look for _, *look in line] for line in cells])
    return text, hashlib.sha256(looks.encode()).hexdigest()[:12]


def known(path: Path) -> tuple[str, dict[str, str]]:
    """Return the text and the fingerprints of a file."""
    if not path.exists():
        return "", {}
    text, _, colours = path.read_text(encoding="utf-8").rpartition("\n=====\n")
    return text, dict(line.split() for line in colours.splitlines())


def write(path: Path, text: str, colours: dict[str, str]) -> None:
    path.parent.mkdir(exist_ok=True)
    lines = "".join(f"{theme} {digest}\n" for theme, digest in sorted(colours.items()))
    path.write_text(f"{text}\n=====\n{lines}", encoding="utf-8")


def test_every_file_belongs_to_a_page() -> None:
    stems = {stem_of(name, size, theme) for name in PAGES for size, theme in LOOKS}
    assert {path.stem for path in PICTURES.glob("*.txt")} == stems
