"""`arl practice`: a participant plays."""

import os
import secrets
from typing import TYPE_CHECKING

from arl_tui.command_line import needed_settings, say
from arl_tui.commands.play import need_terminal
from arl_tui.drawing_rate import FRAMES_PER_S
from arl_tui.language import use

if TYPE_CHECKING:
    from core.keepaway.practice import KeeperPractice

KEEPAWAY_SPEED = 0.4
"""Simulated seconds per second: slow enough for a participant to look and decide. (Our choice; sessions that
are only watched are shown at 0.2.)"""


def practise(game: str, *, seed: int | None, games: int, language: str | None = None) -> None:
    """Play a game in this terminal.

    Args:
        game: tetris or keepaway.
        seed: of all games; a new one by default.
        games: how many are played, >= 1.
        language: of the words on screen; that of the settings by default.
    """
    need_terminal(f"arl practice {game}", instead="arl demo")
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    root_seed = secrets.randbits(63) if seed is None else seed
    language = language or needed_settings().language
    if game == "keepaway":
        _keep_the_ball(root_seed, games, language)
    else:
        _drop_pieces(root_seed, games, language)


def _drop_pieces(root_seed: int, games: int, language: str) -> None:
    from arl_tui.screens.practice import PracticeApp

    app = PracticeApp(seed=root_seed, games=games, explain=True, language=language)
    lines = app.run_in_terminal()
    if app.ended_by is not None:
        raise SystemExit(128 + app.ended_by)
    if lines is not None:
        say(f"Your last game: {lines} {'line' if lines == 1 else 'lines'}")


def _keep_the_ball(root_seed: int, games: int, language: str) -> None:
    from arl_tui.app.compile_order import session_order
    from arl_tui.commands.watch import get_ready, run
    from arl_tui.screens.practice_keepaway import KeeperPracticeScreen
    from arl_tui.screens.watch import WatchApp
    from core.keepaway.pitch import KeepawayConfig
    from core.session.protocol import DEFAULTS

    protocol = DEFAULTS["keepaway"]
    config = protocol.domain
    assert isinstance(config, KeepawayConfig), "the game of the default protocol"

    def prepare() -> "KeeperPractice":
        get_ready(session_order(protocol))
        from core.keepaway.practice import KeeperPractice

        return KeeperPractice(config, root_seed)

    use(language)
    screen = KeeperPracticeScreen(
        keepers=config.n_keepers,
        games=games,
        length_m=config.length_m,
        width_m=config.width_m,
        speed=KEEPAWAY_SPEED,
    )
    run(WatchApp(screen, prepare, language=language))
