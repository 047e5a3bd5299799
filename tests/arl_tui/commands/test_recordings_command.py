"""`arl recordings` and `arl replay`: what a file is said to be, by both in the same words."""

import csv
import gzip
import os
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from core.events import StopAsked
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from core.recording.schema import VERSION
from core.recording.summary import summarise_recording
from tests.arl_tui.fakes import episode_ended, episode_started, session_ended
from tests.arl_tui.test_cli import header, press, write_recording
from tests.data_folder import REPOSITORY

GOLDEN = REPOSITORY / "recordings" / "reference" / "tetris-linear-equation-4.jsonl"


def arl(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def words(text: str) -> str:
    return " ".join(text.split())


def test_every_damaged_file_is_named_and_none_hides_another(tmp_path: Path) -> None:
    whole = write_recording(tmp_path / "d-sound.jsonl").read_bytes()
    (tmp_path / "a-empty.jsonl").touch()
    (tmp_path / "b-changed.jsonl").write_bytes(whole.replace(b'"key":"j"', b'"key":"f"'))
    (tmp_path / "c-folder.jsonl").mkdir()
    later = f'"version":{VERSION + 1}'.encode()
    (tmp_path / "e-newer.jsonl").write_bytes(whole.replace(f'"version":{VERSION}'.encode(), later))
    (tmp_path / "f-gone.jsonl").symlink_to(tmp_path / "nowhere")
    (tmp_path / "g.jsonl.gz").write_bytes(gzip.compress(whole))
    (tmp_path / "h.jsonl.zip").write_bytes(b"PK\x03\x04")
    (tmp_path / "i-binary.jsonl").write_bytes(bytes(range(256)))
    result = arl("recordings", "--recordings", tmp_path)
    assert result.exit_code == 1
    said = words(result.output)
    for name, reason in (
        ("a-empty.jsonl", "0 bytes"),
        ("b-changed.jsonl", ":3: the line's chain"),
        ("c-folder.jsonl", "a folder, not a recording"),
        ("e-newer.jsonl", "newer than this program"),
        ("f-gone.jsonl", "No such file"),
        ("h.jsonl.zip", "unpack it"),
        ("i-binary.jsonl", "not a recording"),
    ):
        assert f"{name} DAMAGED" in said
        assert reason in said
    assert "d-sound.jsonl P01 live" in said
    assert "g.jsonl.gz P01 live" in said
    assert "beware: the file is compressed (gzip)" in said
    assert "2 sound, 7 damaged." in said


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names here")
def test_a_pipe_among_the_recordings_is_named_and_not_waited_for(tmp_path: Path) -> None:
    write_recording(tmp_path / "sound.jsonl")
    os.mkfifo(tmp_path / "pipe.jsonl")
    result = arl("recordings", "--recordings", tmp_path)
    assert result.exit_code == 1
    assert "pipe.jsonl: a pipe or a device, not a file" in words(result.output)
    assert "1 sound" in words(result.output)


def test_a_hostile_name_in_a_file_moves_no_cursor(tmp_path: Path) -> None:
    import msgspec

    changed = msgspec.structs.replace(header(), participant="P\x1b[2J01", protocol={"name": "x\ny\x1b[31m"})
    writer = LineWriter(tmp_path / "a.jsonl", changed)
    writer.close()
    result = arl("recordings", "--recordings", tmp_path)
    assert "\x1b" not in result.output
    assert r"P\x1b[2J01" in result.output


def test_the_table_holds_a_row_for_every_file(tmp_path: Path) -> None:
    folder = tmp_path / "recordings"
    write_recording(folder / "a.jsonl")
    (folder / "b.jsonl").touch()
    result = arl("recordings", "--recordings", folder, "--csv", tmp_path / "list.csv")
    assert result.exit_code == 1
    with (tmp_path / "list.csv").open(newline="", encoding="utf-8") as file:
        sound, damaged = csv.DictReader(file)
    assert (sound["state"], sound["game"], sound["protocol"]) == ("sound", "tetris", "default")
    assert (sound["games_finished"], sound["games_planned"]) == ("1", "10")
    assert (sound["presses_counted"], sound["presses_taken_back"]) == ("1", "0")
    assert (sound["ended"], sound["ended_in_words"]) == ("finished", "finished")
    assert (damaged["file"], damaged["state"]) == (str(folder / "b.jsonl"), "damaged")
    assert "0 bytes" in damaged["reason"]
    assert damaged["games_finished"] == ""


def test_a_folder_that_is_not_there_holds_nothing(tmp_path: Path) -> None:
    result = arl("recordings", "--recordings", tmp_path / "none")
    assert result.exit_code == 0
    assert "There are no recordings" in result.output
    assert not (tmp_path / "none").exists()


def test_calibrations_are_counted_and_not_taken_for_sessions(tmp_path: Path) -> None:
    (tmp_path / "calibration").mkdir()
    (tmp_path / "calibration" / "P01-simple.jsonl").write_text("trials\n")
    result = arl("recordings", "--recordings", tmp_path)
    assert result.exit_code == 0
    assert "Calibrations: 1 file of trials" in result.output


def test_both_commands_use_the_same_words(tmp_path: Path) -> None:
    recording = read_recording(GOLDEN)
    writer = LineWriter(tmp_path / "closed.jsonl", recording.header)
    for event in recording.events[: len(recording.events) // 2]:
        writer.write(event)
    writer.write(StopAsked(time_ns=10**15, reason="window-closed"))
    writer.close()
    listed = words(arl("recordings", "--recordings", tmp_path).output)
    replayed = words(arl("replay", tmp_path / "closed.jsonl").output)
    said = summarise_recording(read_recording(tmp_path / "closed.jsonl")).words
    assert "ended: window closed, and the worker gave no answer" in said
    assert said in listed
    assert said in replayed


@pytest.mark.parametrize("options", [(), ("--credit", "previous")])
def test_a_recording_without_a_game_is_not_exact(tmp_path: Path, options: tuple[str, ...]) -> None:
    writer = LineWriter(tmp_path / "a.jsonl", header())
    writer.write(press())
    writer.abandon()
    result = arl("replay", tmp_path / "a.jsonl", *options)
    assert result.exit_code == 1
    said = words(result.output)
    assert "there is nothing to replay: no game is in the recording" in said
    assert "killed before the first game" in said
    assert "exact" not in said


def test_what_is_unusual_about_a_file_is_said_by_the_replay(tmp_path: Path) -> None:
    (tmp_path / "a.jsonl").write_bytes(GOLDEN.read_bytes().replace(b"\n", b"\r\n"))
    result = arl("replay", tmp_path / "a.jsonl")
    assert result.exit_code == 0, result.output
    assert "Beware: the lines end as on Windows (CR LF)" in words(result.output)
    assert "Replay: exact" in result.output


def test_publishing_copies_the_sound_ones_and_names_the_others(tmp_path: Path) -> None:
    folder, out = tmp_path / "recordings", tmp_path / "out"
    write_recording(folder / "P01-20261122T071803Z.jsonl")
    (folder / "b.jsonl").touch()
    result = arl("recordings", "--recordings", folder, "--publish", out)
    assert result.exit_code == 1
    assert "Not copied:" in result.output
    assert [path.name for path in out.iterdir()] == ["P01-1.jsonl"]
    assert "2026" not in (out / "P01-1.jsonl").read_text()
    again = arl("recordings", "--recordings", folder, "--publish", out)
    assert "is not empty: name a new folder" in words(again.output)
    within = arl("recordings", "--recordings", folder, "--publish", folder / "out")
    assert "each session would be listed twice: name a folder elsewhere" in words(within.output)
    assert not (folder / "out").exists()


def test_a_game_that_was_broken_off_is_not_finished(tmp_path: Path) -> None:
    import msgspec

    writer = LineWriter(tmp_path / "a.jsonl", header())
    broken_off = msgspec.structs.replace(episode_ended(1), ended="truncation")
    stop = StopAsked(time_ns=5, reason="participant")
    for event in (episode_started(), episode_ended(), episode_started(1), stop, broken_off, session_ended()):
        writer.write(event)
    writer.close()
    said = words(arl("recordings", "--recordings", tmp_path).output)
    assert "1 of 10 games finished; 0 presses counted; ended: stopped by the participant" in said


def test_options_of_the_list_are_refused_where_another_command_follows(tmp_path: Path) -> None:
    csv, new = tmp_path / "list.csv", tmp_path / "new"
    result = CliRunner().invoke(main, ["recordings", "--csv", str(csv), "upgrade", str(tmp_path), str(new)])
    assert result.exit_code == 2
    assert "not for upgrade" in result.output
