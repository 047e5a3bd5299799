"""A calibration from the first page to the last, with a scripted participant and short waits."""

import asyncio
import gc
from collections.abc import Callable
from pathlib import Path

import pytest
from textual.pilot import Pilot

from arl_tui.calibration import pages, trial_screen
from arl_tui.calibration.fitting import Fitted
from arl_tui.calibration.helper import HelperError, ask_helper
from arl_tui.calibration.trial_screen import TrialScreen
from arl_tui.palette import palette_for
from arl_tui.participants import read_delays
from arl_tui.screens.covers import SmallWindowScreen
from arl_tui.screens.page import PageScreen
from studies.reaction_time.protocol import TrialPlan
from studies.reaction_time.trial_log import TrialWriter
from tests.arl_tui.calibrating import (
    A_WHILE,
    SILENCE_S,
    files_in,
    go_through,
    in_this_process,
    quick,
    quick_app,
    right,
    setup,
    shows,
    trial_in,
    until,
)
from tests.arl_tui.test_participants import task_delay


@pytest.fixture(autouse=True)
def _no_rests(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(trial_screen, "GAP_S", 0.01)
    monkeypatch.setattr(trial_screen, "WORD_S", 0.05)


async def text_of(pilot: Pilot) -> str:
    """Return the words on the screen, in one line."""
    await pilot.pause()
    lines = pilot.app.screen._compositor.render_strips()
    text = " ".join(segment.text for strip in lines for segment in strip)
    return " ".join(text.replace("│", " ").split())


async def test_every_trial_is_on_the_disk_with_its_times_and_the_fit_is_kept(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_practice=2, n_trials=7)))
    async with app.run_test() as pilot:
        await go_through(pilot)
    (file,) = files_in(tmp_path)
    assert [record.trial for record in file.trials] == list(range(9))
    assert [record.practice for record in file.trials] == [True] * 2 + [False] * 7
    for record in file.trials:
        assert record.status == "ok"
        assert record.flushed_ns is not None
        assert record.key_ns is not None
        assert record.asked_ns is not None
        assert record.rt_s == pytest.approx((record.key_ns - record.flushed_ns) / 1e9)
        assert record.asked_ns <= record.flushed_ns < record.key_ns
        assert record.frame_interval_ns is not None
    assert app.return_value is not None
    assert app.return_value.finished
    delays = read_delays(tmp_path, "P01")
    assert delays is not None
    kept = delays.tasks["simple"]
    assert kept.n_observed == 7
    assert kept.left_out == {"practice": 2}
    times = [record.rt_s for record in file.trials[2:] if record.rt_s is not None]
    assert kept.mean_s.low < sum(times) / 7 < kept.mean_s.high


@pytest.mark.parametrize(
    "name", ["choice", "go-no-go", "memory-search", "visual-search", "recognition", "feedback-lag"]
)
async def test_each_task_can_be_done_rightly(tmp_path: Path, name: str) -> None:
    changes = {"time_out_s": 2 * SILENCE_S} if name == "go-no-go" else {}
    app = quick_app(setup(tmp_path, quick(name, n_trials=4, n_studied=2, set_sizes=(2,), **changes)))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    assert [record.status for record in file.trials] == ["ok"] * 4
    if name == "feedback-lag":
        assert all(record.comment.startswith("piece ") for record in file.trials)


async def test_wrong_keys_silence_and_presses_at_nothing_are_recorded_as_such(tmp_path: Path) -> None:
    def answer(plan: TrialPlan) -> list[str]:
        if plan.catch:
            return ["f"]
        return {0: ["j" if plan.expected_keys == ("f",) else "f"], 1: []}.get(plan.index, right(plan))

    config = quick("choice", n_trials=10, catch_rate=0.2, time_out_s=2.0)
    app = quick_app(setup(tmp_path, config))
    async with app.run_test() as pilot:
        await go_through(pilot, answer, until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    for record in file.trials:
        if record.catch:
            assert (record.status, record.flushed_ns) == ("wrong key", None)
        elif record.trial < 2:
            assert record.status == ("wrong key", "time-out")[record.trial]
        else:
            assert record.status == "ok"
    assert sum(record.catch for record in file.trials) == 2


async def test_a_press_before_the_stimulus_is_counted_and_answers_nothing(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_trials=1, foreperiod=A_WHILE, time_out_s=SILENCE_S)))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=TrialScreen)
        await until(pilot, trial_in(pilot, "foreperiod"))
        await pilot.press("space", "x")
        await go_through(pilot, lambda _plan: (), until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    (record,) = file.trials
    assert (record.status, record.early_presses, record.other_presses) == ("time-out", 1, 1)


async def test_practice_tells_how_it_went_and_what_counts_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(trial_screen, "WORD_S", 0.4)
    monkeypatch.setattr(trial_screen, "GAP_S", 0.4)
    app = quick_app(setup(tmp_path, quick("simple", n_practice=1, n_trials=1)))
    async with app.run_test() as pilot:
        for told in (True, False):
            await go_through(pilot, until_shown=TrialScreen)
            await until(pilot, trial_in(pilot, "shown"))
            await asyncio.sleep(0.12)
            await pilot.press("space")
            await until(pilot, lambda: not trial_in(pilot, "shown")())
            await asyncio.sleep(0.1)
            assert ("thousandths" in await text_of(pilot)) is told
            if told:
                assert "Practice: 1 of 1" in await text_of(pilot)
                await until(pilot, shows(pilot, pages.InstructionPage))
                assert "Practice is over" in await text_of(pilot)


async def test_there_is_a_break_between_blocks(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_trials=4, trials_per_block=2)))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=pages.BreakPage)
        assert "2 of 4" in await text_of(pilot)
        await go_through(pilot, until_shown=pages.SummaryPage)
    assert len(files_in(tmp_path)[0].trials) == 4


async def test_a_pause_in_a_trial_gives_it_up_and_runs_it_again(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_trials=2, foreperiod=A_WHILE)))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=TrialScreen)
        await until(pilot, trial_in(pilot, "foreperiod"))
        await pilot.press("p")
        await until(pilot, shows(pilot, pages.PausePage))
        await go_through(pilot, until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    assert [record.trial for record in file.trials] == [0, 0, 1]
    assert file.trials[0].comment.startswith("abandoned: pause")
    assert [record.status for record in file.trials[1:]] == ["ok", "ok"]
    assert file.next_trial == 2


async def stop_in_second_task(folder: Path, given_seed: int = 3) -> None:
    both = (quick("simple", n_trials=1), quick("choice", n_trials=3))
    app = quick_app(setup(folder, *both, seed=given_seed))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=TrialScreen)
        await go_through(
            pilot,
            lambda plan: ["q"] if len(plan.stimulus) > 1 and plan.index == 1 else right(plan),
            until_shown=pages.PausePage,
        )
        await pilot.press("q")
        await until(pilot, shows(pilot, pages.SummaryPage))
        assert "run the same command again" in await text_of(pilot)
        await pilot.press("enter")
    assert app.return_value is not None
    assert not app.return_value.finished


@pytest.mark.parametrize(
    ("task", "title"), [("choice", "Left or right"), ("feedback lag, pooled", "Judge the computer, pooled")]
)
async def test_a_task_without_a_result_is_called_as_the_participant_knows_it(task: str, title: str) -> None:
    page = pages.SummaryPage(Fitted(failures={task: "only [3] responses"}), finished=True, trouble=None)
    assert list(page.paragraphs()) == [f"[b]{title}[/]: no result. The experimenter sees why."]


async def test_what_the_experimenter_is_told_is_not_on_the_participants_page() -> None:
    delay = task_delay(n_observed=12)
    assert delay.warnings
    page = pages.SummaryPage(Fitted(delays=(delay,)), finished=True, trouble=None)
    text = "\n".join(page.paragraphs())
    assert "on average you took" in text
    assert "xperimenter" not in text
    assert delay.warnings[0] not in text


async def test_who_stops_goes_on_where_they_stopped(tmp_path: Path) -> None:
    await stop_in_second_task(tmp_path)
    choice, simple = files_in(tmp_path)
    assert (simple.next_trial, choice.next_trial) == (1, 1)
    both = (quick("simple", n_trials=1), quick("choice", n_trials=3))
    app = quick_app(setup(tmp_path, *both, seed=99))
    async with app.run_test() as pilot:
        await until(pilot, shows(pilot, pages.WelcomePage))
        assert "Welcome back" in await text_of(pilot)
        await go_through(pilot, until_shown=pages.SummaryPage)
    choice, simple = files_in(tmp_path)
    assert [record.trial for record in simple.trials] == [0]
    assert [record.trial for record in choice.trials] == [0, 1, 1, 2]
    assert choice.trials[1].comment.startswith("abandoned")
    assert choice.trials[2].comment.startswith("resumed")
    assert choice.header.schedule.root_seed == 3


@pytest.mark.parametrize(("key", "n_files"), [("n", 2), ("c", 1)], ids=["anew", "continued"])
async def test_a_half_session_of_yesterday_is_asked_about(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, key: str, n_files: int
) -> None:
    await stop_in_second_task(tmp_path)
    for path in (tmp_path / "calibration").glob("*.jsonl"):
        header, _, rest = path.read_text().partition("\n")
        year = header.index('"created_utc":"') + len('"created_utc":"')
        path.write_text(f"{header[:year]}2025{header[year + 4 :]}\n{rest}")
    both = (quick("simple", n_trials=1), quick("choice", n_trials=3))
    app = quick_app(setup(tmp_path, *both, seed=99))
    async with app.run_test() as pilot:
        await until(pilot, shows(pilot, pages.OldSessionPage))
        assert "hours ago" in await text_of(pilot)
        await pilot.press(key)
        await go_through(pilot, until_shown=pages.SummaryPage)
    choices = [file for file in files_in(tmp_path) if file.header.schedule.config.task == "choice"]
    assert len(choices) == n_files
    assert [file.next_trial for file in choices[:-1]] == [1] * (n_files - 1)
    assert choices[-1].next_trial == 3


async def test_what_hinders_measuring_needs_an_explicit_yes_and_is_written_down(tmp_path: Path) -> None:
    given = setup(tmp_path, quick("simple", n_trials=1), hindrances=("a multiplexer (tmux)",))
    app = quick_app(given)
    async with app.run_test() as pilot:
        await until(pilot, shows(pilot, pages.HindrancePage))
        await pilot.press("enter", "space")
        assert isinstance(app.screen, pages.HindrancePage)
        await pilot.press("q")
    assert app.return_value is not None
    assert files_in(tmp_path) == []
    app = quick_app(given)
    async with app.run_test() as pilot:
        await until(pilot, shows(pilot, pages.HindrancePage))
        await pilot.press("y")
        await go_through(pilot, until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    assert file.header.facts["hindrances"] == "a multiplexer (tmux)"


async def test_nothing_is_collected_during_a_trial_and_all_is_as_before_afterwards(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_practice=0, n_trials=2)))
    seen: list[bool] = []

    def answer(plan: TrialPlan) -> list[str]:
        seen.append(gc.isenabled())
        return ["space"]

    async with app.run_test() as pilot:
        await go_through(pilot, answer, until_shown=pages.SummaryPage)
        assert gc.isenabled()
    assert seen == [False, False]
    assert gc.isenabled()


async def test_a_disk_that_takes_nothing_more_ends_the_session_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_trials=3)))
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=TrialScreen)

        def fail(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(TrialWriter, "write", fail)
        await go_through(pilot, until_shown=pages.SummaryPage)
        assert "had to end early" in await text_of(pilot)
        assert "No space left" in await text_of(pilot)
        await pilot.press("enter")
    assert app.return_value is not None
    assert "No space left" in str(app.return_value.trouble)


async def test_a_window_too_small_is_asked_to_grow_and_gives_the_trial_up(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path, quick("simple", n_trials=1, foreperiod=A_WHILE)))
    async with app.run_test(size=(80, 24)) as pilot:
        await go_through(pilot, until_shown=TrialScreen)
        await until(pilot, trial_in(pilot, "foreperiod"))
        await pilot.resize_terminal(60, 20)
        await until(pilot, shows(pilot, pages.PausePage))
        await pilot.press("enter")
        await until(pilot, shows(pilot, SmallWindowScreen))
        await pilot.resize_terminal(80, 24)
        await go_through(pilot, until_shown=pages.SummaryPage)
    (file,) = files_in(tmp_path)
    assert file.trials[0].comment == "abandoned: window too small"
    assert file.trials[-1].status == "ok"


async def test_a_fit_that_fails_loses_no_trials(tmp_path: Path) -> None:
    async def broken(module: str, question: object) -> bytes:
        raise HelperError("it broke")

    app = quick_app(setup(tmp_path, quick("simple", n_trials=1)), helper=broken)
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=pages.SummaryPage)
        assert "no result" in await text_of(pilot)
        await pilot.press("enter")
    assert app.return_value is not None
    assert "it broke" in app.return_value.fitted.failures["all"]
    assert len(files_in(tmp_path)[0].trials) == 1


async def test_a_game_that_cannot_be_prepared_ends_the_session_with_a_message(tmp_path: Path) -> None:
    async def broken(module: str, question: object) -> bytes:
        if module.endswith("tetris.judging"):
            raise HelperError("no game today")
        return await in_this_process(module, question)

    app = quick_app(setup(tmp_path, quick("feedback-lag")), helper=broken)
    async with app.run_test() as pilot:
        await go_through(pilot, until_shown=pages.SummaryPage)
        assert "no game today" in await text_of(pilot)


async def test_another_process_answers_and_its_failure_is_an_error_with_its_last_word() -> None:
    with pytest.raises(HelperError, match=r"judging left with status 1: .*ValidationError"):
        await ask_helper("arl_tui.games.tetris.judging", {"not": "a schedule"})


def test_a_calibration_has_no_palette_and_no_animation(tmp_path: Path) -> None:
    app = quick_app(setup(tmp_path))
    assert not app.ENABLE_COMMAND_PALETTE
    assert app.animation_level == "none"


@pytest.fixture
def true_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures must not depend on the terminal that the tests are run in."""
    monkeypatch.setattr(
        "arl_tui.calibration.app.palette_for", lambda name, _system: palette_for(name, "truecolor")
    )


@pytest.mark.parametrize("name", ["simple", "visual-search", "feedback-lag"])
def test_a_stimulus_looks_as_it_did(
    snap_compare: Callable[..., bool], tmp_path: Path, true_colour: None, name: str
) -> None:
    # A drop that stands still long enough to be photographed.
    app = quick_app(setup(tmp_path, quick(name, picture_ms=2000.0)))

    async def wait(pilot: Pilot) -> None:
        await go_through(pilot, until_shown=TrialScreen)
        await until(pilot, trial_in(pilot, "shown"))

    assert snap_compare(app, terminal_size=(80, 24), run_before=wait)


@pytest.mark.parametrize("kind", [pages.WelcomePage, pages.InstructionPage, pages.HindrancePage])
def test_pages_look_as_they_did(
    snap_compare: Callable[..., bool], tmp_path: Path, kind: type[PageScreen]
) -> None:
    hindrances = ("a network connection (SSH)",) if kind is pages.HindrancePage else ()
    both = quick("simple"), quick("feedback-lag", catch_rate=0.1, n_practice=8)
    if kind is pages.InstructionPage:
        both = both[1:]
    app = quick_app(setup(tmp_path, *both, hindrances=hindrances))

    async def wait(pilot: Pilot) -> None:
        await go_through(pilot, until_shown=kind)
        await pilot.pause()

    assert snap_compare(app, terminal_size=(80, 24), run_before=wait)
