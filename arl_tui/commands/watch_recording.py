"""`arl watch FILE`: look at a recorded session."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from arl_tui.command_line import say
from core.recording.reader import RecordingError
from core.system.foreign_text import printable

if TYPE_CHECKING:
    from arl_tui.viewer.reading import Viewing
    from arl_tui.viewer.workers import Workers
    from core.feedback.delays import Delay
    from core.session.protocol import Protocol
    from studies.session_view.session import SessionView

LARGE = 32 << 20
"""Bytes from which the building of an index is shown."""


def watch_recording(
    path: Path,
    *,
    credit: str | None,
    scheme: str | None,
    export: Path | None,
    at: float | None,
    until: float | None,
    speed: float,
) -> None:
    """Show a recording, or write a film of it.

    Args:
        path: the recording.
        credit: rule of the what-if beside it.
        scheme: scheme of the what-if beside it.
        export: a .gif, .mp4 or .cast to write instead.
        at: where to begin, seconds after the beginning.
        until: where a film ends.
        speed: of a film, recorded seconds per second.
    """
    from arl_tui.commands.play import need_terminal

    if export is None:
        need_terminal("arl watch", instead="arl watch FILE --export film.cast")
    begin_s = at or 0.0
    if until is not None and until <= begin_s:
        raise click.BadParameter(f"a film from {begin_s:g} s to {until:g} s has no end", param_hint="--until")
    session = opened(path, at_once=export is None and at is None)
    lasts_s = (session.end_ns - session.start_ns) / 1e9
    if at is not None and at > lasts_s:
        raise click.BadParameter(f"{at:g} s: {path} lasts {lasts_s:.1f} s", param_hint="--at")
    from arl_tui.viewer.workers import Workers

    with Workers(path) as workers:
        viewing = viewing_of(path, session, workers, credit=credit, scheme=scheme)
        if export is not None:
            from arl_tui.viewer.film import export_film

            export_film(viewing, export, begin_s=begin_s, end_s=until, speed=speed)
            return
        from arl_tui.viewer.app import ViewerApp
        from arl_tui.viewer.pictures import pictures_of
        from arl_tui.viewer.screen import ViewerScreen

        screen = ViewerScreen(viewing, pictures_of(session))
        if at is not None:
            screen.transport.seek(session.start_ns + at * 1e9)
        app = ViewerApp(screen)
        told = app.run_in_terminal()
    if workers.said:
        say(workers.said, err=True)
    if screen.broken is not None:
        raise click.ClickException(printable(str(screen.broken), longest=None)) from screen.broken
    if app.ended_by is not None:
        sys.exit(128 + app.ended_by)
    app.stop_if_it_failed()
    if told:
        say(told)


def opened(path: Path, *, at_once: bool = False) -> "SessionView":
    """Open a recording with its index; stop with a message where that is impossible.

    Args:
        path: of the recording.
        at_once: of a long recording without an index, open the first part.
    """
    from studies.session_view.session import open_at_once, open_session

    try:
        if at_once:
            session = open_at_once(path)
        elif path.stat().st_size < LARGE:
            session = open_session(path)
        else:
            with click.progressbar(length=1000, label="Reading", file=sys.stderr) as shown:
                session = open_session(
                    path, on_progress=lambda fraction: shown.update(round(fraction * 1000) - shown.pos)
                )
    except (RecordingError, OSError) as error:
        raise click.ClickException(printable(str(error), longest=None)) from error
    for note in session.index.notes:
        say(f"Beware: {printable(note, longest=None)}", err=True)
    try:
        _ = session.protocol
    except (msgspec.ValidationError, ValueError) as error:
        raise click.ClickException(
            f"{path}:1: the protocol cannot be used: {printable(str(error))}"
        ) from error
    return session


def viewing_of(
    path: Path, session: "SessionView", workers: "Workers", *, credit: str | None, scheme: str | None
) -> "Viewing":
    """Return what the viewer shows of a recording; the agents' values are begun to be worked out."""
    from arl_tui.viewer.reading import Viewing, nothing_worked_out, rules_of
    from studies.session_view.tags import Tags, TagsError

    try:
        tags = Tags(path)
    except TagsError as error:
        raise click.ClickException(str(error)) from error
    protocol = session.protocol
    asked = None
    if credit or scheme:
        if protocol is None:
            raise click.ClickException(
                f"{path}: a what-if needs states and actions; this recording holds none"
            )
        asked = what_if_of(path, session, protocol, credit, scheme)
    whole = None if session.index.whole else workers.index()
    own = (
        workers.own()
        if protocol is not None and (len(session.steps) or whole is not None)
        else nothing_worked_out("no steps, no values")
    )
    return Viewing(
        path,
        session,
        tags,
        rules=rules_of(session, own_delay(path, session)),
        own=own,
        begin_what_if=workers.what_if,
        what_if=asked,
        whole=whole,
    )


def own_delay(path: Path, session: "SessionView") -> "Delay | None":
    """Return the participant's measured delay of judging; None where there is none."""
    from arl_tui.commands.credit import is_measured
    from arl_tui.participants import ParticipantError, choose_credit, home_of

    participant, protocol = session.index.header.participant, session.protocol
    if protocol is None:
        return None
    home = home_of(path)
    try:
        if not is_measured("feedback-lag", home, participant, protocol.game):
            return None
        return choose_credit("feedback-lag", home, participant, protocol.game).delay
    except (ParticipantError, click.ClickException, ValueError, OSError):
        return None


def what_if_of(
    path: Path, session: "SessionView", protocol: "Protocol", credit: str | None, scheme: str | None
) -> "tuple[str, Protocol]":
    """Return the what-if that the command line asks for: its name and its protocol."""
    from core.combination.config import check_learner
    from core.feedback.delays import describe, parse_delay
    from studies.what_if import scheme_named

    delay, names = protocol.agent.credit.delay, []
    if credit:
        own = own_delay(path, session) if credit in ("participant", "feedback-lag") else None
        try:
            delay = own if own is not None else parse_delay("gamma" if credit == "paper" else credit)
        except ValueError as error:
            raise click.BadParameter(f"{error}; or paper, participant", param_hint="--credit") from error
        names.append(describe(delay))
    agent = msgspec.structs.replace(
        protocol.agent, credit=msgspec.structs.replace(protocol.agent.credit, delay=delay)
    )
    if scheme:
        try:
            chosen = scheme_named(scheme, protocol.agent.scheme)
            check_learner(chosen, protocol.learner.kind, str(protocol.learner.__struct_config__.tag))
        except ValueError as error:
            raise click.BadParameter(str(error), param_hint="--scheme") from error
        agent = msgspec.structs.replace(agent, scheme=chosen)
        names.append(scheme)
    return ", ".join(names), msgspec.structs.replace(protocol, agent=agent, delay_of="rule")
