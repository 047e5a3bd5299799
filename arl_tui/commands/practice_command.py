"""`arl practice`: its options; it is run by `practice`."""

import click

from arl_tui.command_line import seed_option, theme_option


@click.command(short_help="Play Tetris yourself with the agent's own four moves.")
@click.argument("game", type=click.Choice(["tetris"]), default="tetris")
@seed_option
@theme_option
def practice(game: str, seed: int | None) -> None:
    """Play GAME yourself, with the agent's own four moves."""
    from arl_tui.commands.practice import practise

    practise(game, seed=seed)
