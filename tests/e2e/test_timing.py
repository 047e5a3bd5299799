"""`arl timing`: the robot, the app under test, and what is made of their times."""

import json
import os
import pty
import subprocess
import sys
import threading
import time
import tty
from pathlib import Path

import click
import msgspec
import pytest
from click.testing import CliRunner

from arl_tui.app.link import Begin, Crashed, Picture, Ready
from arl_tui.cli import main
from arl_tui.commands.timing import CONDITION_NAMES, report_lines, stop_above
from arl_tui.timing import bare
from arl_tui.timing.kept import NONE, keep_timing, machine_code, timing_facts
from arl_tui.timing.plan import CONDITIONS, MARKER, Answered, Plan, PlannedTrial, Seen, make_plan, marker
from arl_tui.timing.result import Summary, TimingResult, compare, header_facts, read_timing, summarise
from arl_tui.timing.robot import Robot, RobotTrial, TimingError, run_plan
from arl_tui.timing.subject import SubjectApp
from arl_tui.timing.waking import lateness_ms
from core.events import FrameShown
from core.tetris.picture import Counts, Wall, snapshot
from tests.arl_tui.fakes import FakeLink
from tests.e2e.processes import children, left_after

MS = 1_000_000
EMPTY = snapshot(Wall(20, 10), counts=Counts())
FULL = msgspec.structs.replace(EMPTY, cells=b"\x01" * 200)
BELOW_A_FRAME_MS = 25.0
"""A frame takes 33 ms. One key within this does not show where stamps come from (that is
`tests/arl_tui/app/test_driver.py`), only that they are not all late; the median within it, on a quiet
machine, shows more."""


@pytest.mark.thorough
def test_the_robot_measures_every_condition_and_the_result_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "timing.json"
    options = ["--trials", "6", "--longest", "300", "--seed", "5", "--json", path, "--recordings", tmp_path]
    result = CliRunner().invoke(main, ["timing", *map(str, options)])
    assert result.exit_code == 0, result.output
    for expected in (
        "bare reader",
        "at rest",
        "beside a board",
        "median",
        "p99",
        "Psychtoolbox",
        "peerj.com",
        "Not seen here",
    ):
        assert expected in result.stdout
    found = read_timing(path)
    (kept,) = (tmp_path / "timing").iterdir()
    assert read_timing(kept) == found
    assert found.machine == machine_code()
    assert [condition.condition for condition in found.conditions] == [
        "bare reader",
        "at rest",
        "beside a board",
    ]
    for condition in found.conditions:
        planned = {
            t.number: t.delay_ms
            for t in make_plan(condition.condition, 6, root_seed=5, longest_ms=300).trials
        }
        assert len(condition.trials) + condition.n_missed == 6
        for trial in condition.trials:
            assert trial.true_ms >= planned[trial.number]
        errors_ms = [trial.error_ms for trial in condition.trials]
        # On a busy machine keys are read late, in any program, and flushes stamped after their bytes were
        # read: not always.
        assert max(errors_ms) > 0.0, errors_ms
        assert min(abs(error) for error in errors_ms) < BELOW_A_FRAME_MS, errors_ms
    bare, rest, board = found.conditions
    assert bare.board_fps == 0.0
    assert rest.board_fps == 0.0
    assert board.board_fps > 0.0


@pytest.mark.slow
def test_on_a_quiet_machine_the_median_error_is_below_a_frame(tmp_path: Path) -> None:
    options = ["--trials", "20", "--seed", "5", "--gate", BELOW_A_FRAME_MS, "--recordings", tmp_path]
    result = CliRunner().invoke(main, ["timing", *map(str, options)])
    assert result.exit_code == 0, result.output


def test_no_process_is_left_behind_when_the_robot_gives_up(tmp_path: Path) -> None:
    with Robot(make_plan("beside a board", 50, root_seed=1), tmp_path) as robot:
        family = {robot.pid}
        for _ in range(60):
            with pytest.raises(TimingError, match="still runs"):
                robot.run(1.0, lambda: None)
            family = {robot.pid} | children(robot.pid)
            if len(family) > 1:
                break
    assert len(family) > 1, "the learner's process has not been started within a minute"
    assert left_after(family, 60.0) == set()


ROBOT_ALONE = """
from arl_tui.timing.plan import make_plan
from arl_tui.timing.robot import run_plan
run_plan(make_plan("at rest", 50, root_seed=1), lambda: print("answered", flush=True))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells a process that its parent has gone")
def test_a_robot_that_is_killed_takes_the_app_with_it() -> None:
    robot = subprocess.Popen([sys.executable, "-c", ROBOT_ALONE], stdout=subprocess.PIPE)
    try:
        assert robot.stdout is not None
        assert robot.stdout.readline() == b"answered\n"
        family = children(robot.pid)
        assert len(family) == 1
    finally:
        robot.kill()
        robot.communicate()
    assert left_after(family, 60.0) == set()


def test_an_app_that_cannot_start_is_reported_with_its_last_words(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "textual.py").write_text("raise ImportError('no screen today')\n")
    monkeypatch.setattr(
        "arl_tui.timing.robot.REPOSITORY", f"{tmp_path}{os.pathsep}{Path(__file__).parents[2]}"
    )
    with pytest.raises(TimingError, match="no screen today"):
        run_plan(make_plan("at rest", 1, root_seed=1))


# --- the app under test -------------------------------------------------------------------------------------


def app_beside_a_board() -> tuple[SubjectApp, FakeLink]:
    link = FakeLink()
    return SubjectApp(make_plan("beside a board", 1, root_seed=1), link), link


async def test_a_step_that_looks_like_the_one_before_is_reported_after_it() -> None:
    app, link = app_beside_a_board()
    async with app.run_test(size=(80, 30)) as pilot:
        link.say(Ready(warm_up_ns=1))
        link.say(Picture(number=0, step=0, view=FULL), Picture(number=1, step=1, view=FULL))
        await pilot.pause(0.2)
        link.say(Picture(number=2, step=2, view=FULL))
        await pilot.pause(0.2)
    shown = [message for message in link.sent if isinstance(message, FrameShown)]
    assert isinstance(link.sent[0], Begin)
    assert [frame.step for frame in shown] == [1, 2]
    assert [frame.frame for frame in shown] == [0, 1]


async def test_a_learner_that_fails_ends_the_test_with_its_trace() -> None:
    app, link = app_beside_a_board()
    async with app.run_test(size=(80, 30)):
        link.say(Crashed(error="ValueError: no", trace="line 7"))
    assert app.return_value is not None
    assert "ValueError: no\nline 7" in app.return_value


async def test_only_the_first_answer_to_a_stimulus_counts() -> None:
    app = SubjectApp(make_plan("at rest", 1, root_seed=1), None)
    async with app.run_test(size=(80, 30)) as pilot:
        await pilot.press("j")  # Before the stimulus: no answer.
        while not app.answers:
            await pilot.pause(0.05)
            if app.waiting:
                await pilot.press("x")
                before_ns = time.monotonic_ns()
                await pilot.press("j", "j")
        (answer,) = app.answers
    assert answer.number == 0
    assert answer.key_ns is not None
    assert before_ns <= answer.key_ns <= time.monotonic_ns()


# --- plan ---------------------------------------------------------------------------------------------------


def test_a_plan_depends_on_seed_and_condition_only_and_keeps_its_ranges() -> None:
    plan = make_plan("at rest", 200, root_seed=3)
    assert plan == make_plan("at rest", 200, root_seed=3)
    assert plan.trials[:50] != make_plan("at rest", 50, root_seed=4).trials
    assert plan.trials != make_plan("beside a board", 200, root_seed=3).trials
    delays = [trial.delay_ms for trial in plan.trials]
    assert min(delays) >= 150
    assert max(delays) <= 1000
    assert max(delays) - min(delays) > 700


def test_a_plan_nobody_can_carry_out_is_refused() -> None:
    with pytest.raises(ValueError, match="1 to 9999 trials"):
        make_plan("at rest", 0, root_seed=1)


def test_the_marker_on_the_screen_is_the_one_the_robot_looks_for() -> None:
    (found,) = MARKER.finditer(b"\x1b[0m" + marker(42).encode() + b"\x1b[K")
    assert int(found.group(1)) == 42


def test_the_commands_conditions_are_those_there_are() -> None:
    assert tuple(CONDITIONS) == CONDITION_NAMES


# --- result -------------------------------------------------------------------------------------------------


def by_hand() -> tuple[Plan, list[RobotTrial], Seen]:
    """Four trials of 300 ms: in time, read 8 ms late, never answered, never stamped."""
    planned = tuple(PlannedTrial(number=i, foreperiod_ms=300, delay_ms=300) for i in range(4))
    robot = [
        RobotTrial(number=0, read_ns=1000 * MS, written_ns=1300 * MS),
        RobotTrial(number=1, read_ns=2008 * MS, written_ns=2308 * MS),
        RobotTrial(number=2, read_ns=3000 * MS, written_ns=3300 * MS),
        RobotTrial(number=3, read_ns=4000 * MS, written_ns=4300 * MS),
    ]
    answers = (
        Answered(number=0, flushed_ns=999 * MS, key_ns=1302 * MS),
        Answered(number=1, flushed_ns=2000 * MS, key_ns=2310 * MS),
        Answered(number=2, flushed_ns=2999 * MS, key_ns=None),
        Answered(number=3, flushed_ns=None, key_ns=4301 * MS),
    )
    plan = Plan(condition="beside a board", root_seed=1, trials=planned)
    return plan, robot, Seen(answers=answers, board_frames=120, duration_ns=4_000 * MS)


def test_errors_are_measured_minus_true_and_late_reads_are_apart() -> None:
    condition = compare(*by_hand())
    # Trial 0: (1302 - 999) - 300 = 3 ms. Trial 1: (2310 - 2000) - 300 = 10 ms, of which 8 ms were spent on
    # the way.
    assert [(t.error_ms, t.read_late_ms, t.late) for t in condition.trials] == [
        (3.0, 1.0, False),
        (10.0, 8.0, True),
    ]
    assert condition.on_time is not None
    assert condition.late is not None
    assert (condition.on_time.n, condition.on_time.bias, condition.late.n, condition.late.bias) == (
        1,
        3.0,
        1,
        10.0,
    )
    assert condition.on_the_way is not None
    assert condition.on_the_way.bias == 1.0
    assert condition.n_missed == 2
    assert condition.board_fps == 30.0


def test_a_summary_by_hand() -> None:
    found = summarise([1.0, 2.0, 3.0, 6.0])
    assert found is not None
    # Mean 3; squares of the distances 4 + 1 + 0 + 9 = 14, over 3; 95 % of the way through 4 values is 0.85
    # past the third.
    assert (found.bias, found.median) == (3.0, 2.5)
    assert found.sd == pytest.approx((14 / 3) ** 0.5)
    assert found.p95 == pytest.approx(3.0 + 0.85 * 3.0)
    assert summarise([]) is None


def result_by_hand(load: float) -> TimingResult:
    return TimingResult(
        created_utc="2026-03-01T10:00:00+00:00",
        root_seed=1,
        cores=2,
        load=load,
        software={},
        conditions=(compare(*by_hand()),),
    )


def test_late_trials_missed_trials_and_a_busy_machine_are_named() -> None:
    text = "\n".join(report_lines(result_by_hand(load=7.0)))
    assert "read late (> 5 ms)" in text
    assert "2 of 4 trials without an answer" in text
    assert "only the medians" in text
    assert "only the medians" not in "\n".join(report_lines(result_by_hand(load=0.1)))


def test_a_machine_that_wakes_late_is_called_so() -> None:
    waking = Summary(n=100, bias=0.4, sd=0.5, median=0.2, p95=2.1, p99=5.0)
    late = msgspec.structs.replace(result_by_hand(load=0.1), waking=waking)
    assert "not a quiet machine" in "\n".join(report_lines(late))
    assert header_facts(late)["timing_waking"].startswith("n 100, error ms: bias 0.40")
    quiet = msgspec.structs.replace(late, waking=msgspec.structs.replace(waking, p95=0.3))
    assert "p95 0.30" in "\n".join(report_lines(quiet))
    assert "not a quiet machine" not in "\n".join(report_lines(quiet))


def test_a_sleep_never_ends_early() -> None:
    late = lateness_ms(sleeps=5)
    assert len(late) == 5
    assert min(late) >= 0


def test_the_result_fits_into_a_sessions_header() -> None:
    facts = header_facts(result_by_hand(load=0.5))
    assert facts["timing_load"] == "0.5 on 2 cores"
    assert facts["timing_beside_a_board"].startswith("n 1, error ms: bias 3.00")
    assert facts["timing_beside_a_board_read_late"].startswith("n 1, error ms: bias 10.00")


TERMINAL = {"TERM": "xterm", "connection": "local", "size": "80x24"}


def kept_result(created_utc: str, **changes: object) -> TimingResult:
    given = {
        "created_utc": created_utc,
        "machine": machine_code(),
        "terminal": {"TERM": "xterm", "connection": "local"},
    }
    return msgspec.structs.replace(result_by_hand(load=0.5), **{**given, **changes})


def test_a_session_names_the_newest_result_of_its_machine_and_terminal_with_its_age(tmp_path: Path) -> None:
    ours = ("2026-03-01T10:00:00+00:00", "2026-03-02T06:30:00+00:00")
    for created_utc in reversed(ours):
        keep_timing(tmp_path, kept_result(created_utc))
    keep_timing(tmp_path, kept_result("2026-03-03T00:00:00+00:00", machine="another"))
    keep_timing(
        tmp_path, kept_result("2026-03-03T00:00:00+00:00", terminal={"TERM": "xterm", "connection": "ssh"})
    )
    facts = timing_facts(tmp_path, TERMINAL, "2026-03-03T12:00:00+00:00")
    assert facts["timing"] == "20260302T063000Z.json"
    assert facts["timing_age_h"] == "29.5"
    assert facts["timing_beside_a_board"].startswith("n 1, error ms: bias 3.00")
    assert len(list((tmp_path / "timing").iterdir())) == 4


def test_a_session_says_that_there_is_no_result_and_which_cannot_be_read(tmp_path: Path) -> None:
    assert timing_facts(tmp_path, TERMINAL, "2026-03-03T12:00:00+00:00") == {"timing": NONE}
    path = keep_timing(tmp_path, kept_result("2026-03-02T06:30:00+00:00", machine="another"))
    path.with_name("x.json").write_text("{")
    facts = timing_facts(tmp_path, TERMINAL, "2026-03-03T12:00:00+00:00")
    assert facts == {"timing": NONE, "timing_unreadable": "x.json"}


def test_a_gate_judges_medians_only(tmp_path: Path) -> None:
    result = result_by_hand(load=9.0)  # Median of the trials that were read in time: 3 ms.
    stop_above(result, 3.0)
    with pytest.raises(click.ClickException, match=r"median error is 3\.00 ms, allowed are 2\.9 ms"):
        stop_above(result, 2.9)
    (condition,) = result.conditions
    unusable = msgspec.structs.replace(result, conditions=(msgspec.structs.replace(condition, on_time=None),))
    with pytest.raises(click.ClickException, match="no usable trial of 4"):
        stop_above(unusable, 100.0)
    wrong = CliRunner().invoke(main, ["timing", "--gate", "0"])
    assert wrong.exit_code == 2


def test_the_bare_reader_takes_no_key_for_an_answer_that_came_before_the_stimulus() -> None:
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    plan = Plan(
        condition="bare reader",
        root_seed=1,
        trials=(PlannedTrial(number=7, foreperiod_ms=100, delay_ms=150),),
    )
    os.write(ours, b"j")
    seen: list[Seen] = []
    reader = threading.Thread(target=lambda: seen.append(bare.run(plan, theirs, theirs)))
    reader.start()
    assert os.read(ours, 64) == marker(7).encode()
    pressed_ns = time.monotonic_ns()
    os.write(ours, b"xj")
    reader.join()
    (answer,) = seen[0].answers
    assert answer.key_ns is not None
    assert answer.flushed_ns is not None
    assert answer.flushed_ns <= pressed_ns <= answer.key_ns
    os.close(ours)
    os.close(theirs)


def test_a_result_is_read_back_and_anything_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.json"
    path.write_bytes(msgspec.json.encode(result_by_hand(load=0.5)))
    assert read_timing(path) == result_by_hand(load=0.5)
    path.write_text(json.dumps({"format": 3}))
    with pytest.raises(ValueError, match=r"t\.json: not a result of `arl timing`"):
        read_timing(path)
