"""What `arl calibrate` says and refuses outside its screens."""

from pathlib import Path

import click
import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from arl_tui.commands import calibrate as command
from arl_tui.participants import read_delays
from studies.reaction_time.schedule import make_schedule
from tests.arl_tui.calibrating import quick
from tests.arl_tui.trial_files import judgements, write_session


def run(*arguments: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, ["calibrate", *arguments])
    return result.exit_code, result.output


def test_a_dry_run_prints_every_trial_and_needs_no_terminal(tmp_path: Path) -> None:
    common = ("--participant", "P01", "--dry-run", "--recordings", str(tmp_path), "--tasks", "simple,choice")
    code, text = run(*common, "--seed", "4", "--trials", "6", "--practice", "2")
    assert code == 0
    assert "simple: 8 trials in 2 blocks, seed 4" in text
    assert "choice: 8 trials" in text
    assert run(*common, "--seed", "4", "--trials", "6", "--practice", "2") == (code, text)
    assert list(tmp_path.iterdir()) == []


def test_a_browser_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TEXTUAL_DRIVER", "web")
    code, text = run("--participant", "P01")
    assert code == 1
    assert "browser" in text


@pytest.mark.parametrize(
    ("variables", "found"),
    [
        ({}, []),
        ({"SSH_CONNECTION": "1.2.3.4 5 6.7.8.9 22"}, ["ssh"]),
        ({"TMUX": "/tmp/x,1,0"}, ["tmux"]),
        ({"STY": "1.pts"}, ["screen"]),
        ({"SSH_TTY": "/dev/pts/1", "TMUX": "/tmp/x,1,0"}, ["ssh", "tmux"]),
    ],
)
def test_network_and_multiplexers_are_noticed(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], found: list[str]
) -> None:
    for name in ("SSH_CONNECTION", "SSH_TTY", "TMUX", "STY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert command.hindrances() == found


def test_refit_fits_what_is_there_and_pools_it_with_those_who_came_later(tmp_path: Path) -> None:
    arguments = ("--participant", "P0", "--refit", "--recordings", str(tmp_path), "--tasks", "simple,choice")
    code, text = run(*arguments)
    assert code == 1
    assert "has finished none of these tasks" in text
    schedule = make_schedule(quick("simple", n_trials=20), 3)
    for person in range(5):
        write_session(tmp_path, f"P{person}", schedule, judgements(person, 20, 0.4 + 0.02 * person))
    code, text = run(*arguments)
    assert code == 0, text
    assert "20 responses" in text
    assert "pooled with 4 others" in text
    known = read_delays(tmp_path, "P0")
    assert known is not None
    assert known.tasks["simple"].pooled_people == 5


def test_names_unknown_tasks_and_missing_terminals_are_refused(tmp_path: Path) -> None:
    assert run("--participant", "Jane Doe")[0] == 2
    code, text = run("--participant", "P01", "--tasks", "reading")
    assert code == 2
    assert "unknown task" in text
    code, text = run("--participant", "P01", "--recordings", str(tmp_path))
    assert code == 1
    assert "arl calibrate --dry-run" in text


def test_a_damaged_trial_file_is_named_before_anything_is_shown(tmp_path: Path) -> None:
    path = write_session(tmp_path, "P01", make_schedule(quick("simple"), 3), [0.3])
    path.write_text("rubbish\n")
    with pytest.raises(click.ClickException, match="Move the file away"):
        command.check_files(tmp_path, "P01")
