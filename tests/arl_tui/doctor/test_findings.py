"""`arl doctor`: what is found, what follows from it, and that a report names nobody."""

import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from arl_tui.cli import main
from arl_tui.doctor import machine, screen
from arl_tui.doctor.findings import Finding, conclusions, lines, stopped

GOOD = {"TERM": "xterm-256color", "COLORTERM": "truecolor"}


@pytest.fixture(autouse=True)
def _plain_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "TEXTUAL_DRIVER"):
        monkeypatch.delenv(name, raising=False)


def found_in(environment: dict[str, str]) -> dict[str, Finding]:
    return {finding.topic: finding for finding in screen.environment_findings(environment)}


def test_what_stops_a_calibration_need_not_stop_a_session():
    findings = [
        Finding("one", "x"),
        Finding("two", "x", "stop", "do", ("calibration",)),
        Finding("three", "x", "beware", "do"),
    ]
    assert [finding.topic for finding in stopped(findings, "calibration")] == ["two"]
    assert conclusions(findings) == ["Session: go", "Calibration: no go (two)"]


def test_a_fault_without_advice_is_refused():
    with pytest.raises(ValueError, match="say what to do"):
        Finding("disk", "full", "stop")


def test_a_report_leaves_out_what_is_private():
    findings = [Finding("home", "the default", private="/home/ada/arl")]
    assert "/home/ada/arl" in "\n".join(lines(findings, report=False))
    assert "ada" not in "\n".join(lines(findings, report=True))


@pytest.mark.parametrize(
    ("version", "verdict"), [((3, 10), "stop"), ((3, 11), "ok"), ((3, 14), "ok"), ((3, 15), "stop")]
)
def test_versions_of_python(version, verdict):
    assert machine.python_finding(version).verdict == verdict


def test_the_versions_of_python_are_those_of_the_package():
    import tomllib

    project = tomllib.loads((Path(__file__).resolve().parents[3] / "pyproject.toml").read_text())["project"]
    oldest, newest = machine.OLDEST, machine.NEWEST
    assert project["requires-python"] == f">={oldest[0]}.{oldest[1]},<{newest[0]}.{newest[1] + 1}"


def test_windows_is_sent_to_wsl():
    assert "WSL" in machine.system_finding("Windows").todo
    assert machine.system_finding("Linux").verdict == "ok"


def test_a_busy_machine_and_one_processor_are_named():
    assert machine.load_finding(4, 0.2).verdict == "ok"
    assert machine.load_finding(4, 3.0).verdict == "beware"
    assert machine.load_finding(1, 0.0).verdict == "beware"


def test_a_folder_that_cannot_be_written_stops_everything(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(machine.os, "access", lambda *_: False)
    (finding,) = machine.disk_findings(tmp_path / "new")
    assert (finding.verdict, finding.topic) == ("stop", "recordings")


def test_a_file_in_the_folder_s_place_stops_everything(tmp_path: Path):
    (tmp_path / "file").write_text("x")
    (finding,) = machine.disk_findings(tmp_path / "file" / "below")
    assert finding.verdict == "stop"


@pytest.mark.parametrize(("free_mb", "verdict"), [(10, "stop"), (200, "beware"), (5000, "ok")])
def test_room_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free_mb: int, verdict: str):
    usage = type("Usage", (), {"free": free_mb * 1_000_000})
    monkeypatch.setattr(machine.shutil, "disk_usage", lambda _: usage)
    found = {finding.topic: finding for finding in machine.disk_findings(tmp_path)}
    assert found["disk"].verdict == verdict


def test_a_good_terminal_has_no_fault():
    assert {f.verdict for topic, f in found_in(GOOD).items() if topic != "encoding"} == {"ok"}


@pytest.mark.parametrize(
    ("changed", "topic"),
    [({"TERM": "dumb"}, "terminal"), ({"TMUX": "x"}, "multiplexer"), ({"STY": "x"}, "multiplexer")],
)
def test_a_bad_terminal_is_named(changed: dict[str, str], topic: str):
    assert found_in(GOOD | changed)[topic].verdict == "stop"


def test_a_remote_connection_stops_a_calibration_only(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("SSH_CONNECTION", "1.2.3.4 5 6.7.8.9 22")
    finding = found_in(GOOD)["connection"]
    assert finding.stops == ("calibration",)
    assert "1.2.3.4" not in "\n".join(lines([finding], report=True))


def test_colours():
    assert found_in({"TERM": "xterm"})["colours"].verdict == "beware"
    assert found_in(GOOD | {"NO_COLOR": "1"})["colours"].verdict == "beware"
    assert found_in({"TERM": "screen-256color"})["colours"].found == "256"


def test_a_small_window_stops_everything():
    assert screen.size_finding(79, 24).verdict == "stop"
    assert screen.size_finding(80, 24).verdict == "ok"


@pytest.mark.parametrize(
    ("answer", "found"),
    [
        (b"\x1b[?1004;2$y", "reported"),
        (b"\x1b[?1004;0$y", "not reported"),
        (b"", "not known: the terminal does not say"),
    ],
)
def test_focus_is_asked_of_the_terminal(answer: bytes, found: str):
    assert screen.focus_finding(lambda sent, _: answer if sent == b"\x1b[?1004$p" else b"").found == found


@pytest.mark.parametrize(
    ("came", "verdict", "said"),
    [
        ("j", "ok", "arrives"),
        ("\N{CYRILLIC SMALL LETTER O}", "ok", "another layout"),
        ("J", "beware", "capital"),
        ("n", "beware", "arrives as 'n'"),
        ("", "beware", "no key came"),
    ],
)
def test_a_key_is_compared_with_what_was_asked_for(came: str, verdict: str, said: str):
    finding = screen.key_finding("j", came)
    assert finding.verdict == verdict
    assert said in finding.found


def test_without_a_terminal_the_machine_is_checked_all_the_same(tmp_path: Path):
    done = CliRunner().invoke(main, ["doctor", "--quick", "--report", "--recordings", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "Session: go" in done.output
    assert "not looked at" in done.output
    assert str(tmp_path) not in done.output
    assert str(Path.home()) not in done.output


def test_status_1_where_no_session_can_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(machine, "NEWEST", (3, 10))
    done = CliRunner().invoke(main, ["doctor", "--quick", "--recordings", str(tmp_path)])
    assert done.exit_code == 1
    assert "Session: no go (python)" in done.output


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminal")
def test_keys_are_read_from_a_real_terminal_and_it_is_given_back():
    script = (
        "from arl_tui.doctor.screen import asking, key_findings\n"
        "import sys, termios\n"
        "before = termios.tcgetattr(0)\n"
        "with asking() as ask:\n"
        "    said = [f.found for f in key_findings(ask, lambda line: print('ASK', line, flush=True))]\n"
        "print(said, termios.tcgetattr(0) == before, flush=True)\n"
    )
    ours, theirs = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=theirs, stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        for key in b"jx":
            assert child.stdout.readline().startswith("ASK")
            os.write(ours, bytes([key]))
        said = child.stdout.readline()
    os.close(ours)
    os.close(theirs)
    assert said.strip() == "['arrives', \"arrives as 'x'\"] True"


def test_settings_that_cannot_be_read_stop_a_session(tmp_path: Path) -> None:
    assert machine.settings_finding(tmp_path / "settings.toml").verdict == "ok"
    (tmp_path / "settings.toml").write_text("languge = 'de'")
    finding = machine.settings_finding(tmp_path / "settings.toml")
    assert (stopped([finding], "session"), stopped([finding], "calibration")) == ([finding], [finding])
    assert "did you mean `language`" in lines([finding], report=False)[0]
    assert "tmp" not in lines([finding], report=True)[0]
