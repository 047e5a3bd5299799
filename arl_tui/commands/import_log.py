"""`arl import`: other people's files as recordings, by our own importers or another package's."""

from collections.abc import Mapping
from pathlib import Path

import click

from arl_tui.command_line import FILE, ToWrite, recordings_option
from arl_tui.commands.fit_request import say


def import_log(log: Path, *, out: Path) -> None:
    """Import a TAMER log and say what it held."""
    from core.recording.importers.tamer_log import import_tamer_log
    from core.recording.importers.tamer_rows import TamerLogError

    try:
        report = import_tamer_log(log, out)
    except (TamerLogError, OSError) as error:
        raise _failed(error) from error
    say(f"Recording: {out}")
    for line in report.lines():
        say(f"  {line}")


def import_with(name: str, source: Path, folder: Path, settings: Mapping[str, str]) -> None:
    """Run an importer and say what it made."""
    from core.recording.importers.contract import ImporterError, checked_settings, load_importer

    try:
        importer = load_importer(name)
        imported = importer.run(source, folder, checked_settings(importer, settings))
    except (ImporterError, OSError) as error:
        raise _failed(error) from error
    where = imported.recordings[0] if len(imported.recordings) == 1 else folder
    say(f"{'Recording' if len(imported.recordings) == 1 else 'Recordings'}: {where}")
    for line in imported.lines:
        say(f"  {line}")


def _failed(error: Exception) -> click.ClickException:
    from core.system.foreign_text import printable_lines

    return click.ClickException(printable_lines(str(error)))


def pairs(texts: tuple[str, ...], option: str) -> dict[str, str]:
    """Return NAME=VALUE texts as a mapping; a name without a value is a wrong use of the option."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise click.BadParameter(f"{text!r}: write NAME=VALUE", param_hint=option)
        found[name] = value
    return found


class ImportGroup(click.Group):
    """The program's own importers as commands with options, those of other packages with --set."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return all importers; those that cannot be told apart are named by `get_command`."""
        from core.recording.importers.contract import ImporterError, importer_names

        try:
            others = set(importer_names())
        except ImporterError:
            others = set()
        return sorted({*super().list_commands(ctx), *others})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of an importer, made on the spot for those of other packages."""
        from core.recording.importers.contract import ImporterError, importer_names

        own = super().get_command(ctx, cmd_name)
        if own is not None:
            return own
        try:
            return _command_of(cmd_name) if cmd_name in importer_names() else None
        except ImporterError as error:
            raise _failed(error) from error


def _command_of(name: str) -> click.Command:
    from core.recording.importers.contract import load_importer

    importer = load_importer(name)
    settings = "; ".join(f"{key}: {meaning}" for key, meaning in importer.settings.items())

    @click.command(
        name=name, help=f"{importer.summary}\n\nSettings: {settings or 'none'}.", short_help=importer.summary
    )
    @click.argument("source", type=click.Path(exists=True, path_type=Path))
    @click.option(
        "--set", "settings", multiple=True, metavar="NAME=VALUE", help="A setting of this importer."
    )
    @click.option(
        "--out", type=click.Path(file_okay=False, path_type=Path), help="Folder for the recordings."
    )
    @click.option(
        "--recordings",
        type=click.Path(file_okay=False, path_type=Path),
        default=Path("recordings"),
        show_default=True,
        help="Where recordings are kept.",
    )
    def run(source: Path, settings: tuple[str, ...], out: Path | None, recordings: Path) -> None:
        import_with(name, source, out or recordings / "imported" / source.stem, pairs(settings, "--set"))

    return run


@click.group(name="import", cls=ImportGroup, short_help="Turn other programs' logs into recordings.")
def import_group() -> None:
    """Turn other programs' logs into recordings. Other packages may add importers: docs/importers.md."""


@import_group.command(name="tamer-log")
@click.argument("log", type=FILE)
@click.option(
    "--out",
    type=ToWrite(made=True),
    help="The recording; beside the log's name in the recordings folder by default.",
)
@recordings_option(to_write=True)
def import_tamer_log(log: Path, out: Path | None, recordings: Path) -> None:
    """Import LOG, a log of TAMER's Tetris (Knox)."""
    import_log(log, out=out or recordings / "imported" / f"{log.stem}.jsonl")


@import_group.command(name="evaluations")
@click.argument("table", type=FILE)
@click.option(
    "--column",
    multiple=True,
    metavar="WHAT=NAME",
    help="Which column holds what: participant=NAME (participant_id), time=NAME (time_s), value=NAME "
    "(value), "
    "delay=NAME (delay_s, if there is one).",
)
@click.option(
    "--by", multiple=True, metavar="COLUMN", help="Make a recording of each value (a task, a session)."
)
@click.option(
    "--unit",
    type=click.Choice(["s", "ms", "us", "ns"]),
    help="Unit of the times, unless their columns' names end in one. Never guessed.",
)
@click.option("--encoding", metavar="NAME", help="Code page of the table, as in `arl fit`.")
@click.option(
    "--out",
    type=ToWrite(folder=True),
    help="Folder for the recordings; in the recordings folder by default.",
)
@recordings_option(to_write=True)
def import_evaluations(
    table: Path,
    column: tuple[str, ...],
    by: tuple[str, ...],
    unit: str | None,
    encoding: str | None,
    out: Path | None,
    recordings: Path,
) -> None:
    """Import TABLE, evaluations of an agent: who pressed when, what value, how long after the event judged.

    The recordings give delays (`arl fit`), bursts and reports (`arl presses`); without states they cannot be
    replayed.
    """
    settings = pairs(column, "--column")
    for name, value in (("by", ",".join(by)), ("unit", unit), ("encoding", encoding)):
        if value:
            settings[name] = value
    import_with("evaluations", table, out or recordings / "imported" / table.stem, settings)
