"""`arl timing`: how exactly this machine measures reaction times, told by a robot that knows the truth."""

import re
import secrets
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from arl_tui.command_line import NumberRange, ToWrite, recordings_option, say

if TYPE_CHECKING:
    from arl_tui.timing.plan import Plan
    from arl_tui.timing.result import ConditionResult, TimingResult

CONDITION_NAMES = ("bare reader", "at rest", "beside a board")
"""Written out here so that `--help` need not load them; a test compares."""
BUSY = 0.5
"""Load per core above which only medians say something about the program."""
SMALLEST = (80, 24)
"""Columns and lines of the smallest window."""


def _window(_context: click.Context, _parameter: click.Parameter, value: str) -> tuple[int, int]:
    """Return columns and lines.

    Raises:
        click.BadParameter: they cannot be read, or are too few for the stimulus and a board.
    """
    found = re.fullmatch(r"(\d{1,4})x(\d{1,4})", value)
    if found is None or int(found[1]) < SMALLEST[0] or int(found[2]) < SMALLEST[1]:
        raise click.BadParameter(
            f"a window is COLUMNSxLINES, at least {SMALLEST[0]}x{SMALLEST[1]}, such as 200x60; got {value!r}"
        )
    return int(found[1]), int(found[2])


@click.command(short_help="Test how exactly this machine measures reaction times.")
@click.option(
    "--trials",
    type=click.IntRange(1, 9999),
    default=60,
    show_default=True,
    help="Per condition; a second and a half each.",
)
@click.option(
    "--condition",
    "--scene",
    "conditions",
    multiple=True,
    type=click.Choice(CONDITION_NAMES),
    help="Only this one.",
)
@click.option(
    "--longest",
    type=click.IntRange(150, 2500),
    default=1000,
    show_default=True,
    help="Longest reaction time of the robot, ms.",
)
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Root seed; a new one by default.")
@click.option(
    "--json",
    "json_path",
    type=ToWrite(),
    help="Write everything, each trial included, for machines.",
)
@recordings_option(to_write=True)
@click.option(
    "--window",
    callback=_window,
    default="80x30",
    show_default=True,
    metavar="COLUMNSxLINES",
    help="Size of the robot's terminal; the board is drawn as large as fits.",
)
@click.option(
    "--gate",
    type=NumberRange(min=0.0, min_open=True),
    metavar="MS",
    help="Leave with status 1 where a condition's median error is larger. Nothing is kept then or otherwise: "
    "for CI.",
)
def timing(
    trials: int,
    conditions: tuple[str, ...],
    longest: int,
    seed: int | None,
    json_path: Path | None,
    recordings: Path,
    window: tuple[int, int],
    gate: float | None,
) -> None:
    """Test how exactly reaction times are measured on this machine.

    A robot participant at the other end of a pseudo-terminal answers a stimulus exactly 150 to 1000 ms after
    it has seen its bytes; measured minus true is printed, at rest and beside a moving board, and what is left
    of it with a program of a few lines that only reads. No keyboard is needed.
    """
    result = measure(
        tuple(conditions) or CONDITION_NAMES,
        trials,
        longest,
        secrets.randbits(63) if seed is None else seed,
        window,
    )
    for line in report_lines(result):
        say(line)
    if json_path is not None:
        import msgspec

        from core.system.whole_file import write_whole

        write_whole(json_path, msgspec.json.format(msgspec.json.encode(result), indent=1).decode())
        say(f"JSON: {json_path}", err=True)
    if gate is not None:
        stop_above(result, gate)
        return
    from arl_tui.timing.kept import keep_timing

    say(f"Kept for the headers of later sessions: {keep_timing(recordings, result)}", err=True)


def stop_above(result: "TimingResult", gate_ms: float) -> None:
    """Leave with status 1 where a median is too large, or a condition has no usable trial. Means are the
    machine's.
    """
    for condition in result.conditions:
        if condition.on_time is None:
            raise click.ClickException(f"{condition.condition}: no usable trial of {condition.n_trials}")
        if condition.on_time.median > gate_ms:
            raise click.ClickException(
                f"{condition.condition}: the median error is {condition.on_time.median:.2f} ms, allowed are "
                f"{gate_ms:g} ms"
            )


def measure(
    conditions: tuple[str, ...],
    n_trials: int,
    longest_ms: int,
    seed: int,
    window: tuple[int, int] = (80, 30),
) -> "TimingResult":
    """Run the conditions one after another, with a bar that shows how far they are."""
    if sys.platform == "win32":
        raise click.ClickException("the self-test needs a pseudo-terminal, which Windows does not have")
    import os

    from arl_tui.app import facts
    from arl_tui.drawing_rate import FRAMES_PER_S
    from arl_tui.timing.kept import machine_code, this_terminal
    from arl_tui.timing.plan import CONDITIONS, make_plan
    from arl_tui.timing.result import TimingResult, summarise
    from arl_tui.timing.waking import lateness_ms
    from core.numerics.clock import wall_time_utc

    plans = [
        make_plan(s, n_trials, root_seed=seed, longest_ms=longest_ms, window=window)
        for s in CONDITIONS
        if s in conditions
    ]
    late_ms, results = [], []
    for plan in plans:
        late_ms += lateness_ms()
        results.append(measure_condition(plan))
    return TimingResult(
        created_utc=wall_time_utc(),
        root_seed=seed,
        cores=os.cpu_count() or 1,
        load=os.getloadavg()[0],
        software=facts.software(),
        machine=machine_code(),
        terminal=this_terminal(facts.terminal(0, 0, stamps="flush", frames_per_s=int(FRAMES_PER_S))),
        waking=summarise(late_ms),
        conditions=tuple(results),
    )


def measure_condition(plan: "Plan") -> "ConditionResult":
    """Run one condition."""
    from arl_tui.timing.result import compare
    from arl_tui.timing.robot import TimingError, run_plan

    with click.progressbar(length=len(plan.trials), label=plan.condition, file=sys.stderr) as bar:
        try:
            robot, seen = run_plan(plan, lambda: bar.update(1))
        except TimingError as error:
            raise click.ClickException(str(error)) from error
    return compare(plan, robot, seen)


def report_lines(result: "TimingResult") -> Iterator[str]:
    """Yield what is printed."""
    from arl_tui.timing.published import published_lines
    from arl_tui.timing.result import LATE_MS, TABLE_HEAD, condition_lines
    from arl_tui.timing.waking import waking_line

    yield "Measured minus true reaction time, milliseconds:"
    yield ""
    yield TABLE_HEAD
    for condition in result.conditions:
        yield from condition_lines(condition)
    yield ""
    yield (
        "On the way out: from the flush to the robot's read; the rest is the key's way in, to its time stamp."
    )
    yield (
        f"Read late: the kernel passed the bytes to the robot more than {LATE_MS:g} ms after the flush. The "
        "robot's true time begins then, so the delay counts as error, though it is the pseudo-terminal's."
    )
    yield (
        "Bare reader: a few lines without a screen, in the same pseudo-terminal. What it has, the machine "
        "does; the rest is this program's."
    )
    if result.waking is not None:
        yield waking_line(result.waking)
    if result.load > BUSY * result.cores:
        yield (
            f"This machine is busy (load {result.load:.1f} on {result.cores} cores): only the medians say "
            "something about the program. Repeat on a quiet machine, and do not calibrate on a busy one."
        )
    yield "Targets on a quiet machine: at rest bias < 0.5, sd < 0.2; beside a board median < 0.5, p95 < 3."
    yield ""
    yield "Other programs, with screen and key in the chain (so not the same quantity):"
    yield ""
    yield from published_lines()
    yield ""
    yield (
        "Not seen here: the terminal's drawing, the compositor, the screen, the keyboard and its cable. "
        "Together they add typically 20 to 60 ms, about constant for one set-up; a fit has them in its "
        "offset. Nothing is subtracted. Measuring them takes a photodiode and a button box."
    )
