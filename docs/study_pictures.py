"""Make the pictures of *A first study in ten minutes* from the real screens: `python docs/study_pictures.py [FOLDER]`.

The program copies the ready study and takes part in it in a pseudo-terminal of 80 x 24, while a second one follows it. It
takes some seven minutes. Needs what `docs/film.py` needs.
"""  # noqa: E501

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pexpect
import pyte
from film import COLUMNS, LINES, cells_of, picture

from studies.lab.check import PLACEHOLDER

LONGEST_S = 1800.0
BETWEEN_PRESSES_S = 9.0
ANSWERS = (
    ("Answer every statement", "yyn\r"),
    ("Enter  to start, ", "\r"),
    ("Enter  to leave", "\r"),
    ("Question", "5\r"),
    ("Enter  to read on", "\r"),
    ("Enter  to go on", "\r"),
    ("Space  to go on", " "),
)
"""What stands on the screen, and what is pressed then."""
PICTURES = {
    "study-consent": "Answer every statement",
    "study-block": "Counted for",
    "study-question": "Question 1 of",
    "study-thanks": "Your code is",
}
"""Name of a picture, and what is on its screen."""


class Screen:
    """A command in a terminal, and what it shows."""

    def __init__(self, *arguments: str, home: Path) -> None:
        """Start `arl` with these arguments."""
        environment = {
            **os.environ,
            "ARL_HOME": str(home),
            "TERM": "xterm-256color",
            "COLORTERM": "truecolor",
        }
        environment["TEXTUAL_DISABLE_KITTY_KEY"] = "1"
        for name in ("TMUX", "STY", "SSH_CONNECTION", "NO_COLOR", "COLUMNS", "LINES"):
            environment.pop(name, None)
        self.screen = pyte.Screen(COLUMNS, LINES)
        self._stream = pyte.ByteStream(self.screen)
        command = ["-W", "ignore", "-m", "arl_tui", *arguments]
        self.child = pexpect.spawn(
            sys.executable,
            command,
            dimensions=(LINES, COLUMNS),
            env=environment,
            cwd=str(home),
            timeout=LONGEST_S,
        )

    def read(self, duration_s: float) -> bool:
        """Take what is written for a while; return whether the command still runs."""
        end = time.monotonic() + duration_s
        while (left_s := end - time.monotonic()) > 0:
            try:
                self._stream.feed(self.child.read_nonblocking(65536, timeout=left_s))
            except pexpect.TIMEOUT:
                return True
            except pexpect.EOF:
                return False
        return True

    @property
    def text(self) -> str:
        """What stands on the screen."""
        return "\n".join(self.screen.display)

    def save(self, path: Path) -> None:
        """Write the screen as a picture."""
        picture(cells_of(self.screen)).save(path, optimize=True)


def take_part(study: Path, home: Path, into: Path) -> None:
    """Take part from consent to thanks; write a picture of each page in PICTURES, and one of the monitor."""
    missing, end = dict(PICTURES), time.monotonic() + LONGEST_S
    participant = Screen("study", "run", str(study), "--participant", "P7KQ", home=home)
    monitor: Screen | None = None
    watched, pressed, number = False, 0.0, 0
    while participant.read(0.4):
        if time.monotonic() > end:
            raise SystemExit(f"not over after {LONGEST_S:.0f} s:\n{participant.text}")
        text = participant.text
        for name, mark in tuple(missing.items()):
            if mark in text:
                participant.save(into / f"{name}.png")
                del missing[name]
        if "Game " in text and " to go on" not in text and "Enter  to" not in text:
            if monitor is None:
                monitor = Screen("study", "status", str(study), "--watch", home=home)
            monitor.read(0.2)
            if not watched and re.search(r"[1-9.]+ presses per minute, lag \d", monitor.text):
                monitor.save(into / "study-watch.png")
                watched = True
            if time.monotonic() - pressed > BETWEEN_PRESSES_S:
                pressed, number = time.monotonic(), number + 1
                participant.child.send("jfj"[number % 3])
            continue
        participant.child.send(next((keys for mark, keys in ANSWERS if mark in text), ""))
    if missing or monitor is None or not watched:
        raise SystemExit(f"never seen: {', '.join(missing) or 'the monitor'}\n{participant.text}")
    monitor.child.close(force=True)


def main(into: Path) -> None:
    """Write the pictures."""
    into.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        command = [sys.executable, "-m", "arl_tui", "study", "new", str(home / "my-study")]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        study = home / "my-study" / "study.toml"
        form = study.with_name("consent.md")
        form.write_text(PLACEHOLDER.sub("EXAMPLE", form.read_text(encoding="utf-8")), encoding="utf-8")
        take_part(study, home, into)
        status = Screen("study", "status", str(study), home=home)
        while status.read(0.2):
            pass
        status.save(into / "study-status.png")
    for name in (*PICTURES, "study-watch", "study-status"):
        print(f"{into / name}.png: {(into / f'{name}.png').stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "figures")
