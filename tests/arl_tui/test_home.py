"""Where things are kept: --recordings, else ARL_HOME, else one documented place."""

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from arl_tui.cli import main
from arl_tui.home import elsewhere, home, recordings_folder, why_here
from tests.arl_tui.test_cli import write_recording


def arl(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture
def data_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the user's data folder of a made-up home, without ARL_HOME."""
    monkeypatch.delenv("ARL_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return tmp_path / "data"


def test_without_a_word_it_is_the_user_s_data_folder(data_home: Path) -> None:
    assert recordings_folder() == data_home / "arl" / "recordings"
    assert why_here() == "the default; ARL_HOME is not set"
    assert not data_home.exists(), "asking where makes no folder"


def test_arl_home_comes_before_it(data_home: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ARL_HOME", "~/lab")
    assert home() == tmp_path / "home" / "lab"
    assert why_here() == "by ARL_HOME"


def test_an_option_comes_before_both(tmp_path: Path) -> None:
    write_recording(tmp_path / "here" / "a.jsonl")
    result = arl("recordings", "--recordings", tmp_path / "here")
    assert f"Recordings in {tmp_path / 'here'}:" in result.output


def test_an_empty_arl_home_is_none(data_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARL_HOME", "  ")
    assert recordings_folder() == data_home / "arl" / "recordings"


def test_the_folder_one_stands_in_does_not_matter(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("ARL_HOME", str(tmp_path / "lab"))
    write_recording(tmp_path / "lab" / "recordings" / "a.jsonl")
    for folder in (tmp_path, tmp_path / "lab"):
        monkeypatch.chdir(folder)
        result = arl("recordings")
        assert result.exit_code == 0
        assert f"Recordings in {tmp_path / 'lab' / 'recordings'} (by ARL_HOME):" in result.output
        assert "a.jsonl" in result.output


def test_a_relative_arl_home_is_made_absolute(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ARL_HOME", "lab")
    assert recordings_folder() == tmp_path / "lab" / "recordings"


@pytest.mark.parametrize("command", [(), ("--help",)])
def test_the_command_says_which(
    command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ARL_HOME", str(tmp_path))
    said = "".join(arl(*command).output.split())
    assert f"{tmp_path}/recordings(byARL_HOME)".replace(" ", "") in said


def test_recordings_where_earlier_versions_kept_them_are_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ARL_HOME", str(tmp_path / "my lab"))
    assert elsewhere(recordings_folder()) is None
    write_recording(tmp_path / "recordings" / "old.jsonl")
    said = arl("recordings").output
    assert f"There are recordings in {tmp_path / 'recordings'}, too" in said
    assert f"`mv {tmp_path / 'recordings'} '{tmp_path / 'my lab' / 'recordings'}'`" in said


def test_a_demo_without_a_terminal_records_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    from arl_tui.commands import demo
    from tests.core.sessions import small_protocol

    monkeypatch.setattr(demo, "demo_protocol", lambda game, somebody=None: small_protocol())
    monkeypatch.setenv("ARL_HOME", str(tmp_path / "my lab"))
    result = arl("demo", "--seed", 3)
    assert result.exit_code == 0, result.output
    (path,) = (tmp_path / "my lab" / "recordings").glob("demo-*.jsonl")
    assert f"arl replay '{path}' --credit previous" in result.output
