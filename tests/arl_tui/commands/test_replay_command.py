"""`arl replay` and `arl import`: what they print, and with which status they leave."""

import csv
import math
import re
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from arl_tui.commands.what_if_table import table as table_of
from core.events import EpisodeEnded, StopAsked
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from studies.statistics import Interval
from studies.what_if import HeldOut, WhatIfRow
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
        writer.write(msgspec.structs.replace(event, trust=0.123) if event is changed else event)
    writer.close()
    result = run("replay", tmp_path / "changed.jsonl")
    assert result.exit_code == 1
    assert "trust was 0.123" in result.output
    assert f"is {changed.trust!r} now" in result.output
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


def row(**changes: object) -> WhatIfRow:
    settings = {
        "credit": "previous",
        "scheme": "human-only",
        "per": None,
        "trust": (0.5,),
        "episode": 910,
        "watched": 10,
        "weight": 1.0,
        "handover": 0.0,
        "shaping": 0.0,
        "held_out": HeldOut(0.11, 0.18),
        "credited": 0.98,
        "lines": Interval(4.7, 3.7, 5.7),
        "difference": None,
        "capped": 0.0,
    }
    return WhatIfRow(**settings | changes)  # type: ignore[arg-type]


def test_columns_stand_below_each_other_however_long_the_scores_are() -> None:
    scores = Interval(101975.3, 101974.3, 101976.3)
    rows = [
        row(credit="current"),
        row(
            credit="uniform:0.2,0.8",
            lines=scores,
            capped=0.8,
            credited=1.0,
            difference=Interval(9.0, -1.0, 19.0),
        ),
    ]
    lines = list(table_of(rows))
    for heading, texts in (
        ("lines per game", ["4.7 [3.7, 5.7]", "101975.3 [101974.3, 101976.3] 80% cut"]),
        ("minus the first row", ["-", "+9.0 [-1.0, +19.0]"]),
        ("weight in use", ["1", "1"]),
        ("log-loss", ["0.110", "0.110"]),
        ("of the rate", ["0.180", "0.180"]),
        ("model is", ["better", "better"]),
        ("on steps", ["98%", "100%"]),
    ):
        at = next(number for number, line in enumerate(lines) if heading in line)
        end = lines[at].index(heading) + len(heading)
        assert [line[:end].endswith(text) for line, text in zip(lines[at + 1 :], texts, strict=False)] == [
            True,
            True,
        ]


def test_no_line_of_the_readmes_example_is_wider_than_a_terminal() -> None:
    rows = [
        row(credit="gamma:2.5,0.3", scheme="linear", trust=tuple([0.1] * 30)),
        row(
            credit="gamma:2.5,0.3",
            scheme="annealed",
            per="watched-game",
            difference=Interval(-79.1, -88.2, -60.0),
        ),
    ]
    assert max(map(len, table_of(rows))) <= 110
    # A narrower one gets numbers for rows, and a list of what they stand for; no figure is left out.
    narrow = list(table_of(rows, width=80))
    assert max(map(len, narrow)) <= 80
    assert narrow[:3] == [
        "row  credit         scheme",
        "1    gamma:2.5,0.3  linear",
        "2    gamma:2.5,0.3  annealed:watched-game",
    ]
    wide = "\n".join(table_of(rows))
    assert all(word in wide for line in narrow[3:] for word in line.split()[1:])


def test_what_is_missing_or_worse_than_a_guess_is_said() -> None:
    nothing = HeldOut(math.nan, math.nan, "8 presses to learn from, all of them praise: it takes both kinds")
    text = "\n".join(
        table_of(
            [
                row(credit="previous", held_out=nothing, credited=math.nan),
                row(credit="current", held_out=HeldOut(0.9, 0.6)),
            ]
        )
    )
    assert "nan" not in text
    assert "No log-loss under previous: 8 presses to learn from, all of them praise" in text
    assert re.search(r"current .* 0\.900 +0\.600 +worse", text)
    assert "worse than a constant guess" in text
    assert "on steps: no press counted" in text


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"scheme": "annealed", "per": "episode", "weight": 1.04e-8}, "annealed:episode .* 1e-08"),
        (
            {"scheme": "control-sharing", "per": "watched-game", "weight": 0.0, "handover": 0.82},
            "handover 0.82",
        ),
        ({"scheme": "reward-shaping", "per": "watched-game", "weight": 0.0, "shaping": 0.82}, "reward 0.82"),
    ],
)
def test_the_weight_in_use_is_beside_the_score_and_trust_elsewhere(changes: dict, expected: str) -> None:
    head, _, line, *rest = table_of([row(trust=(0.25,), **changes)])
    assert "number 910, after 10 watched games" in head
    assert re.search(expected, line)
    assert "0.25" not in line
    assert "0.25" in "\n".join(rest)


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
        assert (row["weight"], row["episode"], row["watched_games"]) == ("1.0", "43", "3")
        assert len(row["trust"].split()) == 3
    first, second = rows
    assert first["difference_to_first_row"] == ""
    assert float(second["difference_to_first_row"]) == pytest.approx(
        float(second["lines"]) - float(first["lines"])
    )
    assert figure.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        (("--credit", "sometimes"), "unknown credit rule 'sometimes'"),
        (("--scheme", "nope"), "'nope': use one of linear"),
        (("--scheme", "linear:episode"), "the weight of linear does not fall"),
        (("--scheme", "coach"), "coach needs a learner with a softmax policy"),
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
