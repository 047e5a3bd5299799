"""`arl` without a command: the home page, and back to it after each command."""

import signal
import subprocess
import sys

from arl_tui.command_line import needed_settings, say
from arl_tui.home import recordings_folder, why_here


def run_home() -> None:
    """Show the home page until it is left; each command runs as if it had been typed."""
    from arl_tui.start.app import HomeApp
    from arl_tui.start.entries import command_line

    marked = 0
    while True:
        language = needed_settings().language
        app = HomeApp(recordings_folder(), why_there=why_here(), language=language, marked=marked)
        arguments = app.run_in_terminal()
        marked = app.marked
        if app.ended_by is not None:
            raise SystemExit(128 + app.ended_by)
        app.stop_if_it_failed()
        if arguments is None:
            return
        say(f"$ {command_line(arguments)}")
        status = run(arguments)
        if status:
            say(f"(status {status})", err=True)
        if not wait_for_enter():
            return


def run(arguments: tuple[str, ...]) -> int:
    """Run a command of `arl` in a process of its own; return its status.

    Keys that interrupt go to that process alone.
    """
    # A function, not SIG_IGN, which the other process would inherit.
    before = signal.signal(signal.SIGINT, lambda _number, _frame: None)
    try:
        return subprocess.run([sys.executable, "-m", "arl_tui", *arguments], check=False).returncode
    finally:
        signal.signal(signal.SIGINT, before)


def wait_for_enter() -> bool:
    """Let what was printed be read; False where there is nobody any more."""
    say("Press Enter to come back to arl.", nl=False)
    return bool(sys.stdin.readline())
