"""The input of `arl fit`: columns, units, policy; and clear messages where a file cannot be used."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

if TYPE_CHECKING:
    from arl_tui.commands.fit import Request
    from studies.reaction_time.exclusion import Row, Selection
    from studies.reaction_time.read import Columns
    from studies.reaction_time.sample import Sample

MOST_FAULTS = 0.05
"""A larger share of negative or absurd times is a wrong column or unit, not an accident."""
FAULTS = ("negative", "absurd")
"""Verdicts that no participant can cause."""


class InputError(click.ClickException):
    """The files cannot be used: status 2, as for any wrong use of the command."""

    exit_code = 2


def read_and_select(
    files: Sequence[Path], request: "Request"
) -> "tuple[list[Row], dict[str, Sample], Selection]":
    """Return all rows, the samples to fit by participant, and what happened to each row.

    Raises:
        InputError: where a file cannot be used, too many rows are faulty, or nobody is left to fit.
    """
    from studies.reaction_time.exclusion import ExclusionPolicy, select
    from studies.reaction_time.read import ReadError, read_rows

    try:
        policy = ExclusionPolicy(
            anticipation_below_s=request.anticipation_below,
            slow_above_s=request.slow_above,
            absurd_above_s=request.absurd_above,
            keep_practice=request.keep_practice,
            time_outs=request.time_outs,
        )
        rows = read_rows(files, columns_of(request))
    except ReadError as error:
        hint = "Options that may help: --column rt=NAME, --unit s|ms|us|ns, --keep COLUMN=VALUE, --trust-magnitudes."
        raise InputError(f"{error}\n{hint}") from error
    except (ValueError, OSError) as error:
        raise InputError(str(error)) from error
    if request.as_one:
        rows = [msgspec.structs.replace(row, participant="everybody") for row in rows]
    samples, selection = select(rows, policy)
    if not request.allow_faults:
        refuse_faults(rows, selection)
    samples = chosen(samples, selection, request.only)
    if not samples:
        raise InputError(
            "nobody has enough usable responses: "
            + "; ".join(
                f"{name}: {why} ({_counted(selection, name)})" for name, why in selection.unusable.items()
            )
        )
    return rows, samples, selection


def columns_of(request: "Request") -> "Columns":
    """Return the column mapping that the options describe."""
    from studies.reaction_time.read import BIDS, Columns

    named = dict(_pair(text, "--column") for text in request.column)
    unknown = sorted(named.keys() - {"rt", "participant"})
    if unknown:
        raise click.BadParameter(f"{unknown[0]!r}: use rt=NAME and participant=NAME", param_hint="--column")
    keep: dict[str, tuple[str, ...]] = {}
    for text in request.keep:
        column, value = _pair(text, "--keep")
        keep[column] = (*keep.get(column, ()), value)
    if request.waited is not None and not request.waited > 0.0:
        raise click.BadParameter(f"{request.waited} s: a time-out is > 0", param_hint="--waited")
    return Columns(
        rt=named.get("rt", BIDS.rt),
        unit=request.unit,
        participant=named.get("participant", BIDS.participant),
        keep=keep,
        by=request.by,
        decimal=request.decimal,
        waited_s=request.waited,
        trust_magnitudes=request.trust_magnitudes,
    )


def oddity_lines(
    files: Sequence[Path], request: "Request", rows: "Sequence[Row]", samples: "Mapping[str, Sample]"
) -> Iterator[str]:
    """Yield what looks wrong, as warnings."""
    from studies.reaction_time.oddities import alike_names, copied_times, unused_conditions

    if not request.as_one:
        names = list(dict.fromkeys(row.participant for row in rows))
        yield from (f"Warning: {words}." for words in alike_names(names))
    yield from (f"Warning: {words}" for words in copied_times(samples))
    for path in files:
        if not path.name.endswith(".jsonl"):
            words = unused_conditions(path, columns_of(request))
            if words is not None:
                yield f"Note: {words}. --keep COLUMN=VALUE takes some of them, --by COLUMN each apart."


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise click.BadParameter(f"{text!r}: write NAME=VALUE", param_hint=option)
    return name, value


def refuse_faults(rows: "Sequence[Row]", selection: "Selection") -> None:
    """Stop where so many times are negative or absurd that they cannot be reaction times in the stated unit."""
    counts: dict[str, Counter[str]] = {}
    first: dict[str, str] = {}
    for row, verdict in zip(rows, selection.verdicts, strict=True):
        if row.rt_s is not None:
            file = row.source.rpartition(":")[0]
            counts.setdefault(file, Counter())[verdict] += 1
            if verdict in FAULTS:
                first.setdefault(file, f"{row.source} ({row.rt_s:g} s)")
    for file, counter in counts.items():
        n_faults, n = sum(counter[fault] for fault in FAULTS), counter.total()
        if n_faults > MOST_FAULTS * n:
            raise InputError(
                f"{file}: {n_faults} of {n} times are negative or above {selection.policy.absurd_above_s:g} s, the "
                f"first at {first[file]}. Is this the column of reaction times (--column rt=NAME), and is its unit "
                "right (--unit)? --allow-faults leaves such rows out and fits the rest."
            )


def chosen(samples: "dict[str, Sample]", selection: "Selection", only: Sequence[str]) -> "dict[str, Sample]":
    """Return the samples of the participants named by --only; all of them without any name."""
    for name in only:
        if name in selection.unusable:
            raise InputError(f"{name}: {selection.unusable[name]}")
        if name not in samples:
            known = ", ".join(sorted(samples)[:8])
            raise InputError(f"--only {name}: no such participant; there are {len(samples)}, such as {known}")
    return {name: sample for name, sample in samples.items() if not only or name in only}


def task_of(files: Sequence[Path]) -> str:
    """Return what our recordings among the files measured; "unknown" where no file says it.

    Raises:
        InputError: they measured different things, which no single density describes.
    """
    from studies.reaction_time.trial_log import TrialFileError, read_trials

    tasks: dict[str, str] = {}
    for path in files:
        if path.name.endswith(".jsonl"):
            try:
                tasks.setdefault(read_trials(path).header.schedule.config.task, path.name)
            except TrialFileError as error:
                raise InputError(str(error)) from error
    if len(tasks) > 1:
        found = ", ".join(f"{task} ({file})" for task, file in tasks.items())
        raise InputError(f"these recordings measured different things: {found}. Fit each task apart.")
    return next(iter(tasks), "unknown")


def _counted(selection: "Selection", participant: str) -> str:
    counts = selection.counts[participant]
    return ", ".join(f"{n} {verdict}" for verdict, n in counts.items())
