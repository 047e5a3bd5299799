"""What the header says about program and terminal."""

import subprocess
from pathlib import Path

import pytest

from arl_tui.app import facts


def test_versions_of_everything_that_numbers_depend_on_are_there() -> None:
    software = facts.software()
    assert {"arl-tui", "python", "tetris play", "keepaway play", *facts.LIBRARIES} <= software.keys()
    assert "not installed" not in software.values()


def test_software_that_is_not_the_same_is_named_with_both_versions() -> None:
    now = facts.software()
    assert facts.differing(now) == []
    assert facts.differing({**now, "numba": "0.1", "compiler": "gone"}) == [f"numba 0.1, now {now['numba']}"]
    assert f"keepaway play (not said), now {now['keepaway play']}" in facts.differing({})


def git(folder: Path, *arguments: str) -> None:
    identity = ["-c", "user.name=x", "-c", "user.email=x@example.org"]
    subprocess.run(["git", "-C", str(folder), *identity, *arguments], check=True, capture_output=True)


def test_the_commit_is_named_and_says_when_files_differ_from_it(tmp_path: Path) -> None:
    assert facts.git_commit(tmp_path) is None
    git(tmp_path, "init")
    (tmp_path / "a").write_text("1")
    git(tmp_path, "add", "a")
    git(tmp_path, "commit", "-m", "x")
    clean = facts.git_commit(tmp_path)
    assert clean is not None
    assert len(clean) == 40
    (tmp_path / "a").write_text("2")
    assert facts.git_commit(tmp_path) == f"{clean}+changes"


@pytest.mark.parametrize(
    ("variables", "expected"),
    [
        ({}, "local"),
        ({"SSH_CONNECTION": "1.2.3.4 1 5.6.7.8 22"}, "ssh"),
        ({"TEXTUAL_DRIVER": "textual.drivers.web_driver:WebDriver"}, "web"),
    ],
)
def test_the_connection_is_told_from_the_environment(
    monkeypatch: pytest.MonkeyPatch, variables: dict[str, str], expected: str
) -> None:
    for name in ("SSH_CONNECTION", "TEXTUAL_DRIVER"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert facts.connection() == expected


def test_a_multiplexer_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TMUX", "/tmp/tmux-0/default,1,0")
    found = facts.terminal(80, 24, stamps="flush", frames_per_s=30)
    assert found["multiplexer"] == "tmux"
    assert found["size"] == "80x24"
    assert found["stamps"] == "flush"


def test_no_address_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SSH_CONNECTION", "10.1.2.3 1 5.6.7.8 22")
    assert "10.1.2.3" not in str(facts.terminal(80, 24, stamps="flush", frames_per_s=30))


def test_the_clock_has_a_name_and_a_resolution() -> None:
    name, resolution_ns = facts.clock_facts()
    assert name
    assert 1 <= resolution_ns <= 20_000_000
