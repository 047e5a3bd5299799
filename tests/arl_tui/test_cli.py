"""The commands that need no terminal."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import COMMANDS, main
from arl_tui.command_line import NO_FILE, OWN_GAMES, Listed
from arl_tui.commands.demo import demo_protocol
from arl_tui.commands.protocol import toml_lines
from arl_tui.recordings import new_path
from core.events import KeyPressed
from core.feedback.simulated_participants import person, persons
from core.plugins import BUILT_IN
from core.recording.recorder import LineWriter
from core.recording.schema import Header, to_plain
from core.session.protocol import Protocol
from core.session.protocol_reading import load_protocol
from tests.arl_tui.command_tree import members
from tests.arl_tui.fakes import episode_ended, episode_started, session_ended

REPOSITORY = Path(__file__).resolve().parents[2]


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def header() -> Header:
    return Header(
        origin="live",
        created_utc="2026-11-22T07:18:03+00:00",
        clock="manual",
        clock_resolution_ns=1,
        started_ns=0,
        participant="P01",
        root_seed=1,
        protocol=to_plain(Protocol()),
        software={},
    )


def write_recording(path: Path, *, whole: bool = True) -> Path:
    writer = LineWriter(path, header())
    for event in (episode_started(), press(), episode_ended(), session_ended()):
        writer.write(event)
    writer.close() if whole else writer.abandon()
    return path


def press() -> KeyPressed:
    return KeyPressed(press=0, time_ns=1, key="j", value=1.0, frame=0, step=0, verdict="accepted")


@pytest.mark.parametrize(
    "command",
    [
        (),
        ("play",),
        ("demo",),
        ("replay",),
        ("import",),
        ("import", "tamer-log"),
        ("practice",),
        ("recordings",),
    ],
    ids=" ".join,
)
def test_every_command_explains_itself(command: tuple[str, ...]) -> None:
    result = run(*command, "--help")
    assert result.exit_code == 0
    assert "Usage:" in result.output


def test_what_each_command_is_for_fits_into_a_line() -> None:
    result = run("--help")
    assert result.exit_code == 0
    assert "..." not in result.output.partition("Commands:")[2]


def test_the_demo_names_all_who_can_press_and_refuses_others() -> None:
    help_text = " ".join(run("demo", "--help").output.split())
    assert all(name in help_text for name in persons())
    result = run("demo", "--person", "nobody")
    assert result.exit_code == 2
    assert "known are expert" in result.output


@pytest.mark.parametrize("game", ["tetris", "keepaway"])
def test_a_named_person_keeps_what_makes_them_who_they_are(game: str) -> None:
    adversary = demo_protocol(game, person("adversary")).trainer
    assert adversary.mistake_rate == person("adversary").mistake_rate
    assert adversary.max_presses == demo_protocol(game).trainer.max_presses


def test_the_package_can_be_run_as_a_module_under_the_commands_name() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "arl_tui", "calibrate", "--help"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("Usage: arl calibrate")


@pytest.mark.parametrize("name", ["", "Anna Maria", "../x", "a" * 33])
def test_a_participant_has_a_code_and_not_a_name_or_a_path(name: str) -> None:
    result = run("play", "tetris", "--participant", name)
    assert result.exit_code == 2
    assert "never a name" in result.output


def test_the_printed_protocol_is_a_protocol_file_that_gives_the_same_protocol(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text(run("protocol").output)
    assert load_protocol(path) == Protocol()


def test_a_wrong_protocol_is_refused_with_file_and_place(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text("[keys]\ngood = 'JJ'\n")
    result = run("protocol", "--protocol", path)
    assert result.exit_code == 1
    assert "p.toml" in result.output
    assert "keys" in result.output


def test_toml_lines_are_read_back_as_they_were() -> None:
    table = {
        "a": 1,
        "b": [1.5, 2.0],
        "c": 'quote " and \\',
        "d": True,
        "e": {"f": {"g": "x"}, "h": -0.25, "k": None},
        "i": None,
    }
    assert tomllib.loads("\n".join(toml_lines(table))) == {
        "a": 1,
        "b": [1.5, 2.0],
        "c": 'quote " and \\',
        "d": True,
        "e": {"f": {"g": "x"}, "h": -0.25},
    }


def test_recordings_are_listed_with_what_they_hold(tmp_path: Path) -> None:
    write_recording(tmp_path / "a.jsonl")
    write_recording(tmp_path / "sub" / "b.jsonl", whole=False)
    result = run("recordings", "--recordings", tmp_path)
    assert result.exit_code == 0
    where, first, held, second, also_held, count = result.output.splitlines()
    assert where == f"Recordings in {tmp_path}:"
    assert first == "a.jsonl  P01  live  2026-11-22 07:18:03 UTC"
    assert held.strip() == (
        "tetris, protocol default; 1 of 10 games finished; 1 press counted; ended: finished"
    )
    assert second.startswith("sub/b.jsonl")
    assert also_held.endswith("ended: finished, but the end of the file is missing")
    assert count == "2 sound, 0 damaged."


def test_a_damaged_recording_is_named_and_makes_the_command_fail(tmp_path: Path) -> None:
    path = write_recording(tmp_path / "a.jsonl")
    path.write_bytes(path.read_bytes().replace(b'"key":"j"', b'"key":"f"'))
    result = run("recordings", "--recordings", tmp_path)
    assert result.exit_code == 1
    assert f"{path}:3" in result.output.replace("\n", "")


def test_an_empty_folder_is_not_an_error(tmp_path: Path) -> None:
    result = run("recordings", "--recordings", tmp_path)
    assert result.exit_code == 0
    assert "no recordings" in result.output


def test_recordings_get_names_that_no_file_has(tmp_path: Path) -> None:
    first = new_path(tmp_path, "P01", "2026-11-22T07:18:03+00:00")
    assert first.name == "P01-20261122T071803Z.jsonl"
    first.touch()
    second = new_path(tmp_path, "P01", "2026-11-22T07:18:03+00:00")
    assert second.name == "P01-20261122T071803Z-2.jsonl"


def test_replay_of_something_else_says_so(tmp_path: Path) -> None:
    path = tmp_path / "x.jsonl"
    path.write_text("hello\n")
    result = run("replay", path)
    assert result.exit_code == 1
    assert "x.jsonl:1" in result.output


@pytest.mark.parametrize("listed", COMMANDS, ids=lambda listed: listed.name)
def test_the_list_of_commands_says_what_each_command_says(listed: Listed) -> None:
    command = listed.load()
    assert (command.name, command.short_help) == (listed.name, listed.short_help)


def test_an_unknown_command_is_refused() -> None:
    done = run("plya")
    assert done.exit_code == 2
    assert "No such command 'plya'" in done.output


def test_the_names_of_our_own_games_are_those_of_the_look_up() -> None:
    assert tuple(BUILT_IN) == OWN_GAMES


UNTRUSTED_FOLDER = """
import sys, warnings
from pathlib import Path

from arl_tui.command_line import Arl, note_or_warning
from core.numerics.kernel_files import KernelFiles

if "command" in sys.argv:
    warnings.formatwarning = note_or_warning  # as `Arl.main` does
KernelFiles(Path("none"), pruned=False).note("compiled code is damaged: compiling it anew")
"""


@pytest.mark.parametrize("words", [["command"], []], ids=["command", "library"])
def test_a_fault_of_the_compiled_code_is_one_line(tmp_path: Path, words: list[str]) -> None:
    # Python prints the line of the source where a warning comes from, and looks for it in files of that name:
    # the command's own, where that is `arl`.
    (tmp_path / "arl").write_text("#!/usr/bin/python\n")
    (tmp_path / "program.py").write_text(UNTRUSTED_FOLDER)
    done = subprocess.run(
        [sys.executable, str(tmp_path / "program.py"), *words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(REPOSITORY)},
        capture_output=True,
        text=True,
        check=True,
    )
    (line,) = done.stderr.splitlines()
    assert line.endswith("compiled code is damaged: compiling it anew")
    assert line.startswith("Note: compiled" if words else f"{NO_FILE}:1: ")


def test_the_name_in_place_of_a_file_is_that_of_the_kernel_files() -> None:
    from core.numerics import kernel_files

    assert kernel_files.NO_FILE == NO_FILE


def number_options(command: click.Command, name: str = "") -> list[tuple[str, click.Option]]:
    """Return every option with a number in a range, with the command's name."""
    found = [
        (name, option)
        for option in command.params
        if isinstance(option, click.Option) and isinstance(option.type, click.FloatRange)
    ]
    for below, inner in members(command) if isinstance(command, click.Group) else ():
        found += number_options(inner, f"{name} {below}".strip())
    return found


def test_no_option_takes_what_is_not_a_number() -> None:
    options = number_options(main)
    assert len(options) >= 7
    for name, option in options:
        with pytest.raises(click.BadParameter, match="nan is not a number"):
            option.type.convert("nan", option, None)
        assert option.type.convert("0.5", option, None) == 0.5, name
