"""`arl demo`: watch, press, record, replay, summary, in about a minute."""

import secrets
import shlex
from pathlib import Path

import click

from arl_tui.app import facts
from arl_tui.command_line import say
from arl_tui.commands.exact import read_or_stop, run_again
from arl_tui.commands.play import in_language, run_live
from arl_tui.games.registry import screens_called, words_of
from arl_tui.recordings import create_new
from arl_tui.standard_streams import why_not_drawable
from core.feedback.config import TrainerConfig
from core.feedback.simulated_participants import person
from core.numerics.clock import wall_time_utc
from core.session.protocol import Protocol

PARTICIPANT = "demo"


def demo_protocol(game: str, participant: TrainerConfig | None = None) -> Protocol:
    """Return a session of about a minute with a participant who presses often; faster than real ones.

    Args:
        game: its name.
        participant: who presses; by default the participant of the game's own protocol.
    """
    return screens_called(game).demo(participant)


def run_demo(
    game: str, *, person_name: str | None, seed: int | None, recordings: Path, language: str | None = None
) -> None:
    """Show the whole path; in a terminal on screen, elsewhere as fast as the machine can."""
    try:
        protocol = demo_protocol(game, person(person_name) if person_name else None)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="--person" if person_name else "GAME") from error
    root_seed = secrets.randbits(63) if seed is None else seed
    if not why_not_drawable():
        protocol = in_language(protocol, language, written=False)
        outcome = run_live(
            protocol, participant=PARTICIPANT, seed=root_seed, recordings=recordings, simulated=True
        )
        path = outcome.recording
        if outcome.trouble is not None:
            raise click.ClickException(outcome.trouble)
        if path is None:
            return
    else:
        from studies.demo import simulate_session

        say(f"Playing {protocol.session.episodes} games of {game} with a simulated participant ...")
        software = facts.software()

        def create(new: Path) -> Path:
            return simulate_session(protocol, root_seed, new, software=software)

        path = create_new(recordings, PARTICIPANT, wall_time_utc(), create)
    say(f"Recording: {path}")
    recording = read_or_stop(path, allow_truncated=True)
    run_again(recording)
    tell_summary(path)


def tell_summary(path: Path) -> None:
    """Print what happened in a recorded session."""
    from studies.demo import summarise

    summary = summarise(read_or_stop(path, allow_truncated=True))
    words = words_of(summary.game)
    performances = ", ".join(f"{value:.4g}" for value in summary.performances)
    unseen = ", ".join(f"{value:.1f}" for value in summary.unseen_means)
    say(
        f"Games watched: {summary.episodes}; {words.performance[0].lower()}{words.performance[1:]}: "
        f"{performances}"
    )
    say(
        f"Games practised unseen: {summary.unseen_episodes}; {words.units[1]} per game in each block: "
        f"{unseen or '-'}"
    )
    say(
        f"Presses that counted: {summary.accepted}, {summary.praised} of them praise; other keys and "
        f"presses: "
        f"{summary.other_presses}"
    )
    say(
        f"Weight of the participant in the last game: {summary.weight:.2f}; trust in the participant after "
        f"it: "
        f"{summary.trust:.2f}"
    )
    say(
        f"What would another credit rule have learned? arl replay {shlex.quote(str(path))} --credit previous "
        "--credit gamma"
    )
