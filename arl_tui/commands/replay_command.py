"""`arl replay`: its options; it is run by `replay`."""

from pathlib import Path

import click

from arl_tui.command_line import FILE, ToWrite, protocol_option, seed_option


@click.command(short_help="Replay recordings exactly, or under other learning rules.")
@click.argument("recordings", type=FILE, nargs=-1, required=True, metavar="RECORDINGS...")
@click.option(
    "--credit",
    "credits",
    multiple=True,
    metavar="RULE",
    help="What-if: how presses are shared out among steps: gamma:2.5,0.3 uniform:0.2,0.8 previous current, "
    "per-value (a density for each value of a press), or participant (its own delay, see `arl calibrate`). "
    "May be given several times.",
)
@click.option(
    "--scheme",
    "schemes",
    multiple=True,
    metavar="NAME",
    help="What-if: how both rewards are combined, such as linear or annealed:episode (its weight falls per "
    "episode; else per watched-game). May be given several times.",
)
@click.option(
    "--games",
    type=click.IntRange(1),
    default=100,
    show_default=True,
    help="What-if: games that each resulting policy plays.",
)
@protocol_option
@seed_option
@click.option(
    "--workers",
    type=click.IntRange(1),
    help="Processes; one per core by default. The result does not depend on it.",
)
@click.option("--csv", "csv_path", type=ToWrite(), help="Write the table to a file.")
@click.option(
    "--plot",
    "plot_path",
    type=ToWrite(figure=True),
    help="Draw the table (PNG, SVG or PDF).",
)
@click.option(
    "--allow-truncated/--complete-only",
    default=True,
    show_default=True,
    help="Take a recording that was cut off for what it holds.",
)
def replay(
    recordings: tuple[Path, ...],
    credits: tuple[str, ...],
    schemes: tuple[str, ...],
    protocol: Path | None,
    games: int,
    seed: int | None,
    workers: int | None,
    csv_path: Path | None,
    plot_path: Path | None,
    allow_truncated: bool,
) -> None:
    """Run RECORDINGS again: exactly (status 1 and the first difference if one differs), or as a what-if."""
    from arl_tui.commands.replay import replay_recordings

    replay_recordings(
        recordings,
        credits=credits,
        schemes=schemes,
        protocol=protocol,
        games=games,
        seed=seed,
        workers=workers,
        csv_path=csv_path,
        plot_path=plot_path,
        allow_truncated=allow_truncated,
    )
