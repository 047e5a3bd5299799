"""`arl replay` and `arl import`: what they print, and with which status they leave."""

import csv
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from arl_tui.commands.replay import table as table_of
from core.episode import EpisodeEnded, StopAsked
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from studies.statistics import Interval
from studies.what_if import WhatIfRow
from tests.data_folder import REPOSITORY, data_folder

GOLDEN = REPOSITORY / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_an_exact_replay_says_so() -> None:
    result = run("replay", GOLDEN)
    assert result.exit_code == 0, result.output
    assert "Replay: exact" in result.output
    assert "bit for bit" in result.output


def test_the_first_difference_is_shown_with_both_values_and_status_1(tmp_path: Path) -> None:
    recording = read_recording(GOLDEN)
    writer = LineWriter(tmp_path / "changed.jsonl", recording.header)
    changed = next(event for event in recording.events if isinstance(event, EpisodeEnded))
    for event in recording.events:
        writer.write(msgspec.structs.replace(event, w_h=0.123) if event is changed else event)
    writer.close()
    result = run("replay", tmp_path / "changed.jsonl")
    assert result.exit_code == 1
    assert "w_h was 0.123" in result.output
    assert f"is {changed.w_h!r} now" in result.output
    assert "recorded with other software: arl-tui (not said), now" in result.output


def test_a_session_whose_learner_died_replays_up_to_there(tmp_path: Path) -> None:
    recording = read_recording(GOLDEN)
    writer = LineWriter(tmp_path / "died.jsonl", recording.header)
    for event in recording.events[: len(recording.events) // 2]:
        writer.write(event)
    writer.write(StopAsked(time_ns=10**15, reason="worker-died"))
    writer.close()
    result = run("replay", tmp_path / "died.jsonl")
    assert result.exit_code == 0, result.output
    assert "ended: worker died" in result.output
    assert "the recording ends there" in result.output


def test_columns_stand_below_each_other_however_long_the_scores_are() -> None:
    rows = [
        WhatIfRow(rule, "human-only", (0.5,), 0.11, 0.18, share, Interval(score, score - 1, score + 1), cut)
        for rule, score, cut, share in (("current", 4.7, 0.0, 0.98), ("uniform:0.2,0.8", 101975.3, 0.8, 1.0))
    ]
    head, *lines = table_of(rows)
    for heading, texts in (("log-loss (rate)", ["0.110 (0.180)"] * 2), ("on steps", ["98%", "100%"])):
        end = head.index(heading) + len(heading)
        assert [line[:end].endswith(text) for line, text in zip(lines, texts, strict=True)] == [True, True]
    assert "101975.3 [101974.3, 101976.3] 80% cut" in lines[1]


def test_what_if_prints_a_row_per_rule_and_writes_table_and_figure(tmp_path: Path) -> None:
    table, figure = tmp_path / "t.csv", tmp_path / "f.png"
    options = [
        "--credit",
        "previous",
        "--credit",
        "gamma:2.5,0.3",
        "--scheme",
        "human-only",
        "--workers",
        "1",
    ]
    result = run("replay", GOLDEN, *options, "--games", "3", "--csv", table, "--plot", figure)
    assert result.exit_code == 0, result.output
    with table.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["credit"], row["scheme"]) for row in rows] == [
        ("previous", "human-only"),
        ("gamma:2.5,0.3", "human-only"),
    ]
    for row in rows:
        assert row["credit"] in result.output
        assert float(row["lines_low"]) <= float(row["lines"]) <= float(row["lines_high"])
        assert 0.0 <= float(row["credited"]) <= 1.0
    assert figure.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--credit", "sometimes"), "unknown credit rule 'sometimes'"),
        (("--scheme", "nope"), "'nope': use one of linear"),
        (("--csv", "x.csv"), "name a rule"),
    ],
)
def test_a_wrong_option_is_refused_with_what_would_be_right(options: tuple[str, ...], reason: str) -> None:
    result = run("replay", GOLDEN, *options)
    assert result.exit_code == 2
    assert reason in " ".join(result.output.split())


def test_an_imported_log_is_counted_and_cannot_be_run_again(tmp_path: Path) -> None:
    log = data_folder("tamer_tetris") / "137.log"
    result = run("import", "tamer-log", log, "--recordings", tmp_path)
    assert result.exit_code == 0, result.output
    path = tmp_path / "imported" / "137.jsonl"
    assert str(path) in result.output
    assert "761 placements" in result.output
    again = run("import", "tamer-log", log, "--recordings", tmp_path)
    assert again.exit_code == 1
    replayed = run("replay", path)
    assert replayed.exit_code == 1
    assert "--credit" in replayed.output


def test_a_log_that_is_none_is_refused_with_line_and_reason(tmp_path: Path) -> None:
    log = tmp_path / "x.log"
    log.write_text("nothing\nof the kind\n")
    result = run("import", "tamer-log", log, "--recordings", tmp_path)
    assert result.exit_code == 1
    assert "x.log" in result.output
