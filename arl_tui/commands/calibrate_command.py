"""`arl calibrate`: its options; it is run by `calibrate`."""

from pathlib import Path

import click

from arl_tui.command_line import (
    FILE,
    GAMES,
    language_option,
    pseudonym,
    recordings_option,
    seed_option,
    theme_option,
)


@click.command(short_help="Measure how long a participant takes to react and to judge.")
@click.option("--participant", callback=pseudonym, required=True, help="Code of the participant.")
@click.option(
    "--tasks",
    default="simple,choice,feedback-lag",
    show_default=True,
    metavar="LIST",
    help="Which: simple, choice, go-no-go, memory-search, visual-search, recognition, feedback-lag.",
)
@click.option("--trials", type=click.IntRange(1), help="Scored trials per task; 40 by default.")
@click.option("--practice", type=click.IntRange(0), help="Practice trials per task; 8 by default.")
@seed_option
@language_option
@recordings_option(to_write=True)
@click.option("--dry-run", is_flag=True, help="Print every trial as it would be run, and stop.")
@click.option(
    "--game",
    type=GAMES,
    default="tetris",
    show_default=True,
    help="Which game is watched and judged in feedback-lag.",
)
@click.option(
    "--protocol",
    type=FILE,
    help="TOML file of the sessions to come: feedback-lag shows its game at its pace.",
)
@click.option(
    "--refit",
    is_flag=True,
    help="Measure nothing: fit the newest finished trials again, pooled with everybody there is by now.",
)
@theme_option
def calibrate(
    participant: str,
    tasks: str,
    trials: int | None,
    practice: int | None,
    seed: int | None,
    language: str | None,
    recordings: Path,
    dry_run: bool,
    game: str,
    protocol: Path | None,
    refit: bool,
) -> None:
    """Measure how long a participant takes to react, and to judge what the agent does.

    The delay of judging (feedback-lag) is the one by which `arl play --credit participant` assigns credit.
    """
    from arl_tui.commands.calibrate import run_calibration

    run_calibration(
        participant,
        tasks=tasks,
        seed=seed,
        trials=trials,
        practice=practice,
        recordings=recordings,
        dry_run=dry_run,
        refit=refit,
        game=game,
        protocol=protocol,
        language=language,
    )
