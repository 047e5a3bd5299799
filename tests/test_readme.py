"""What the README tells a stranger to type exists, and its example runs."""

import re
import shlex
from pathlib import Path

import click
import pytest

from arl_tui.cli import main

REPOSITORY = Path(__file__).resolve().parents[1]
README = (REPOSITORY / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w*)\n(.*?)```", README, re.DOTALL)


def commands() -> list[str]:
    """Return every command line with `arl`: those of blocks, and those in the text."""
    lines = [line for language, text in BLOCKS if not language for line in text.splitlines()]
    found = [line.split("#")[0].split("&&")[-1].strip() for line in lines]
    found += [command.replace("\n", " ") for command in re.findall(r"`(arl [^`]*)`", README)]
    return sorted({re.sub(r"^\S*/arl ", "arl ", line) for line in found if re.match(r"(\S*/)?arl ", line)})


def test_there_are_commands_to_check():
    assert len(commands()) >= 15


@pytest.mark.parametrize("line", commands())
def test_a_command_and_its_options_exist(line: str):
    words = [word for word in shlex.split(line.split(">")[0])[1:] if word != "..."]
    command: click.Command = main
    while isinstance(command, click.Group) and words:
        name = words.pop(0)
        assert name in command.commands, f"{line}: no command {name}"
        command = command.commands[name]
    known = {option for parameter in command.params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known


def test_the_example_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    monkeypatch.chdir(REPOSITORY)
    (example,) = [text for language, text in BLOCKS if language == "python"]
    exec(example, {})  # noqa: S102 - our own text
    assert "difference=None" in capsys.readouterr().out
