"""`arl play`: a live session."""

import gc
import os
import secrets
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from arl_tui.command_line import GAMES, protocol_option, pseudonym, recordings_option, say, seed_option
from arl_tui.drawing_rate import FRAMES_PER_S
from arl_tui.signing import NoKey, signer_in_use
from core.session.protocol import Protocol
from core.session.protocol_reading import load_protocol

if TYPE_CHECKING:
    from arl_tui.app.outcome import Outcome


@click.command(short_help="Watch an agent learn a game and judge it by key presses.")
@click.argument("game", type=GAMES, default="tetris")
@protocol_option
@click.option(
    "--participant", callback=pseudonym, default="P00", show_default=True, help="Code of the participant."
)
@seed_option
@click.option("--episodes", type=click.IntRange(1), help="How many games are watched.")
@click.option(
    "--credit",
    metavar="RULE",
    help="How presses are shared out among steps: the participant's own delay (participant, feedback-lag, simple, "
    "pooled; see `arl calibrate`), paper, or a rule as in `arl replay`. By default the protocol's choice (delay_of), the "
    "same for every participant; without a file that is a rule: previous in Tetris, gamma:2.5,0.3 in Keepaway.",
)
@recordings_option(to_write=True)
def play(
    game: str,
    protocol: Path | None,
    participant: str,
    seed: int | None,
    episodes: int | None,
    credit: str | None,
    recordings: Path,
) -> None:
    """Watch an agent learn GAME, and tell it by key presses what you think of it."""
    play_session(
        game,
        protocol=protocol,
        participant=participant,
        seed=seed,
        episodes=episodes,
        recordings=recordings,
        credit=credit,
    )


def play_session(
    game: str,
    *,
    protocol: Path | None,
    participant: str,
    seed: int | None,
    episodes: int | None,
    recordings: Path,
    credit: str | None = None,
) -> None:
    """Run a live session in this terminal and say where its recording is."""
    need_terminal("arl play", instead="arl demo")
    chosen = read_protocol(protocol, game)
    if episodes is not None:
        chosen = with_episodes(chosen, episodes)
    if chosen.others:
        raise click.ClickException(
            "a live session has one participant: leave `others` out of the protocol (only simulated sessions have them)"
        )
    from arl_tui.commands.check_protocol import tell_start
    from arl_tui.commands.credit import settle_credit

    as_written = chosen
    chosen, source = settle_credit(chosen, credit, recordings, participant)
    tell_start(as_written, source, recordings, participant)
    outcome = run_live(chosen, participant=participant, seed=seed, recordings=recordings, source=source)
    tell(outcome)


def need_terminal(command: str, *, instead: str) -> None:
    """Stop with a message where keys cannot be read or pictures not be shown."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise click.ClickException(f"{command} needs a terminal to draw in and a keyboard; try `{instead}`")


def read_protocol(path: Path | None, game: str | None = None) -> Protocol:
    """Read a protocol; stop with a message that names the file where it is wrong.

    Args:
        path: the file; the defaults of the game without one.
        game: which one it has to be about; any where it is None.
    """
    try:
        protocol = load_protocol(path, game=game or "tetris")
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
    if game is not None and protocol.game != game:
        raise click.ClickException(
            f"{path} is a protocol of {protocol.game}, not of {game}: say `{protocol.game}`, or change [domain] type"
        )
    return protocol


def with_episodes(protocol: Protocol, episodes: int) -> Protocol:
    """Return the protocol with another number of watched episodes."""
    session = msgspec.structs.replace(protocol.session, episodes=episodes)
    return msgspec.structs.replace(protocol, session=session)


def run_live(
    protocol: Protocol,
    *,
    participant: str,
    seed: int | None,
    recordings: Path,
    simulated: bool = False,
    source: Mapping[str, str] | None = None,
) -> "Outcome":
    """Start the worker, then the app; return what is left when both are gone."""
    try:
        signer_in_use()
    except NoKey as error:
        raise click.ClickException(str(error)) from error
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    root_seed = secrets.randbits(63) if seed is None else seed
    gc.disable()  # start-up leaves nothing to collect; `GarbageControl` takes over with the app
    from arl_tui.session_app import SessionSetup, build_app
    from arl_tui.worker import start_worker

    # Before the app runs, because no process can be started from inside it; but after everything is imported: on two
    # hardware threads of one core a worker that compiles slows the first picture down by a third.
    link = start_worker(protocol, root_seed, simulated=simulated)
    try:
        setup = SessionSetup(
            protocol=protocol,
            root_seed=root_seed,
            participant=participant,
            recordings=recordings,
            simulated=simulated,
            source=source or {},
        )
        app = build_app(setup, link)
        outcome = app.run_in_terminal()
    finally:
        link.close()
    if app.ended_by is not None:
        if outcome is not None and outcome.recording is not None:
            say(f"Recording: {outcome.recording}")
        raise SystemExit(128 + app.ended_by)
    if outcome is None:
        raise click.ClickException("the app ended without a result; see the message above")
    return outcome


def tell(outcome: "Outcome") -> None:
    """Print where the recording is; leave with status 1 where something failed."""
    if outcome.recording is not None:
        say(f"Recording: {outcome.recording}")
    if outcome.warning:
        say(f"Beware: {outcome.warning}", err=True)
    if outcome.trouble is not None:
        raise click.ClickException(outcome.trouble)
