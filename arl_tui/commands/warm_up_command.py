"""`arl warm-up`: compile everything now; it is run by `warm_up`."""

import click


@click.command(name="warm-up", short_help="Compile now what the first games would compile.")
def warm_up_command() -> None:
    """Compile everything now that sessions and matches compile when they are first played: half a minute,
    once.

    Nothing has to be: a first game begins at once and compiles meanwhile.
    """
    from arl_tui.commands.warm_up import warm_up

    warm_up()
