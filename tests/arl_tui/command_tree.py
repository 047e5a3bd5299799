"""The commands of a group, whether it has imported them or not."""

from collections.abc import Iterator

import click


def members(group: click.Group) -> Iterator[tuple[str, click.Command]]:
    """Yield the name and the command of everything in a group."""
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None, name
        yield name, command
