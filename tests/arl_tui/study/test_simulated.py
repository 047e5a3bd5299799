"""Simulated participants of a study: they finish it by keys alone, and nobody takes their files for
people's."""

import csv
import re
from collections import Counter

import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from core.recording.reader import read_recording
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import build_session
from studies.exports.tidy import export_tidy, simulated_note
from studies.lab.sitting_log import read_sitting

STUDY = """
name = "small"
seed = 5
participants = 4
[protocol]
delay_of = "feedback-lag"
[protocol.session]
episodes = 1
watched_steps = 3
[conditions.linear.agent.scheme]
type = "linear"
[conditions.annealed.agent.scheme]
type = "annealed"
[assignment]
type = "latin-square"
[[sittings]]
name = "day 1"
steps = [
  { type = "consent", text = "consent.md" },
  { type = "practice", games = 1 },
  { type = "calibration", trials = 20, practice = 2 },
  { type = "block" },
  { type = "break", shortest_s = 30 },
  { type = "block" },
  { type = "questionnaire", questions = "taught" },
  { type = "debriefing", text = "consent.md" },
]
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    folder = tmp_path_factory.mktemp("study")
    (folder / "consent.md").write_text("# Consent\n" + "\nA paragraph.\n" * 30)
    (folder / "study.toml").write_text(STUDY)
    result = CliRunner().invoke(
        main,
        ["study", "simulate", str(folder / "study.toml"), "--participants", "2", "--recordings", str(folder)],
    )
    assert result.exit_code == 0, result.output
    return folder


def sessions(home):
    """Recordings of sessions, in order of participants and steps."""
    found = [path for path in home.rglob("SIM*.jsonl") if path.parent.name != "calibration"]
    return sorted(found, key=lambda path: (path.parent, read_recording(path).header.study["step"]))


def sittings(home):
    return [read_sitting(path) for path in sorted(home.rglob("sitting-1.jsonl"))]


def test_every_simulated_participant_finishes(home):
    assert [lines[-1].how for _, lines in sittings(home)] == ["finished", "finished"]


def test_every_file_says_that_it_is_simulated(home):
    data = home / "studies" / "small-simulated"
    assert {header.simulated for header, _ in sittings(home)} == {True}
    recordings = sessions(home)
    assert all(path.is_relative_to(data) for path in recordings)
    assert len(recordings) == 6
    assert {read_recording(path).header.origin for path in recordings} == {"simulated"}
    assert [path for path in (home / "studies").iterdir() if not path.name.endswith("-simulated")] == []


def test_their_recordings_name_condition_and_place_and_replay_exactly(home):
    for path in sessions(home):
        recording = read_recording(path)
        study = recording.header.study
        assert (study["study"], study["kind"]) == ("small", "practice" if study["step"] == "1" else "block")
        assert (study["condition"] in ("linear", "annealed")) == (study["kind"] == "block")
        protocol = protocol_from(recording.header.protocol)
        assert (
            replay_exactly(recording, build_session(protocol, recording.header.root_seed)).difference is None
        )


def test_each_block_of_a_condition_is_drawn_on_the_real_screens_once(home):
    headers = [read_recording(path).header for path in sessions(home)]
    drawn = [(header.study["step"], header.study["condition"]) for header in headers if header.terminal]
    all_kinds = {(header.study["step"], header.study["condition"]) for header in headers}
    assert sorted(drawn) == sorted(all_kinds)


def test_the_check_says_what_the_sessions_of_every_condition_do(home):
    arguments = ["study", "check", str(home / "study.toml")]
    told = " ".join(CliRunner().invoke(main, arguments).output.split())
    for condition, weight in (
        ("linear", "linear: w_h by bootstrap learning"),
        ("annealed", "annealed: w_r = 1"),
    ):
        sessions_of = told.partition(f"Sessions of condition {condition}:")[2]
        for topic in ("Games", "Presses", f"Weight {weight}", "Credit each participant", "Compiled", "Reach"):
            assert topic in sessions_of.partition("Sessions of condition")[0], topic


def test_status_of_simulated_participants_is_shown_apart(home):
    arguments = ["study", "status", str(home / "study.toml"), "--recordings", str(home)]
    assert "Nobody has taken part yet" in CliRunner().invoke(main, arguments).output
    assert "2 of 4 have finished" in CliRunner().invoke(main, [*arguments, "--simulated"]).output
    assert "Nobody has taken part yet" in CliRunner().invoke(main, ["study", "status", str(home)]).output


def test_the_folder_of_a_study_stands_for_its_file(tmp_path):
    shown = CliRunner().invoke(main, ["study", "status", str(tmp_path)])
    assert shown.exit_code == 2
    assert f"File '{tmp_path / 'study.toml'}' does not exist" in shown.output


def test_every_table_and_the_archive_say_that_they_are_simulated(home, tmp_path):
    data = home / "studies" / "small-simulated"
    exported = export_tidy(data, tmp_path / "tables")
    assert "in 6 of 6 sessions a simulated participant pressed" in simulated_note(exported.origins)
    assert simulated_note(Counter(live=3)) == ""
    for path in (tmp_path / "tables").glob("*.csv"):
        with path.open(newline="") as file:
            rows = list(csv.DictReader(file))
        if path.name != "settings.csv":  # a row per setting: sessions are joined by name
            assert {row["origin"] for row in rows} <= {"simulated"}, path.name
    assert exported.rows["trials"] > 0
    options = ["--out", str(tmp_path / "archive"), "--key", str(tmp_path / "key")]
    result = CliRunner().invoke(main, ["archive", str(data), *options])
    assert result.exit_code == 0, result.output
    assert "SIMULATED: in 6 of 6 sessions" in (tmp_path / "archive" / "README.md").read_text()


def test_minutes_are_those_of_the_simulated_sessions(home):
    """Each participant reads, waits half a minute, and plays 1 practice game and 2 blocks of 1 game."""
    for header, lines in sittings(home):
        played = 0
        for path in sessions(home):
            recording = read_recording(path)
            if recording.header.participant == header.participant:
                played += recording.events[-1].time_ns - recording.header.started_ns
        calibration, pause = 32 * 6, 30
        taken_s = (lines[-1].time_ns - header.started_ns) / 1e9
        assert taken_s > played / 1e9 + calibration + pause
        arguments = ["study", "status", str(home / "study.toml"), "--recordings", str(home), "--simulated"]
        told = " ".join(CliRunner().invoke(main, arguments).output.split())
        minutes = int(re.search(rf"{header.participant} .*? (\d+) min,", told)[1])
        assert minutes == pytest.approx(taken_s / 60, abs=1.0)


def test_blocks_after_a_calibration_go_by_the_delay_that_it_measured(home):
    blocks = [read_recording(path) for path in sessions(home)]
    blocks = [block for block in blocks if block.header.study["kind"] == "block"]
    assert len(blocks) == 4
    for block in blocks:
        source = block.header.source
        assert (source["credit"], source["credit_asked_by"]) == ("feedback-lag", "protocol")
        folder = block.path.parent / "calibration"
        assert (folder / source["credit_files"]).exists()
        assert "simulated" in (folder / source["credit_files"]).read_text()
