"""`arl study`: a whole study from one file, from consent to thanks, for many participants."""

import contextlib
import os
import shlex
import shutil
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import recordings_option, say, theme_option
from arl_tui.standard_streams import DISK_ERRORS
from core.system.foreign_text import printable

if TYPE_CHECKING:
    from arl_tui.study.simulated import Drawn
    from core.session.protocol import Language
    from studies.lab.enrolment import Decision
    from studies.lab.ledger import Ledger
    from studies.lab.read import LoadedStudy


class StudyFile(click.Path):
    """The file of a study, or the folder that holds it as `study.toml`."""

    def __init__(self) -> None:
        """Take files that exist."""
        super().__init__(exists=True, dir_okay=False, path_type=Path)

    def convert(
        self, value: "str | os.PathLike[str]", param: click.Parameter | None, ctx: click.Context | None
    ) -> "str | bytes | os.PathLike[str]":
        """Return the path of the file."""
        return super().convert(Path(value) / NAME if Path(value).is_dir() else value, param, ctx)


NAME = "study.toml"
STUDY = StudyFile()
study_argument = click.argument("file", metavar="STUDY", type=STUDY, default=NAME)


@click.group(short_help="Run a whole study from one file.")
def study() -> None:
    """Run a whole study from one file: consent, blocks in balanced order, breaks, questions, thanks."""


@study.command(short_help="Copy a ready study to start from.")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), default=Path())
@click.option(
    "--from",
    "name",
    type=click.Choice(["demo", "fig5", "fig6", "fig7"]),
    default="demo",
    show_default=True,
    help="Which: two conditions in ten minutes, or one of the paper's figures with people.",
)
@click.option(
    "--language",
    type=click.Choice(["en", "de"]),
    default="en",
    show_default=True,
    help="Language of everything that participants read: English or German.",
)
def new(folder: Path, name: str, language: "Language") -> None:
    """Copy a ready study, complete with texts, to FOLDER."""
    from studies.lab.ready_studies import copy_ready_study

    with _plain_errors():
        files = copy_ready_study(name, folder, language)
    for file in files:
        say(str(file))
    say(f"Next: arl study check {shlex.quote(str(files[0]))}")


@study.command(short_help="Say what the study will do, and what is missing.")
@study_argument
@click.option("--pages", is_flag=True, help="Print every text that participants will read.")
def check(file: Path, pages: bool) -> None:
    """Say what STUDY asks of participants, which orders there are, and what is missing. Status 1 if something
    is.
    """
    from arl_tui.commands.check_protocol import tell_protocol
    from studies.lab.check import forecast
    from studies.lab.read import load_study

    with _plain_errors():
        loaded = load_study(file)
        say("Playing simulated sessions of every condition ...", err=True)
        found = forecast(loaded)
    for number, sitting in enumerate(loaded.study.sittings):
        say(f"\n{sitting.name}: about {found.minutes(number):.0f} minutes")
        for step in found.steps:
            if step.sitting == number:
                remark = f"  ({step.remark})" if step.remark else ""
                say(f"  {step.step + 1:2}  {step.kind:14} {step.minutes:5.1f} min{remark}")
    say("\nConditions, from simulated sessions:")
    for block in found.blocks:
        say(
            f"  {block.condition:20} {block.games} games, {block.minutes:.1f} min, {block.presses:.0f} "
            f"presses that count"
        )
    for name, protocol in loaded.protocols.items():
        say(f"\nSessions of condition {name}:")
        tell_protocol(protocol)
    say("\nOrders, by place:")
    for place, order in enumerate(found.orders, 1):
        say(f"  {place:3}  {', '.join(order)}")
    if pages:
        for name, text in loaded.texts.items():
            say(f"\n--- {name} ---\n{text.strip()}")
    for sentence in found.missing:
        say(f"\nMissing: {sentence}")
    if found.missing:
        raise click.exceptions.Exit(1)
    say("\nNothing is missing.")


@study.command(short_help="Print every key of a study file with what it means.")
def settings() -> None:
    """Print every key of a study file and of a questionnaire: what it takes, and what it means
    (docs/study.md).
    """
    from arl_tui.commands.study_page import page

    say(page(), nl=False)


@study.command(short_help="Lead a participant through their next sitting.")
@study_argument
@click.option("--participant", "code", help="Code of the participant; a new one is drawn by default.")
@click.option(
    "--broken-off",
    type=click.Choice(["resume", "restart"]),
    help="Your decision about a sitting that broke off, in place of the study's [resuming] rule: go on after "
    "the last finished game, or begin the sitting anew. It is written to the ledger.",
)
@recordings_option(to_write=True)
@theme_option
def run(file: Path, code: str | None, broken_off: "Decision | None", recordings: Path) -> None:
    """Lead a participant through their next sitting of STUDY, or go on with one that broke off."""
    from arl_tui.app.facts import software
    from arl_tui.commands.play import need_terminal
    from arl_tui.commands.study_blocks import player
    from arl_tui.study.presenter import Terminal
    from arl_tui.study.run import run_sitting
    from studies.lab.enrolment import drawn_code

    need_terminal("arl study run", instead="arl study simulate")
    if broken_off is not None and code is None:
        raise click.UsageError("--broken-off needs --participant: whose sitting broke off?")
    with _plain_errors():
        loaded, ledger = _open(file, recordings)
        code = code or drawn_code(loaded.study, ledger)
        terminal = Terminal(player(loaded), theme=loaded.theme, language=loaded.study.language)
        result = run_sitting(loaded, ledger, code, terminal, software=software(), decision=broken_off)
    said = {
        "finished": "finished the sitting",
        "stopped": "stopped the sitting",
        "window-closed": "left: the window was closed",
        "failed": "could not go on",
        "declined": "did not consent; nothing was kept",
        "nothing": "left before consent; nothing was kept",
    }[result.how]
    who = "The participant" if result.how in ("declined", "nothing") else result.code
    say(f"{who} {said}.")
    for remark in result.remarks:
        say(f"Beware: {remark}", err=True)
    if result.trouble:
        raise click.ClickException(result.trouble)


@study.command(short_help="Send simulated participants through the whole study.")
@study_argument
@click.option(
    "--participants", type=click.IntRange(1), default=12, show_default=True, help="How many are simulated."
)
@click.option(
    "--drawn",
    type=click.Choice(["once", "all", "none"]),
    default="once",
    show_default=True,
    help="Which sessions are played on the real screens, picture by picture: each block of each condition "
    "once, all, or none. The others are computed, some fifty times as fast, from the same parts.",
)
@recordings_option(to_write=True)
def simulate(file: Path, participants: int, drawn: "Drawn", recordings: Path) -> None:
    """Send simulated participants of all kinds through the real pages of STUDY.

    Their data lie in a folder of their own, whose name ends in "-simulated", and every file says that it is
    simulated.
    """
    from arl_tui.app.facts import software
    from arl_tui.commands.study_blocks import settle_simulated
    from arl_tui.study.run import run_sitting
    from arl_tui.study.simulated import SimulatedPresenter, ToDraw, habits_of
    from core.numerics.clock import ManualClock
    from core.numerics.streams import stream_seed
    from studies.lab.enrolment import drawn_code
    from studies.lab.progress import progress
    from studies.lab.simulated_people import as_participant, chances_per_game

    with _plain_errors():
        loaded, ledger = _open(file, recordings, simulated=True)
        first = len(progress(ledger.lines()).participants)
        to_draw, chances = ToDraw(drawn), chances_per_game(loaded)
        for number in range(first, first + participants):
            clock, code, habits = (
                ManualClock(),
                drawn_code(loaded.study, ledger, prefix="SIM"),
                habits_of(number),
            )
            seed = stream_seed(loaded.study.seed, "simulated", number)
            played = as_participant(loaded, habits.kind, chances)
            for _ in loaded.study.sittings:
                presenter = SimulatedPresenter(
                    played,
                    habits,
                    seed=seed,
                    clock=clock,
                    software=software(),
                    settle=settle_simulated(played),
                    to_draw=to_draw,
                )
                result = run_sitting(
                    loaded,
                    ledger,
                    code,
                    presenter,
                    software=software(),
                    simulated=True,
                    clock=clock,
                    any_time=True,
                )
                say(f"{code} ({habits.kind}): {result.how}, {clock.now_ns() / 60e9:.0f} min")
    say(f"Data: {ledger.folder}")


@study.command(short_help="Show who is where, and whose data are worth a look.")
@study_argument
@click.option("--simulated", is_flag=True, help="Of the simulated participants.")
@click.option("--watch", is_flag=True, help="Follow the running sittings, once a second, and take notes.")
@recordings_option(to_write=False)
def status(file: Path, simulated: bool, watch: bool, recordings: Path) -> None:
    """Show how far STUDY is: participants, orders, drop-outs, presses, and what looks wrong."""
    if watch:
        _watch(file, recordings, simulated=simulated)
        return
    from arl_tui.study.status_lines import status_lines
    from core.numerics.clock import wall_time_utc
    from studies.lab.folder import data_folder
    from studies.lab.ledger import check_not_lost
    from studies.lab.notes import read_notes
    from studies.lab.progress import moment
    from studies.lab.read import load_study
    from studies.lab.status import status as status_of

    with _plain_errors():
        loaded = load_study(file)
        folder = data_folder(recordings, loaded.study.name, simulated=simulated)
        check_not_lost(folder)
        if not (folder / "ledger.jsonl").exists():
            say(f"Nobody has taken part yet: there is no {folder / 'ledger.jsonl'}")
            return
        found = status_of(loaded.study, folder, moment(wall_time_utc()), sha256=loaded.sha256)
        notes = read_notes(folder)
    for line in status_lines(found, notes, simulated=simulated):
        say(line)


@study.command(short_help="Remove everything of a participant who withdraws.")
@study_argument
@click.argument("code")
@click.option("--simulated", is_flag=True, help="Of the simulated participants.")
@click.option("--yes", is_flag=True, help="Do not ask.")
@recordings_option(to_write=True)
def withdraw(file: Path, code: str, simulated: bool, yes: bool, recordings: Path) -> None:
    """Remove everything of the participant CODE from STUDY, exports included.

    Tables that lie outside the folder of the study's data, and backups, are yours to remove.
    """
    from studies.lab.withdraw import check_takes_part
    from studies.lab.withdraw import withdraw as remove

    with _plain_errors():
        _, ledger = _open(file, recordings, simulated=simulated)
        check_takes_part(ledger, code)
    if not yes:
        click.confirm(f"Remove all data of {printable(code)} for ever?", abort=True)
    with _plain_errors():
        tombstone = remove(ledger, code)
    say(f"{tombstone.files_removed} files removed. The ledger holds {tombstone.code} in place of the code.")


@study.command(short_help="Count a participant as dropped out.")
@study_argument
@click.argument("code")
@click.option("--reason", default="the experimenter's decision", show_default=True, help="For the ledger.")
@recordings_option(to_write=True)
def drop(file: Path, code: str, reason: str, recordings: Path) -> None:
    """Count the participant CODE of STUDY as dropped out; what was recorded is kept."""
    from studies.lab.withdraw import drop_out

    with _plain_errors():
        loaded, ledger = _open(file, recordings)
        drop_out(loaded.study, ledger, code, reason)
    rule = "is given to the next participant" if loaded.study.dropouts.replace else "stays empty"
    say(f"{code} counts as dropped out. The place {rule} ([dropouts] replace).")


def _watch(file: Path, recordings: Path, *, simulated: bool) -> None:
    """Follow the running sittings of a study from this terminal."""
    from arl_tui.commands.play import need_terminal
    from arl_tui.study.monitor import Monitor
    from core.numerics.clock import wall_time_utc
    from studies.lab.folder import data_folder
    from studies.lab.ledger import check_not_lost, read_ledger
    from studies.lab.notes import add_note
    from studies.lab.progress import moment, progress
    from studies.lab.read import load_study
    from studies.lab.watching import RunningRow, Watch

    need_terminal("arl study status --watch", instead="arl study status")
    with _plain_errors():
        loaded = load_study(file)
    data = data_folder(recordings, loaded.study.name, simulated=simulated)
    watch = Watch(loaded.study, data)

    def look() -> tuple[str, tuple[RunningRow, ...]]:
        try:
            check_not_lost(data)
            if not (data / "ledger.jsonl").exists():
                return "Nobody has taken part yet.", ()
            so_far = progress(read_ledger(data / "ledger.jsonl"))
        except ValueError as error:
            return str(error), ()
        last = len(loaded.study.sittings)
        finished = sum(
            not person.withdrawn and person.next_sitting(loaded.study) == last
            for person in so_far.participants.values()
        )
        return f"{finished} of {loaded.study.participants} have finished.", watch.rows(
            so_far, moment(wall_time_utc()).timestamp()
        )

    def note(text: str, running: tuple[str, ...]) -> str:
        try:
            data.mkdir(mode=0o700, parents=True, exist_ok=True)
            return f"Noted at {add_note(data, text, running).at_utc}."
        except (ValueError, OSError) as error:
            return f"NOT noted: {error}"

    whose = ", SIMULATED participants" if simulated else ""
    monitor = Monitor(f"Study {loaded.study.name}{whose}", look, note)
    monitor.run_in_terminal()
    monitor.stop_if_it_failed()


def _open(file: Path, recordings: Path, *, simulated: bool = False) -> "tuple[LoadedStudy, Ledger]":
    from studies.lab.folder import data_folder
    from studies.lab.ledger import Ledger
    from studies.lab.read import load_study

    loaded = load_study(file)
    folder = data_folder(recordings, loaded.study.name, simulated=simulated)
    return loaded, Ledger(folder, study=loaded.study.name, seed=loaded.study.seed)


@contextlib.contextmanager
def _plain_errors() -> Iterator[None]:
    """Turn documented errors into a message without a stack trace."""
    try:
        yield
    except (ValueError, OSError) as error:
        if isinstance(error, OSError) and error.errno in DISK_ERRORS:
            raise  # `Arl` names what was to be written
        raise click.ClickException(_to_read(str(error))) from error


def _to_read(text: str) -> str:
    """Return a text whose lines break between words where it goes to a terminal."""
    if not sys.stderr.isatty():
        return text
    columns = shutil.get_terminal_size().columns
    wrapped = (
        textwrap.wrap(line, columns - len("Error: "), break_long_words=False, break_on_hyphens=False)
        for line in text.splitlines()
    )
    return "\n".join(part for lines in wrapped for part in lines)
