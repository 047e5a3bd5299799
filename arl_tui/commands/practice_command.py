"""`arl practice`: its options; it is run by `practice`."""

import click

from arl_tui.command_line import language_option, seed_option, theme_option


@click.command(short_help="Play Tetris or Keepaway yourself, with the agent's own moves.")
@click.argument("game", type=click.Choice(["tetris", "keepaway"]), default="tetris")
@seed_option
@theme_option
@click.option(
    "--games", type=click.IntRange(1, 1000), default=3, show_default=True, help="How many games are played."
)
@language_option
def practice(game: str, seed: int | None, games: int, language: str | None) -> None:
    """Play GAME yourself, with the agent's own moves.

    In Tetris you move, turn and drop pieces; in Keepaway you say whom the keeper with the ball passes to.
    Nothing is recorded. Rules and keys are explained first.
    """
    from arl_tui.commands.practice import practise

    practise(game, seed=seed, games=games, language=language)
