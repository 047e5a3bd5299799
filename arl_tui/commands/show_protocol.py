"""`arl protocol`: print a complete protocol, check one, or print the reference of all settings."""

from pathlib import Path

import click

from arl_tui.command_line import FILE, GAMES, protocol_option


@click.command(name="protocol", short_help="Print a complete protocol of a game: a file to start from.")
@click.argument("game", type=GAMES, required=False)
@protocol_option
@click.option("--check", type=FILE, help="Say what this protocol file will do, and what has no effect in it.")
@click.option("--markdown", is_flag=True, help="Print docs/protocol.md: every setting of every type.")
def show_protocol(game: str | None, protocol: Path | None, check: Path | None, markdown: bool) -> None:
    """Print a complete protocol of GAME (tetris by default) in TOML: a file to start from.

    Every key is there with its meaning, its range and unit or its choices, and the sessions in which it has
    an effect.
    """
    if sum((check is not None, markdown, protocol is not None)) > 1:
        raise click.UsageError("use one of --protocol, --check and --markdown")
    if markdown:
        from arl_tui.commands.protocol_page import print_page

        print_page()
    elif check is not None:
        from arl_tui.commands.check_protocol import check_protocol
        from arl_tui.commands.play import read_protocol

        check_protocol(check, read_protocol(check, game))
    else:
        from arl_tui.commands.protocol import print_protocol

        print_protocol(game, protocol)
