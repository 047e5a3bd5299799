"""`arl presses`: values, delays and bursts of recorded presses, live or imported."""

import csv
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import NumberRange
from arl_tui.commands.fit_request import say
from core.system.foreign_text import in_table, printable_lines
from core.system.whole_file import whole_file

if TYPE_CHECKING:
    from studies.evaluations.presses import Press


@click.command(short_help="Report values, delays and bursts of recorded presses.")
@click.argument(
    "recordings", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path)
)
@click.option("--each", is_flag=True, help="A report for each participant, too.")
@click.option(
    "--burst-within",
    type=NumberRange(0.0, 60.0),
    default=0.5,
    show_default=True,
    help="Seconds; presses of the same sign that follow within this time are one burst.",
)
@click.option(
    "--delays-by-value",
    is_flag=True,
    help="Print a credit rule with a density of the delay for each value, to copy into a protocol. For "
    "imported evaluations.",
)
@click.option(
    "--csv", "csv_path", type=click.Path(dir_okay=False, path_type=Path), help="Write every press to a file."
)
def presses(
    recordings: tuple[Path, ...],
    each: bool,
    burst_within: float,
    delays_by_value: bool,
    csv_path: Path | None,
) -> None:
    """Report the accepted presses in RECORDINGS: how often each value, how long after what, in which bursts.

    Delays are measured from the event that was judged (imported evaluations), else from the appearance of the
    step on screen at the press, which need not be the step that it judges. `arl fit` fits the delays of
    imported evaluations.
    """
    from core.recording.reader import RecordingError, read_recording
    from studies.evaluations.presses import presses_of, report_lines

    found: list[Press] = []
    kinds = set()
    for path in recordings:
        try:
            recording = read_recording(path)
        except (RecordingError, OSError) as error:
            raise click.ClickException(printable_lines(str(error))) from error
        kinds.add(recording.header.source.get("format") == "evaluations")
        found += presses_of(recording, burst_within_s=burst_within)
    what = (
        "since the event judged"
        if kinds == {True}
        else "since the step appeared"
        if kinds == {False}
        else "(mixed)"
    )
    people: dict[str, list[Press]] = {}
    for press in found:
        people.setdefault(press.participant, []).append(press)
    say(f"{len(people)} participants, {len(recordings)} recordings")
    say("\n".join(report_lines(found, delays_of_what=what)))
    for name, some in people.items() if each else ():
        say(f"\n{name}\n" + "\n".join(report_lines(some, delays_of_what=what)))
    if delays_by_value:
        if kinds != {True}:
            raise click.ClickException(
                "--delays-by-value needs imported evaluations (`arl import evaluations`): in a session a "
                "delay is known since the step on screen appeared, which need not be the step that was judged"
            )
        say("\n".join(_rule_lines(found)))
    if csv_path is not None:
        _write(csv_path, found)
        say(f"Table: {csv_path}")


def _rule_lines(found: "list[Press]") -> list[str]:
    """Return a credit rule with a density for each value, as lines of a protocol."""
    import msgspec

    from arl_tui.commands.protocol import toml_value
    from studies.evaluations.by_value import fit_per_value

    try:
        rule = fit_per_value(found)
    except ValueError as error:
        raise click.ClickException(f"--delays-by-value: {error}") from error
    plain = msgspec.to_builtins(rule)
    values = [f"  {toml_value(each)}," for each in plain["values"]]
    return [
        "",
        "[agent.credit.delay]",
        'type = "per-value"',
        "values = [",
        *values,
        "]",
        f"other = {toml_value(plain['other'])}",
    ]


def _write(path: Path, found: "list[Press]") -> None:
    from dataclasses import asdict, fields

    from studies.evaluations.presses import Press

    with whole_file(path) as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Press)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(
            in_table({key: "n/a" if value is None else value for key, value in asdict(one).items()})
            for one in found
        )
