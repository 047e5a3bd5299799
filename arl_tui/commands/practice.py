"""`arl practice`: a person plays."""

import os
import secrets

from arl_tui.command_line import needed_settings, say
from arl_tui.commands.play import need_terminal
from arl_tui.drawing_rate import FRAMES_PER_S


def practise(game: str, *, seed: int | None, language: str | None = None) -> None:
    """Play a game in this terminal."""
    need_terminal(f"arl practice {game}", instead="arl demo")
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    from arl_tui.screens.practice import PracticeApp

    language = language or needed_settings().language
    app = PracticeApp(seed=secrets.randbits(63) if seed is None else seed, language=language)
    lines = app.run_in_terminal()
    if app.ended_by is not None:
        raise SystemExit(128 + app.ended_by)
    if lines is not None:
        say(f"Your last game: {lines} {'line' if lines == 1 else 'lines'}")
