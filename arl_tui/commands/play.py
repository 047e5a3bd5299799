"""`arl play`: a live session."""

import gc
import os
import secrets
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from arl_tui.command_line import needed_settings, say
from arl_tui.drawing_rate import FRAMES_PER_S
from arl_tui.language import tr, use
from arl_tui.own_keys import clash_with_feedback
from arl_tui.settings import settings_file
from arl_tui.signing import NoKey, signer_in_use
from arl_tui.standard_streams import why_not_drawable
from core.plugins import plugin_of
from core.session.practice import practice_of
from core.session.protocol import Protocol
from core.session.protocol_reading import load_protocol

if TYPE_CHECKING:
    from arl_tui.app.link import WorkerLink
    from arl_tui.app.outcome import SessionOutcome
    from arl_tui.session_app import ArlApp
    from core.recording.joined import FinishedPart


def play_session(
    game: str,
    *,
    protocol: Path | None,
    participant: str,
    seed: int | None,
    episodes: int | None,
    recordings: Path,
    credit: str | None = None,
    language: str | None = None,
    practice: bool = False,
) -> None:
    """Run a live session in this terminal and say where its recording is; a practice before it if wanted."""
    need_terminal("arl play", instead="arl demo")
    chosen = in_language(read_protocol(protocol, game), language, written=protocol is not None)
    if episodes is not None:
        chosen = with_episodes(chosen, episodes)
    if chosen.others and not chosen.people:
        raise click.ClickException(
            "`others` are participants of simulated sessions: leave them out of the protocol; several people "
            "at one keyboard are listed as [[people]], each with keys of their own"
        )
    from arl_tui.commands.check_protocol import tell_start
    from arl_tui.commands.credit import settle_credit

    as_written = chosen
    chosen, source = settle_credit(chosen, credit, recordings, participant)
    tell_start(as_written, source, recordings, participant)
    if practice:
        practised(chosen, participant=participant, seed=seed, recordings=recordings)
    outcome = run_live(chosen, participant=participant, seed=seed, recordings=recordings, source=source)
    tell(outcome)


def practised(protocol: Protocol, *, participant: str, seed: int | None, recordings: Path) -> None:
    """Run the practice of a session; stop where the participant has left, or it failed.

    Args:
        protocol: of the session.
        participant: pseudonym.
        seed: of the session; the practice has one of its own, so that its games do not come back.
        recordings: folder of its recording.
    """
    use(protocol.screen.language)
    outcome = run_live(
        practice_of(protocol, name=f"{protocol.name} (practice)"),
        participant=participant,
        seed=None if seed is None else (seed + 1) % (1 << 63),
        recordings=recordings,
        source={"purpose": "practice: it does not count"},
        practice=True,
        part=tr("Practice"),
    )
    tell(outcome)
    if outcome.stopped not in (None, "practised") or not outcome.tally.performances:
        raise click.ClickException("the practice was stopped, so the session has not begun")


def need_terminal(command: str, *, instead: str) -> None:
    """Stop with a message where keys cannot be read or pictures not be shown; take the user's keys over."""
    reason = why_not_drawable()
    if reason:
        if sys.stdout.isatty() and not sys.stderr.isatty():  # nobody sees what goes to the error output
            say(f"Error: {command} {reason}; or try `{instead}`")
            raise SystemExit(1)
        raise click.ClickException(f"{command} {reason}; try `{instead}`")
    needed_settings()


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
    if game is not None and protocol.game != game.partition(":")[0]:
        raise click.ClickException(
            f"{path} is a protocol of {protocol.game}, not of {game}: say `{protocol.game}`, or change "
            f"[domain] type"
        )
    return protocol


def in_language(protocol: Protocol, language: str | None, *, written: bool) -> Protocol:
    """Return the protocol with the language of its screens.

    Args:
        protocol: as it is so far.
        language: as asked for on the command line; None: nothing was.
        written: the protocol comes from a file, which says the language for all participants.
    """
    if language is None:
        if written:
            return protocol
        language = needed_settings().language
    screen = msgspec.structs.replace(protocol.screen, language=language)
    return msgspec.structs.replace(protocol, screen=screen)


def refuse_clash(protocol: Protocol) -> None:
    """Stop with a message where a key that the user has set for the program is one for feedback."""
    letters = {letter for keys in protocol.keys_of_people for letter in keys.letters}
    reason = clash_with_feedback(needed_settings().changed_keys, letters)
    if reason:
        raise click.ClickException(f"{settings_file()}: {reason}")


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
    study: Mapping[str, str] | None = None,
    kept: "FinishedPart | None" = None,
    practice: bool = False,
    part: str = "",
) -> "SessionOutcome":
    """Start the worker, then the app; return what is left when both are gone.

    The arguments are those of `live_app`.
    """
    app, outcome = live_app(
        protocol,
        participant=participant,
        seed=seed,
        recordings=recordings,
        simulated=simulated,
        source=source,
        study=study,
        kept=kept,
        practice=practice,
        part=part,
    )
    if app.ended_by is not None:
        if outcome is not None and outcome.recording is not None:
            say(f"Recording: {outcome.recording}")
        raise SystemExit(128 + app.ended_by)
    if outcome is None:
        raise click.ClickException("the app ended without a result; see the message above")
    return outcome


def live_app(
    protocol: Protocol,
    *,
    participant: str,
    seed: int | None,
    recordings: Path,
    simulated: bool = False,
    source: Mapping[str, str] | None = None,
    study: Mapping[str, str] | None = None,
    kept: "FinishedPart | None" = None,
    practice: bool = False,
    part: str = "",
    on_gone: Callable[[], None] = lambda: None,
) -> "tuple[ArlApp, SessionOutcome | None]":
    """Start the worker, then the app; return the app and its result when both are gone.

    Args:
        protocol: what is played, its credit rule in numbers.
        participant: pseudonym.
        seed: root seed; a new one by default.
        recordings: folder of the new recording.
        simulated: a simulated participant presses keys, too.
        source: where the credit rule comes from, for the header.
        study: where the session belongs in a study, for the header.
        kept: what the session had done before it broke off; None where it begins.
        practice: nothing counts.
        part: where in a visit the session is, in words ("Block 2 of 3").
        on_gone: called where the window is closed and this process is about to end.
    """
    refuse_clash(protocol)
    try:
        signer_in_use()
    except NoKey as error:
        raise click.ClickException(str(error)) from error
    os.environ.setdefault("TEXTUAL_FPS", FRAMES_PER_S)
    root_seed = secrets.randbits(63) if seed is None else seed
    gc.disable()  # start-up leaves nothing to collect; `GarbageControl` takes over with the app
    from arl_tui.app.session_setup import SessionSetup
    from arl_tui.session_app import build_app
    from arl_tui.worker import start_worker

    # Before the app runs, because no process can be started from inside it; but after everything is imported:
    # on two hardware threads of one core a worker that compiles slows the first picture down by a third.
    link = start_worker(protocol, root_seed, simulated=simulated, kept=kept)
    try:
        _try_foreign_rules(protocol, link)
        setup = SessionSetup(
            protocol=protocol,
            root_seed=root_seed,
            participant=participant,
            recordings=recordings,
            simulated=simulated,
            source=source or {},
            study=study or {},
            kept=kept,
            practice=practice,
            part=part,
        )
        app = build_app(setup, link)
        app.before_leaving = on_gone
        return app, app.run_in_terminal()
    finally:
        link.close()


def _try_foreign_rules(protocol: Protocol, link: "WorkerLink") -> None:
    """Stop before the first page where rules that are not the program's own cannot be played: only the
    experimenter can do something about it.
    """
    refusal = link.refusal() if plugin_of(protocol).foreign else ""
    if refusal:
        raise click.ClickException(refusal)


def tell(outcome: "SessionOutcome") -> None:
    """Print where the recording is; leave with status 1 where something failed."""
    if outcome.recording is not None:
        say(f"Recording: {outcome.recording}")
    if outcome.warning:
        say(f"Beware: {outcome.warning}", err=True)
    if outcome.trouble is not None:
        raise click.ClickException(outcome.trouble)
