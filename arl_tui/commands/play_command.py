"""`arl play`: its options; the session is run by `play`."""

from pathlib import Path

import click

from arl_tui.command_line import (
    GAMES,
    language_option,
    protocol_option,
    pseudonym,
    recordings_option,
    seed_option,
    theme_option,
)


@click.command(short_help="Watch an agent learn a game and judge it by key presses.")
@click.argument("game", type=GAMES, default="tetris")
@protocol_option
@click.option(
    "--participant", callback=pseudonym, default="P00", show_default=True, help="Code of the participant."
)
@seed_option
@click.option(
    "--practice",
    is_flag=True,
    help="Before the session two slow games that do not count, until both keys have been pressed in time. "
    "They are recorded in a file of their own.",
)
@click.option("--episodes", type=click.IntRange(1), help="How many games are watched.")
@click.option(
    "--credit",
    metavar="RULE",
    help="How presses are shared out among steps: the participant's own delay (participant, feedback-lag, "
    "simple, pooled; see `arl calibrate`), paper, or a rule as in `arl replay`. By default the protocol's "
    "choice (delay_of), the same for every participant; without a file that is a rule: previous in Tetris, "
    "gamma:2.5,0.3 in Keepaway, current in Gymnasium.",
)
@click.option(
    "--resume",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Go on with a session that broke off, after its last finished game. All settings are those of the "
    "file; the rest of the session is recorded beside it.",
)
@language_option
@recordings_option(to_write=True)
@theme_option
@click.pass_context
def play(
    context: click.Context,
    game: str,
    protocol: Path | None,
    participant: str,
    seed: int | None,
    practice: bool,
    episodes: int | None,
    credit: str | None,
    resume: Path | None,
    language: str | None,
    recordings: Path,
) -> None:
    """Watch an agent learn GAME, and tell it by key presses what you think of it.

    An environment of Gymnasium is named behind a colon: gymnasium:MountainCar-v0, or
    gymnasium:MODULE:FUNCTION for one of your own.
    """
    if resume is not None:
        from arl_tui.commands.resume import resume_session

        resume_session(context, resume)
        return
    from arl_tui.commands.play import play_session

    play_session(
        game,
        protocol=protocol,
        participant=participant,
        seed=seed,
        episodes=episodes,
        recordings=recordings,
        credit=credit,
        language=language,
        practice=practice,
    )
