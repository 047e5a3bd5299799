"""`arl demo`: its options; it is run by `demo`."""

from pathlib import Path

import click

from arl_tui.command_line import GAMES, language_option, recordings_option, seed_option, theme_option


@click.command(short_help="See the whole path in a minute: watch, press, record, replay.")
@click.argument("game", type=GAMES, default="tetris")
@click.option(
    "--person",
    metavar="NAME",
    help="Who presses: expert (the default), lay, myopic, hesitant, noisy, useless, adversary, instructed, "
    "bursty, hasty, "
    "slow, tiring or leaves.",
)
@seed_option
@language_option
@recordings_option(to_write=True)
@theme_option
def demo(game: str, person: str | None, seed: int | None, language: str | None, recordings: Path) -> None:
    """Show the whole path in about a minute: watch, press, record, replay, summary.

    A simulated participant presses keys; you may press, too. Without a terminal the same happens unseen.
    """
    from arl_tui.commands.demo import run_demo

    run_demo(game, person_name=person, seed=seed, recordings=recordings, language=language)
