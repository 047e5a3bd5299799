"""`arl doctor`: can sessions and calibrations run on this machine, in this terminal?"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import recordings_option, say

if TYPE_CHECKING:
    from arl_tui.doctor.findings import Finding

TRIALS = 6
"""Of the short test of timing; a second and a half each."""
LARGE_MS = 5.0
"""A larger median error of the short test is not a matter of chance."""


@click.command(short_help="Check this machine and terminal: go or no go.")
@click.option("--quick", is_flag=True, help="Ask for no keys, and leave out the test of timing.")
@click.option("--report", is_flag=True, help="Leave out names and paths: a text for a bug report.")
@recordings_option(to_write=False)
def doctor(quick: bool, report: bool, recordings: Path) -> None:
    """Check everything that a session and a calibration need, and say what to do about each fault.

    Status 1 where a session cannot run. In a terminal it asks for two keys, and tests for some seconds how
    exactly times are measured.
    """
    from arl_tui.doctor.findings import conclusions, lines, stopped

    findings = list(_look(recordings, quick=quick))
    for line in lines(findings, report=report):
        say(line)
    say()
    for line in conclusions(findings):
        say(line)
    if stopped(findings, "session"):
        raise click.exceptions.Exit(1)


def _look(recordings: Path, *, quick: bool) -> "Iterator[Finding]":
    from arl_tui.doctor.machine import machine_findings
    from arl_tui.doctor.screen import terminal_findings

    yield from terminal_findings(lambda line: say(line, err=True), quick=quick)
    yield from machine_findings(recordings)
    if not quick and sys.platform != "win32":
        yield _timing()


def _timing() -> "Finding":
    """Return the result of a few trials against a robot whose true times are known."""
    import secrets

    from arl_tui.commands.timing import measure_condition
    from arl_tui.doctor.findings import Finding
    from arl_tui.timing.plan import make_plan

    todo = "run `arl timing` on a quiet machine; do not calibrate before its medians are below 0.5 ms"
    try:
        condition = measure_condition(make_plan("at rest", TRIALS, root_seed=secrets.randbits(32)))
    except click.ClickException as error:
        return Finding("timing", f"the test failed: {error.message}", "stop", todo, ("calibration",))
    if condition.on_time is None:
        return Finding("timing", f"no usable trial of {TRIALS}", "stop", todo, ("calibration",))
    found = f"measured times are {condition.on_time.median:+.2f} ms off (median of {TRIALS} trials)"
    if abs(condition.on_time.median) > LARGE_MS:
        return Finding("timing", found, "stop", todo, ("calibration",))
    return Finding("timing", found)
