"""Importing TAMER's logs: what is mended, what is kept, what is refused."""

from pathlib import Path

import pytest

from core.events import EpisodeEnded, FrameShown, KeyPressed, StepTaken
from core.numerics.clock import NS_PER_S
from core.recording.importers.tamer_log import import_tamer_log
from core.recording.importers.tamer_rows import TamerLogError, read_tamer_log
from core.recording.reader import Recording, read_recording
from tests.data_folder import data_files, data_folder

PARAMETERS = "(;featClass=FeatGen_Tetris;stepSize=1.0E-7)"


def row(
    start: str,
    *,
    cells: dict[tuple[int, int], int] | None = None,
    piece=0,
    reward="0.0",
    presses="[]",
    training="true",
) -> str:
    """Write one line as TAMER does; `cells` maps (row from the bottom, column) to a colour."""
    board = [0] * 200
    for (level, column), colour in (cells or {}).items():
        board[(19 - level) * 10 + column] = colour
    state = [*board, 1, piece, 0, 3, -1, 10, 20]
    return f"{state}:[]:[4, 4]:[]:{reward}:{presses}:{training}:{start}"


def terminal(start: str, presses="[]", reward="0.0") -> str:
    return f"[]:[]:[]:[]:{reward}:{presses}:true:{start}"


def imported(tmp_path: Path, *lines: str) -> Recording:
    log = tmp_path / "p1.log"
    log.write_text("\n".join([PARAMETERS, *lines, "finished"]))
    import_tamer_log(log, tmp_path / "p1.jsonl")
    return read_recording(tmp_path / "p1.jsonl")


def of_type(recording: Recording, kind: type) -> list:
    return [event for event in recording.events if isinstance(event, kind)]


def test_a_reward_belongs_to_the_step_before_the_row_it_stands_on(tmp_path):
    recording = imported(
        tmp_path, row("1.0"), row("2.0", reward="2.0"), row("3.5", reward="1.0"), terminal("5.0")
    )
    assert [step.reward for step in of_type(recording, StepTaken)] == [2.0, 1.0, 0.0]
    # 2^(n-1) for n lines: 2.0 is two lines, 1.0 is one.
    assert of_type(recording, EpisodeEnded)[0].performance == 3.0


def test_a_press_is_tied_to_the_step_that_was_on_screen_at_its_time(tmp_path):
    recording = imported(
        tmp_path, row("1.0"), row("2.0", presses="[{1.0 @ 1.25}]"), terminal("3.0", presses="[{-1.0 @ 2.5}]")
    )
    assert [(p.time_ns, p.value, p.step, p.key) for p in of_type(recording, KeyPressed)] == [
        (NS_PER_S * 5 // 4, 1.0, 0, "/"),
        (NS_PER_S * 5 // 2, -1.0, 1, "z"),
    ]


def test_presses_listed_again_after_a_terminal_row_are_dropped_and_all_are_sorted(tmp_path):
    listed = "[{-1.0 @ 2.5}, {1.0 @ 2.25}]"
    recording = imported(
        tmp_path, row("1.0"), terminal("3.0", presses=listed), "", row("3.5", presses=listed), terminal("4.0")
    )
    assert [p.time_ns / NS_PER_S for p in of_type(recording, KeyPressed)] == [2.25, 2.5]


def test_frames_leave_the_screen_empty_between_episodes(tmp_path):
    recording = imported(tmp_path, row("1.0"), terminal("3.0"), "", row("4.0"), terminal("5.0"))
    assert [(f.step, f.flushed_ns // NS_PER_S) for f in of_type(recording, FrameShown)] == [
        (0, 1),
        (-1, 3),
        (1, 4),
        (-1, 5),
    ]


def test_a_pause_in_the_session_is_kept(tmp_path):
    recording = imported(tmp_path, row("1.0"), row("181.0"), terminal("183.0"))
    assert [f.flushed_ns // NS_PER_S for f in of_type(recording, FrameShown)] == [1, 181, 183]


def test_boards_are_turned_into_columns_from_the_bottom(tmp_path):
    recording = imported(
        tmp_path, row("1.0"), row("2.0", cells={(0, 0): 1, (3, 0): 5, (1, 9): 2}, piece=6), terminal("3.0")
    )
    first, second = of_type(recording, StepTaken)
    assert first.observed == {"before": [0] * 10, "after": [0b1001, *[0] * 8, 0b10]}
    assert second.detail == {"piece": 6}
    assert "after" not in second.observed  # the log does not show what a terminal placement left behind


def test_outputs_count_the_inputs_before_them(tmp_path):
    recording = imported(tmp_path, row("1.0"), row("2.0", presses="[{1.0 @ 1.25}]"), terminal("3.0"))
    inputs = 0
    for event in recording.events:
        if isinstance(event, FrameShown | KeyPressed):
            inputs += 1
        else:
            assert event.inputs == inputs
    assert inputs == 4


def test_presses_outside_training_are_kept_but_do_not_count(tmp_path):
    recording = imported(
        tmp_path, row("1.0", training="false"), row("2.0", presses="[{1.0 @ 1.25}]"), terminal("3.0")
    )
    assert [p.verdict for p in of_type(recording, KeyPressed)] == ["not-playing"]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("1:2:3", "expected 8 fields separated by colons, got 3"),
        (row("2.0").replace("[0, ", "[x, ", 1), "not a list of integers"),
        ("[4, 0]:[]:[1]:[]:0.0:[]:true:2.0", "expected 200 cells and 7 numbers of state, got 2 in all"),
        (row("2.0", piece=9), "expected a piece id from 0 to 6, got 9"),
        (row("2.0", presses="[{1.0 at 3}]"), "expected presses as"),
        (row("2.0", presses="[{1.0 @ }]"), "expected presses as"),
        (row("2.0", training="maybe"), "expected true or false for training, got 'maybe'"),
        (row("soon"), "expected a time in seconds, got 'soon'"),
        (row("2.0", reward="much"), "could not convert string to float"),
    ],
    ids=lambda text: text[-30:],
)
def test_a_line_that_cannot_be_understood_is_named_with_file_line_and_reason(tmp_path, line, reason):
    log = tmp_path / "bad.log"
    log.write_text("\n".join([PARAMETERS, row("1.0"), line, "finished"]))
    with pytest.raises(TamerLogError, match=rf"bad\.log:3: .*{reason}"):
        import_tamer_log(log, tmp_path / "bad.jsonl")
    assert not (tmp_path / "bad.jsonl").exists()


@pytest.mark.parametrize("content", ["", "hello", PARAMETERS, PARAMETERS + "\nfinished"])
def test_a_file_without_a_step_is_refused(tmp_path, content):
    log = tmp_path / "empty.log"
    log.write_text(content)
    with pytest.raises(TamerLogError, match=r"empty\.log"):
        read_tamer_log(log)


KNOWN_COUNTS = {"130": (952, 756), "135": (754, 841), "137": (761, 798), "157": (750, 2066)}
"""Placements and distinct presses per public log."""


@pytest.mark.parametrize("log", data_files("tamer_tetris", pattern="*.log"), ids=lambda path: path.stem)
def test_real_logs_are_imported_whole(log, tmp_path):
    data_folder("tamer_tetris")
    if "tetris" not in log.read_text()[:2000].lower():
        with pytest.raises(TamerLogError, match="is this the log of another domain"):
            import_tamer_log(log, tmp_path / "out.jsonl")
        return
    report = import_tamer_log(log, tmp_path / "out.jsonl")
    recording = read_recording(tmp_path / "out.jsonl")
    presses = of_type(recording, KeyPressed)
    assert [p.time_ns for p in presses] == sorted(p.time_ns for p in presses)
    assert len({(p.time_ns, p.value) for p in presses}) == len(presses) == report.presses
    assert len(of_type(recording, StepTaken)) == report.placements
    if log.stem in KNOWN_COUNTS:
        assert (report.placements, report.presses) == KNOWN_COUNTS[log.stem]
