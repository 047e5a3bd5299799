"""Whole sittings of a study in a real terminal of 80 x 24: who consents, who does not, whose window
closes."""

import os
import signal
import time
from pathlib import Path

import pytest

from core.recording.joined import read_session
from core.recording.reader import Recording
from core.recording.summary import summarise_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from studies.lab.blocks import BlockSoFar, sessions_in
from studies.lab.ledger import Enrolled, SittingEnded, SittingStarted, Withdrawn, read_ledger
from studies.lab.progress import Participant, progress
from studies.lab.sitting_log import ConsentAnswered, QuestionAnswered, read_sitting
from tests.e2e.processes import descendants, left_after
from tests.e2e.terminal import START, Terminal

STUDY = """
name = "tiny"
title = "Teach a computer"
seed = 5
participants = 4
[protocol.session]
episodes = 2
unseen_between = 4
unseen_steps = 50
watched_steps = 7
[protocol.screen]
tick_ms = 70
count_down_s = 0
pause_between_episodes_s = 0.3
[conditions.LINEARCONDITION.agent.scheme]
type = "linear"
[conditions.ANNEALEDCONDITION.agent.scheme]
type = "annealed"
[assignment]
type = "latin-square"
[[sittings]]
name = "day 1"
steps = [
  { type = "page", text = "hello.md" },
  { type = "consent", text = "consent.md", statements = ["I agree."], optional = ["Share it."] },
  { type = "block" },
  { type = "break" },
  { type = "block" },
  { type = "questionnaire", questions = "trust" },
  { type = "debriefing", text = "thanks.md" },
]
"""
SECRETS = ("LINEARCONDITION", "ANNEALEDCONDITION", ".jsonl", "weight", "participants/")
"""What no participant's screen shows."""


class Lab:
    """A study in a folder, and its data."""

    def __init__(self, folder: Path, study: str = STUDY) -> None:
        self.folder = folder
        for name in ("hello", "consent", "thanks"):
            (folder / f"{name}.md").write_text(f"# The page {name}\n")
        (folder / "study.toml").write_text(study)

    @property
    def data(self) -> Path:
        return self.folder / "recordings" / "studies" / "tiny"

    def run(self, *more: str) -> Terminal:
        return Terminal("study", "run", str(self.folder / "study.toml"), *more, cwd=self.folder)

    def lines(self) -> tuple[object, ...]:
        return read_ledger(self.data / "ledger.jsonl")

    def participant(self, code: str = "P1") -> Participant:
        return progress(read_ledger(self.data / "ledger.jsonl")).participants[code]

    def blocks(self, code: str = "P1") -> list[BlockSoFar]:
        return sorted(
            sessions_in(self.data / "participants" / code),
            key=lambda block: int(block.recording.header.study["step"]),
        )

    def sitting_lines(self, code: str = "P1") -> list[object]:
        paths = sorted((self.data / "participants" / code).glob("sitting-*.jsonl"))
        return [line for path in paths for line in read_sitting(path)[1]]


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    return Lab(tmp_path)


def consent(terminal: Terminal) -> None:
    """Read the first page and agree."""
    terminal.wait_for("The page hello")
    terminal.wait_for("to go on")
    terminal.press("\r")
    terminal.wait_for("I agree.")
    terminal.wait_for("to go on")
    terminal.press("yn\r")


def begin_block(terminal: Terminal, first: str = "Game 1") -> None:
    """Start a session from its first page, and wait for its first game."""
    terminal.wait_for(START)
    no_secrets(terminal)
    terminal.begin(first)


def block(terminal: Terminal, first: str = "Game 1") -> None:
    """Watch a block from its first page to its last."""
    begin_block(terminal, first)
    terminal.pump(0.6)
    terminal.press("j")
    no_secrets(terminal)
    terminal.wait_for("Thank you!")
    no_secrets(terminal)
    terminal.press("\r")
    while "What you told the computer" in terminal.text:
        assert terminal.pump(), terminal.text


def take_a_break(terminal: Terminal) -> None:
    terminal.wait_for("Time for a break")
    terminal.wait_for("to go on")
    terminal.press("\r")


def finish(terminal: Terminal) -> None:
    """Answer all questions, and leave."""
    while terminal.wait_for("Question", "The page thanks", "to go on", "to read on") != "The page thanks":
        no_secrets(terminal)
        before = terminal.text
        terminal.press("3")
        terminal.pump(0.15)
        terminal.press("\r")
        terminal.pump(0.3)
        if terminal.text == before:
            terminal.pump(0.5)
    no_secrets(terminal)
    terminal.pump(0.5)
    terminal.press("\r\r")
    assert terminal.wait_for_exit() == 0


def no_secrets(terminal: Terminal) -> None:
    assert not [secret for secret in SECRETS if secret in terminal.text], terminal.text


def exact(recording: Recording) -> bool:
    session = build_session(protocol_from(recording.header.protocol), recording.header.root_seed)
    return replay_exactly(recording, session).difference is None


def test_a_whole_participant_from_consent_to_thanks(lab: Lab) -> None:
    with lab.run("--participant", "P1") as terminal:
        consent(terminal)
        block(terminal)
        take_a_break(terminal)
        block(terminal)
        finish(terminal)
        assert "P1 finished the sitting." in terminal.text
    person = lab.participant()
    assert person.sittings[0].ended == "finished"
    blocks = lab.blocks()
    assert [found.recording.header.study["condition"] for found in blocks] == list(person.order)
    assert all(found.finished and exact(found.recording) for found in blocks)
    assert {found.summary.condition for found in blocks} == {"LINEARCONDITION", "ANNEALEDCONDITION"}
    lines = lab.sitting_lines()
    (given,) = (line for line in lines if isinstance(line, ConsentAnswered))
    assert given.answers == {"I agree.": True, "Share it.": False}
    assert any(isinstance(line, QuestionAnswered) for line in lines)

    # Afterwards they withdraw: nothing of theirs is left.
    with Terminal(
        "study", "withdraw", str(lab.folder / "study.toml"), "P1", cwd=lab.folder, columns=200
    ) as terminal:
        terminal.wait_for("Remove all data of P1")
        terminal.press("y\r")
        assert terminal.wait_for_exit() == 0
    assert not (lab.data / "participants" / "P1").exists()
    files = [path for path in lab.data.rglob("*") if path.is_file()]
    assert not any(b'"P1"' in path.read_bytes() for path in files)
    assert any(isinstance(line, Withdrawn) for line in lab.lines())


def test_one_who_declines_leaves_nothing_but_a_count(lab: Lab) -> None:
    with lab.run("--participant", "P1") as terminal:
        terminal.wait_for("The page hello")
        terminal.wait_for("to go on")
        terminal.press("\r")
        terminal.wait_for("I agree.")
        terminal.wait_for("to go on")
        terminal.press("nn\r")
        terminal.wait_for("You do not want to take part")
        terminal.press("\r")
        assert terminal.wait_for_exit() == 0
        assert "nothing was kept" in terminal.text
        assert "P1" not in terminal.text
    assert progress(read_ledger(lab.data / "ledger.jsonl")).declined == 1
    assert not (lab.data / "participants").exists()
    assert not any(b"P1" in path.read_bytes() for path in lab.data.rglob("*") if path.is_file())


def close_the_window(terminal: Terminal) -> None:
    terminal.hang_up()
    assert terminal.ends_by_itself(10.0)


def kill(terminal: Terminal) -> None:
    os.kill(terminal.child.pid, signal.SIGKILL)


def lose_power(terminal: Terminal) -> None:
    """Kill every process at once."""
    for pid in (*descendants(terminal.child.pid), terminal.child.pid):
        os.kill(pid, signal.SIGKILL)


ENDS = (close_the_window, kill, lose_power)


@pytest.mark.thorough
def test_one_whose_block_2_breaks_off_three_times_goes_on_at_the_last_finished_game(lab: Lab) -> None:
    before: dict[Path, bytes] = {}
    for number, end in enumerate(ENDS):
        with lab.run("--participant", "P1") as terminal:
            if number == 0:
                consent(terminal)
                block(terminal)
                take_a_break(terminal)
                begin_block(terminal)
                terminal.pump(0.5)
                terminal.press("j")
                terminal.wait_for("Game 2")
            else:
                terminal.wait_for("1 of 2 games")
                begin_block(terminal, "Game 2")
            terminal.pump(0.5)
            terminal.press("f")
            terminal.pump(0.3)
            pids = descendants(terminal.child.pid)
            end(terminal)
            assert not left_after(pids, 10.0)
        assert {path: path.read_bytes() for path in before} == before
        before = {path: path.read_bytes() for path in lab.data.rglob("P1-*.jsonl")}
    ended = [line for line in lab.lines() if isinstance(line, SittingEnded)]
    assert [line.how for line in ended] == ["window-closed"]

    with lab.run("--participant", "P1") as terminal:
        terminal.wait_for("1 of 2 games")
        block(terminal, "Game 2")
        finish(terminal)
    assert {path: path.read_bytes() for path in before} == before
    assert lab.participant().sittings[0].ended == "finished"
    first, second = lab.blocks()
    assert len(second.recording.older) == len(ENDS)
    assert first.recording.older == ()
    assert all(found.finished and exact(found.recording) for found in (first, second))
    assert second.summary.games_finished == 2
    assert read_session(second.path).events == second.recording.events
    # What was pressed in the finished game before the break is in the session.
    assert summarise_recording(second.recording).presses_counted >= 1


def test_two_who_start_at_once_get_two_places_and_codes(lab: Lab) -> None:
    with lab.run() as one, lab.run() as other:
        for terminal in (one, other):
            terminal.wait_for("The page hello")
            terminal.wait_for("to go on")
            terminal.press("\r")
        for terminal in (one, other):
            terminal.wait_for("I agree.")
            terminal.wait_for("to go on")
        one.press("yy\r")
        other.press("yy\r")
        for terminal in (one, other):
            terminal.wait_for(START)
    enrolled = [line for line in lab.lines() if isinstance(line, Enrolled)]
    assert len({line.code for line in enrolled}) == 2
    assert sorted(line.place for line in enrolled) == [0, 1]
    assert len({line.order for line in enrolled}) == 2


@pytest.mark.thorough
def test_one_who_comes_back_too_late_is_told_so_and_the_experimenter_decides(tmp_path: Path) -> None:
    lab = Lab(tmp_path, STUDY.replace("[[sittings]]", "[resuming]\nwithin_hours = 0.0001\n[[sittings]]", 1))
    with lab.run("--participant", "P1") as terminal:
        consent(terminal)
        begin_block(terminal, "Game 2")
        kill(terminal)
    before = lab.lines()
    time.sleep(1.5)
    again = ("study", "run", str(lab.folder / "study.toml"), "--participant", "P1")
    with Terminal(*again, cwd=tmp_path, columns=300) as terminal:
        assert terminal.wait_for_exit() == 1
        assert "within_hours allows 0.0001 h" in terminal.text
        assert "Add --broken-off resume" in terminal.text
    assert lab.lines() == before

    # To go on, and to leave at the first page: the block is not over. Then to begin anew.
    with lab.run("--participant", "P1", "--broken-off", "resume") as terminal:
        terminal.wait_for("1 of 2 games")
        terminal.press("q")
        terminal.wait_for("You have stopped")
        terminal.press("\r")
        terminal.wait_for_exit()
    assert (lab.participant().sittings[0].ended, lab.participant().sittings[0].next_step(7)) == ("stopped", 2)
    with lab.run("--participant", "P1", "--broken-off", "restart") as terminal:
        terminal.wait_for("Once more from the beginning")
        terminal.wait_for("to go on")
        terminal.press("\r")
        consent(terminal)
        begin_block(terminal)
        kill(terminal)
    started = [line for line in lab.lines() if isinstance(line, SittingStarted)]
    assert [(line.decided, line.run, line.first_step) for line in started] == [
        (None, 0, 0),
        ("resume", 0, 2),
        ("restart", 1, 0),
    ]
    # What was recorded in the first run is kept, and the second run has a session of its own.
    assert sorted(found.recording.header.study["run"] for found in lab.blocks()) == ["0", "1"]


def test_a_sitting_that_runs_already_is_not_begun_twice(lab: Lab) -> None:
    with lab.run("--participant", "P1") as terminal:
        consent(terminal)
        terminal.wait_for(START)
        arguments = ("study", "run", str(lab.folder / "study.toml"), "--participant", "P1")
        with Terminal(*arguments, cwd=lab.folder, columns=200) as second:
            assert second.wait_for_exit() == 1
            assert "a sitting of P1 is running already" in second.text
    assert lab.participant().sittings[0].attempts == 1


@pytest.mark.thorough
def test_practice_ends_when_both_keys_were_pressed_and_a_calibration_follows(tmp_path: Path) -> None:
    first = """{ type = "practice", games = 2 },
  { type = "calibration", trials = 2, practice = 1, tasks = ["simple"] },
  { type = "block" },
"""
    slow = STUDY.replace("watched_steps = 7", "watched_steps = 6").replace("tick_ms = 70", "tick_ms = 120")
    lab = Lab(tmp_path, slow.replace('{ type = "block" },\n', first, 1))
    with lab.run("--participant", "P1") as terminal:
        consent(terminal)
        terminal.wait_for("nothing counts")
        begin_block(terminal)
        for key in "jf":
            terminal.pump(2.0)
            terminal.press(key)
        terminal.wait_for("That was the practice")
        no_secrets(terminal)
        terminal.press("\r")
        terminal.wait_for("How fast do you react?")
        while terminal.wait_for(START, "Enter", "Space", "+", "X", "") != START:
            terminal.press("\r" if "Enter" in terminal.text else " ")
            terminal.pump(0.5)
            no_secrets(terminal)
        kill(terminal)
    (practice,) = lab.blocks()
    assert practice.recording.header.study["kind"] == "practice"
    assert practice.summary.ending.kind == "practised"
    assert practice.summary.games_finished == 1
    assert exact(practice.recording)
    (trials,) = (lab.data / "participants" / "P1" / "calibration").glob("*.jsonl")
    assert len(trials.read_bytes().splitlines()) >= 4
    assert lab.participant().sittings[0].next_step(9) == 4
