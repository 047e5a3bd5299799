"""What is written about participants: who can read it, and what it says of the computer and its user."""

import os
import threading
from pathlib import Path

import msgspec
import pytest

from arl_tui.app import facts
from arl_tui.participants import keep_delay, read_delays
from arl_tui.recordings import create_new
from arl_tui.timing.kept import timing_facts
from core.recording.recorder import Recorder
from core.recording.schema import to_plain
from core.session.protocol import Protocol
from tests.arl_tui.test_participants import task_delay
from tests.core.recording.test_recording import HEADER

CANARY = "canary"


def test_a_header_says_nothing_of_computer_user_and_paths(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in (
        "USER",
        "LOGNAME",
        "HOME",
        "HOSTNAME",
        "HOST",
        "PWD",
        "SSH_CONNECTION",
        "SSH_CLIENT",
        "TMUX",
    ):
        monkeypatch.setenv(name, f"/{CANARY}/{CANARY}")
    monkeypatch.setattr("platform.node", lambda: CANARY)
    monkeypatch.setattr("socket.gethostname", lambda: CANARY)
    folder = tmp_path / CANARY
    folder.mkdir()
    monkeypatch.chdir(folder)
    terminal = facts.terminal(80, 24, stamps="flush", frames_per_s=30)
    header = msgspec.structs.replace(
        HEADER,
        software=facts.software(),
        terminal=terminal | timing_facts(folder, terminal, "2026-11-22T10:00:00+00:00"),
        protocol=to_plain(Protocol()),
    )
    text = msgspec.json.encode(header).decode()
    assert CANARY not in text
    assert os.uname().nodename not in text
    assert str(tmp_path) not in text
    assert str(facts.REPOSITORY) not in text


def test_sessions_of_one_participant_in_one_second_have_a_file_each(tmp_path: Path) -> None:
    made: list[Recorder] = []
    start = threading.Barrier(8)

    def begin() -> None:
        start.wait()
        made.append(
            create_new(
                tmp_path / "r", "P01", "2026-11-22T10:00:00+00:00", lambda path: Recorder(path, HEADER)
            )
        )

    threads = [threading.Thread(target=begin) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for recorder in made:
        recorder.close()
    assert len({recorder.path for recorder in made}) == 8
    assert len(list((tmp_path / "r").iterdir())) == 8


def test_a_folder_that_is_a_file_is_an_error_and_not_a_loop(tmp_path: Path) -> None:
    (tmp_path / "r").touch()
    with pytest.raises(FileExistsError):
        create_new(tmp_path / "r", "P01", "2026-11-22T10:00:00+00:00", lambda path: path)


def test_a_participants_delays_are_private(tmp_path: Path) -> None:
    path = keep_delay(tmp_path / "r", "P01", task_delay())
    assert path.stat().st_mode & 0o777 == 0o600
    assert path.parent.stat().st_mode & 0o777 == 0o700
    assert read_delays(tmp_path / "r", "P01") is not None
