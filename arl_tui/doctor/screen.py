"""Checks of the terminal: size, colours, encoding, what lies between it and the program, and two keys."""

import locale
import os
import re
import select
import shutil
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from arl_tui.app import facts
from arl_tui.doctor.findings import Finding
from arl_tui.games.panel import SMALLEST
from core.feedback.layouts import KeyReader

REPORTS_FOCUS = 1004
"""Number of the terminal's mode in which it tells that its window has gained or lost the focus."""
ANSWER_WITHIN_S = 0.5
KEY_WITHIN_S = 20.0
Ask = Callable[[bytes, float], bytes]
"""(bytes to send, longest wait in seconds) -> what the terminal or the keyboard sent."""


def environment_findings(environment: Mapping[str, str]) -> Iterator[Finding]:
    """Yield what the environment tells of the terminal."""
    term = environment.get("TERM", "")
    if term in ("", "dumb"):
        yield Finding(
            "terminal", f"TERM is {term or 'not set'}", "stop", "use a terminal window that can draw"
        )
    else:
        program = environment.get("TERM_PROGRAM", "")
        yield Finding("terminal", f"{term}{f', {program}' if program else ''}")
    yield _colours(term, environment)
    encoding = locale.getpreferredencoding(False)
    if encoding.lower().replace("-", "") == "utf8":
        yield Finding("encoding", "UTF-8")
    else:
        yield Finding(
            "encoding",
            encoding,
            "beware",
            "set LANG to a UTF-8 locale such as C.UTF-8, for file names and tables",
        )
    yield from _between(environment)


def _colours(term: str, environment: Mapping[str, str]) -> Finding:
    if environment.get("NO_COLOR"):
        return Finding(
            "colours",
            "switched off by NO_COLOR",
            "beware",
            "unset NO_COLOR: the pieces are told apart by colour",
        )
    if environment.get("COLORTERM") in ("truecolor", "24bit"):
        return Finding("colours", "16 million")
    if "256" in term:
        return Finding("colours", "256")
    return Finding(
        "colours", "16, as far as one can tell", "beware", 'set [screen] palette = "sixteen" in the protocol'
    )


def _between(environment: Mapping[str, str]) -> Iterator[Finding]:
    if environment.get("TMUX") or environment.get("STY"):
        name = "tmux" if environment.get("TMUX") else "screen"
        yield Finding(
            "multiplexer",
            name,
            "stop",
            f"calibrate outside {name}: it delays keys and pictures",
            ("calibration",),
        )
    else:
        yield Finding("multiplexer", "none")
    connection = facts.connection()
    if connection == "local":
        yield Finding("connection", "local")
    else:
        yield Finding(
            "connection",
            connection,
            "stop",
            "calibrate at the machine itself: the network adds times that change",
            ("calibration",),
        )


def size_finding(columns: int, rows: int) -> Finding:
    """Return whether the window is large enough for the smallest game."""
    found = f"{columns} x {rows}"
    if columns >= SMALLEST.width and rows >= SMALLEST.height:
        return Finding("size", found)
    return Finding("size", found, "stop", f"make the window at least {SMALLEST.width} x {SMALLEST.height}")


def focus_finding(ask: Ask) -> Finding:
    """Return whether the terminal tells when its window loses the focus (DECRQM)."""
    answer = ask(f"\x1b[?{REPORTS_FOCUS}$p".encode(), ANSWER_WITHIN_S)
    found = re.search(rb"\x1b\[\?1004;([0-4])\$y", answer)
    if found and found[1] in b"123":
        return Finding("focus", "reported")
    said = "not reported" if found else "not known: the terminal does not say"
    return Finding(
        "focus", said, "beware", "recordings may not tell when the participant looks at another window"
    )


def key_findings(ask: Ask, say: Callable[[str], None], keys: str = "jf") -> Iterator[Finding]:
    """Yield for each feedback key whether it arrives as what it is.

    Args:
        ask: sends bytes and returns what came.
        say: shows a line.
        keys: the letters to ask for.
    """
    for key in keys:
        say(f"Press the key {key} (or wait {KEY_WITHIN_S:.0f} s):")
        yield key_finding(key, ask(b"", KEY_WITHIN_S).decode("utf-8", errors="replace"))


def key_finding(key: str, came: str) -> Finding:
    """Return what a key that was asked for has sent."""
    topic = f"key {key}"
    if came == key:
        return Finding(topic, "arrives")
    if not came:
        return Finding(topic, "no key came", "beware", "try again, and press the key while it is asked for")
    reading = KeyReader().read(came)
    if reading is not None and reading.letter == key:
        return Finding(topic, f"arrives as a letter of another layout ({reading.layout}), and is understood")
    if came == key.upper():
        return Finding(topic, "arrives as a capital", "beware", "switch Caps Lock off: capitals do not count")
    return Finding(
        topic,
        f"arrives as {came!a}",
        "beware",
        "change the keyboard's layout, or the keys in the protocol's table [keys]",
    )


@contextmanager
def asking() -> Iterator[Ask]:
    """Let the terminal hand over single keys for a while; give it back as it was."""
    import termios
    import tty

    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)

    def ask(sent: bytes, within_s: float) -> bytes:
        if sent:
            os.write(sys.stdout.fileno(), sent)
        came, end = b"", time.monotonic() + within_s
        while (left := end - time.monotonic()) > 0 and select.select([descriptor], [], [], left)[0]:
            came += os.read(descriptor, 64)
            if not sent or came.endswith(b"y"):
                break
        return came

    try:
        tty.setcbreak(descriptor, termios.TCSAFLUSH)
        yield ask
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def terminal_findings(say: Callable[[str], None], *, quick: bool) -> Iterator[Finding]:
    """Yield what was found of this terminal; of none, that it was not looked at."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        yield Finding(
            "terminal",
            "not looked at",
            "beware",
            "run this in the terminal in which sessions are to run, without a pipe",
        )
        return
    yield from environment_findings(os.environ)
    yield size_finding(*shutil.get_terminal_size())
    if sys.platform == "win32":
        return
    with asking() as ask:
        yield focus_finding(ask)
        if not quick:
            yield from key_findings(ask, say)
