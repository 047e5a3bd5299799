"""What all commands share: where they write, in which encoding they speak, and how a failed write is told."""

import math
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

import click

from arl_tui.failure_words import NO_MEMORY, disk_failed, in_words
from arl_tui.home import VARIABLE, recordings_folder
from arl_tui.standard_streams import DISK_ERRORS, let_go_of_full_ones, stand_in_for_closed_ones
from arl_tui.themes import NAMES, theme_in_use
from arl_tui.themes import VARIABLE as THEME_VARIABLE
from core.system.foreign_text import printable_lines

if TYPE_CHECKING:
    from arl_tui.settings import Settings

Function = TypeVar("Function", bound=Callable[..., Any])

FILE = click.Path(exists=True, dir_okay=False, path_type=Path)


OWN_GAMES = ("tetris", "keepaway", "gymnasium")
"""`core.plugins.BUILT_IN`, written out here so that `--help` need not load it; a test compares."""


FIGURES = (".png", ".svg", ".pdf", ".svgz", ".eps", ".ps", ".jpg", ".jpeg", ".tif", ".tiff", ".webp")
"""Endings of files in which matplotlib draws what can be looked at."""

_TO_WRITE = "arl_tui.to_write"
"""Where a command's context keeps the paths that were named to be written."""

NO_FILE = "<arl>"
"""`core.numerics.kernel_files.NO_FILE`, for the same reason; a test compares."""


class GameChoice(click.ParamType):  # type: ignore[type-arg] # not generic in click 8.1
    """The name of a game, or "game:variant" ("gymnasium:CartPole-v1").

    It is looked up when a name is read or help is printed: `arl` alone starts without.
    """

    name = "game"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the name; a usage error lists all games, those of other packages too."""
        game, colon, variant = str(value).partition(":")
        names = list(OWN_GAMES)
        if game not in OWN_GAMES:
            from core.plugins import game_names

            names = list(game_names())
        chosen: str = click.Choice(names).convert(game, param, ctx)
        return f"{chosen}{colon}{variant}"

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str | None:
        """Return the program's own games, as click shows a choice."""
        return click.Choice(list(OWN_GAMES)).get_metavar(param, ctx)


GAMES = GameChoice()

seed_option = click.option(
    "--seed", type=click.IntRange(0, 2**63 - 1), help="Root seed; a new one by default."
)
protocol_option = click.option(
    "--protocol", type=FILE, help="TOML file with everything that is to be set; defaults without it."
)


def _use_theme(_context: click.Context, _parameter: click.Parameter, value: str | None) -> None:
    """Let this process, and those it starts, show a theme."""
    if value is not None:
        os.environ[THEME_VARIABLE] = value
    try:
        theme_in_use()
    except ValueError as error:
        raise click.UsageError(str(error)) from error


theme_option = click.option(
    "--theme",
    type=click.Choice(NAMES),
    expose_value=False,
    callback=_use_theme,
    help=f"Colours of all pages; by default those of the protocol ([screen] theme), or of {THEME_VARIABLE}.",
)


def pseudonym(_context: click.Context, _parameter: click.Parameter, value: str) -> str:
    """Return a participant's code as it is.

    Raises:
        click.BadParameter: it has other signs than letters, digits, "-" and "_", or more than 32.
    """
    from arl_tui.participants import wrong_code

    reason = wrong_code(value)
    if reason:
        raise click.BadParameter(reason)
    return value


@dataclass(frozen=True, slots=True)
class Listed:
    """A command in the list of `arl --help`; its module is imported when it is asked for."""

    name: str
    place: str
    """Module and name of the command there, such as "play:play", below `arl_tui.commands`."""
    short_help: str
    """As the command declares it; a test compares."""

    def load(self) -> click.Command:
        """Import the command."""
        module, _, attribute = self.place.partition(":")
        command: click.Command = getattr(import_module(f"arl_tui.commands.{module}"), attribute)
        return command


class Arl(click.Group):
    """The command `arl`: speaks UTF-8, says where recordings are kept, and reports a failed write."""

    def __init__(self, *args: Any, listed: Sequence[Listed] = (), **extra: Any) -> None:
        """Prepare; see `click.Group`.

        Args:
            args: of `click.Group`.
            listed: the commands, none of which is imported before it is used.
            extra: of `click.Group`.
        """
        super().__init__(*args, **extra)
        self.listed = {each.name: each for each in listed}

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted(self.listed)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command; None where there is none of this name."""
        found = self.listed.get(cmd_name)
        return None if found is None else found.load()

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, self.listed[name].short_help) for name in self.list_commands(ctx)])

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run; see `click.Command.main`."""
        stand_in_for_closed_ones()
        speak_utf8()
        warnings.formatwarning = note_or_warning
        try:
            return super().main(*args, **extra)
        except OSError as error:  # of the program's own help and version
            if error.errno not in DISK_ERRORS:
                raise
            click.echo(f"Error: {disk_failed(error)}", err=True)
            raise SystemExit(1) from error
        finally:
            let_go_of_full_ones()

    def invoke(self, ctx: click.Context) -> Any:
        """Run a subcommand; stop with a message where a file, a folder or a game cannot be used."""
        try:
            return super().invoke(ctx)
        except click.ClickException as error:
            vars(error)["message"] = printable_lines(error.message)  # it may quote a file
            raise
        except OSError as error:
            words = in_words(error, ctx.meta.get(_TO_WRITE, ()))
            if words is None:
                raise
            raise click.ClickException(words) from error
        except MemoryError as error:
            raise click.ClickException(NO_MEMORY) from error
        except ValueError as error:
            from core.plugins import GameError  # here, not above: `arl` alone starts without

            if not isinstance(error, GameError):
                raise
            raise click.ClickException(printable_lines(str(error), longest=None)) from error

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Say where recordings are kept."""
        from arl_tui.home import why_here

        with formatter.section("Recordings and calibrations"):
            formatter.write_text(f"{recordings_folder()} ({why_here()}). Another folder: --recordings DIR.")


def say(text: object = "", *, err: bool = False, nl: bool = True, **style: Any) -> None:
    """Print a text that may hold something from a file: the one way in which commands print.

    Args:
        text: of one line or several; what a terminal would obey in it is written out
            (`core.system.foreign_text`).
        err: print it to the error output.
        nl: end the line.
        style: as `click.style` takes it.
    """
    shown = printable_lines(str(text), longest=None)
    click.echo(click.style(shown, **style) if style else shown, err=err, nl=nl)


_usual_warning = warnings.formatwarning


def note_or_warning(
    message: Warning | str, category: type[Warning], filename: str, lineno: int, line: str | None = None
) -> str:
    """Return a warning as it is printed: what this program says of its own folders is one line."""
    if filename == NO_FILE:
        return f"Note: {message}\n"
    return _usual_warning(message, category, filename, lineno, line)


def speak_utf8() -> None:
    """Let everything that is printed be UTF-8, whatever LANG and PYTHONIOENCODING say.

    A terminal draws the app in UTF-8 only, and a report is the same file everywhere. Streams that are none
    of Python's text files (tests', a browser's) stay as they are.
    """
    for stream in (sys.stdout, sys.stderr, sys.__stdout__, sys.__stderr__):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None and _encoding(stream) != "utf8":
            reconfigure(encoding="utf-8")


def _encoding(stream: TextIO | None) -> str:
    return str(getattr(stream, "encoding", "")).lower().replace("-", "").replace("_", "")


class NumberRange(click.FloatRange):
    """A number in a range; `nan` is none, and click lets it through: it compares with nothing."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return the number."""
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"{value} is not a number", param, ctx)
        return number


class ToWrite(click.Path):
    """A file or folder that is to be written: refused before any work where that is impossible."""

    def __init__(self, *, folder: bool = False, made: bool = False, figure: bool = False) -> None:
        """Prepare.

        Args:
            folder: it is a folder, made where it is missing; otherwise a file.
            made: the command makes the folders above a file where they are missing.
            figure: the file's ending says how it is drawn.
        """
        super().__init__(file_okay=not folder, dir_okay=folder, path_type=Path)
        self._folder = folder
        self._made = made
        self._figure = figure

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path, after a look at the nearest folder that exists."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        reason = why_not_writable(path, folder=self._folder, made=self._made)
        if reason is None and self._figure and path.suffix.lower() not in FIGURES:
            reason = f"{path} does not end in .png, .svg or .pdf, which says how a figure is drawn"
        if reason is not None:
            self.fail(reason, param, ctx)
        _remember(ctx, path)
        return path


def _remember(context: click.Context | None, path: Path) -> None:
    if context is not None:
        context.meta.setdefault(_TO_WRITE, []).append(path)


def file_or_dash(context: click.Context, _parameter: click.Parameter, value: str | None) -> str | None:
    """Return a file's name after a look at whether it can be written; "-" (the screen) and None as they are.

    Raises:
        click.BadParameter: it cannot be written.
    """
    reason = None if value in (None, "-") else why_not_writable(Path(str(value)), folder=False)
    if reason is not None:
        raise click.BadParameter(reason)
    if value not in (None, "-"):
        _remember(context, Path(str(value)))
    return value


def why_not_writable(path: Path, *, folder: bool, made: bool = False) -> str | None:
    """Return why nothing can be written to a path, and what to do; None where that should work.

    Args:
        path: of a file or folder, which may not exist.
        folder: it is a folder, to be made with those above it where it is missing.
        made: folders above a file are made, too; otherwise they must be there.
    """
    path = path.expanduser().absolute()
    if not folder and path.exists():
        return None if os.access(path, os.W_OK) else f"{path} cannot be written: it is read-only"
    first = path if folder else path.parent
    there = next((above for above in (first, *first.parents) if above.exists()), Path("/"))
    if not there.is_dir():
        return f"{path} cannot be written: {there} is a file, not a folder. Choose another place"
    if not (folder or made) and there != first:
        return (
            f"{path} cannot be written: there is no folder {first}. Make it (`mkdir -p`), or choose another"
        )
    if not os.access(there, os.W_OK | os.X_OK):
        return f"{path} cannot be written: the folder {there} is read-only. Choose another place"
    return None


language_option = click.option(
    "--language",
    type=click.Choice(["en", "de"]),
    help="Language of the participant's screens: English or German. By default that of the protocol, and "
    "without a file that of settings.toml. LANG does not matter.",
)


def needed_settings() -> "Settings":
    """Return what the user has set for all sessions, and use their keys from now on.

    Raises:
        click.ClickException: the file cannot be used.
    """
    from arl_tui.language import change_keys
    from arl_tui.settings import read_settings, settings_file

    try:
        settings = read_settings(settings_file())
    except ValueError as error:
        raise click.ClickException(str(error)) from error
    change_keys(settings.changed_keys)
    return settings


_DEFAULT_SHOWN = f"${VARIABLE}/recordings, else arl/recordings in the user's data folder"


def recordings_option(*, to_write: bool) -> Callable[[Function], Function]:
    """Return the option `--recordings`.

    Args:
        to_write: the command writes there; otherwise it only reads.
    """
    return click.option(
        "--recordings",
        type=ToWrite(folder=True) if to_write else click.Path(file_okay=False, path_type=Path),
        default=recordings_folder,
        show_default=_DEFAULT_SHOWN,
        help="Where recordings and calibrations are kept.",
    )
