"""The input of `arl fit`: columns, units, policy; and clear messages where a file cannot be used."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from arl_tui.commands.fit_request import FAULTS, InputError, Request

if TYPE_CHECKING:
    from studies.reaction_time.exclusion import Row, Selection
    from studies.reaction_time.read import Columns, Reading
    from studies.reaction_time.sample import Sample

MOST_FAULTS = 0.05
"""A larger fraction of negative or absurd times is a wrong column or unit, not an accident."""
WORTH_A_WARNING = 0.02
"""Limits that leave out a larger fraction of the responses are those of another task, or of another unit."""
FILES_IN_FULL = 4
"""So many files are described one by one, more of them together."""


def read(files: Sequence[Path], request: Request) -> "list[Reading]":
    """Return what stands in the files.

    Raises:
        InputError: where a file cannot be used.
    """
    from studies.reaction_time.read import ReadError, read_files
    from studies.reaction_time.tables.registry import preset_of

    try:
        if request.preset is not None:
            preset_of(request.preset)
        return read_files(files, columns_of(request), request.preset)
    except ReadError as error:
        hint = (
            "Options that may help: --from PROGRAM, --column rt=NAME, --unit s|ms|us|ns, --keep COLUMN=VALUE,"
            " --trust-magnitudes."
        )
        raise InputError(f"{error}\n{hint}") from error
    except OSError as error:
        raise InputError(str(error)) from error


def select_from(
    readings: "Sequence[Reading]", request: Request, task: str
) -> "tuple[list[Row], dict[str, Sample], Selection]":
    """Return all rows, the samples to fit by participant, and what happened to each row.

    Raises:
        InputError: too many rows are faulty, or nobody is left to fit.
    """
    from studies.reaction_time.exclusion import SLOW_ABOVE_S, ExclusionPolicy, kind_of_task, select

    slow_above = SLOW_ABOVE_S[kind_of_task(task)] if request.slow_above is None else request.slow_above
    try:
        policy = ExclusionPolicy(
            anticipation_below_s=request.anticipation_below,
            slow_above_s=slow_above,
            absurd_above_s=request.absurd_above,
            keep_practice=request.keep_practice,
            keep_wrong=request.keep_wrong,
            time_outs=request.time_outs,
        )
    except ValueError as error:
        raise InputError(str(error)) from error
    rows = [row for reading in readings for row in reading.rows]
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


def source_lines(readings: "Sequence[Reading]") -> Iterator[str]:
    """Yield what each file was recognised as, what was taken and left out, and what was odd about it."""
    groups: dict[tuple[str, str, str], list[Reading]] = {}
    for reading in readings:
        alone = "" if len(readings) > FILES_IN_FULL else str(reading.path)
        key = (reading.recognised, reading.mapping, alone)
        groups.setdefault(key, []).append(reading)
    for some in groups.values():
        first = some[0]
        name = first.path.name if len(some) == 1 else f"{len(some)} files"
        yield f"{name}: {first.recognised}" + (f"; {first.mapping}." if first.mapping else ".")
        taken, left_out = (
            sum((Counter(counts) for counts in every), Counter[str]())
            for every in ([one.taken for one in some], [one.left_out for one in some])
        )
        yield f"  taken: {', '.join(f'{n} {words}' for words, n in taken.items())}"
        if left_out:
            yield f"  left out: {', '.join(f'{n} {words}' for words, n in left_out.items())}"
        for one in some:
            where = "" if len(some) == 1 else f"{one.path.name}: "
            yield from (f"  Note: {where}{words}." for words in one.notes)
    yield from _condition_lines(readings)


def _condition_lines(readings: "Sequence[Reading]") -> Iterator[str]:
    said: dict[str, list[str]] = {}
    for reading in readings:
        if reading.conditions is not None:
            said.setdefault(reading.conditions, []).append(reading.path.name)
    for words, names in said.items():
        where = names[0] if len(names) == 1 else f"{len(names)} files"
        yield f"Note: {where}: {words}. --keep COLUMN=VALUE takes some of them, --by COLUMN each apart."


def limit_lines(rows: "Sequence[Row]", selection: "Selection", request: Request, task: str) -> Iterator[str]:
    """Yield a warning where a limit by default leaves out many responses."""
    from studies.reaction_time.exclusion import SLOW_ABOVE_S, kind_of_task

    counts = Counter(selection.verdicts)
    n = counts["kept"] + counts["slow"] + counts["anticipation"]
    kind, policy = kind_of_task(task), selection.policy
    if request.slow_above is None and counts["slow"] > WORTH_A_WARNING * n:
        longest = max(
            (row.rt_s for row, v in zip(rows, selection.verdicts, strict=True) if v == "slow" and row.rt_s),
            default=0.0,
        )
        other = (
            f"Are they evaluations? --task evaluation takes them up to {SLOW_ABOVE_S['evaluation']:g} s. "
            if kind == "reaction"
            else ""
        )
        yield (
            f"Warning: the limit for {kind}s of {policy.slow_above_s:g} s leaves out {counts['slow']} of {n}"
            f" responses ({counts['slow'] / n:.1%}, up to {longest:.3g} s): the fits describe the faster ones"
            f" only. {other}--slow-above SECONDS sets the limit."
        )
    if (
        request.anticipation_below == policy.anticipation_below_s
        and counts["anticipation"] > WORTH_A_WARNING * n
    ):
        yield (
            f"Warning: {counts['anticipation']} of {n} responses ({counts['anticipation'] / n:.1%}) are"
            f" called anticipations (faster than {policy.anticipation_below_s:g} s, or by the file's own"
            " word) and left out. --anticipation-below SECONDS sets the limit."
        )


def columns_of(request: Request) -> "Columns":
    """Return the column mapping that the options describe."""
    from studies.reaction_time.read import Columns

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
        rt=named.get("rt", ""),
        unit=request.unit,
        participant=named.get("participant", Columns().participant),
        keep=keep,
        by=request.by,
        decimal=request.decimal,
        waited_s=request.waited,
        trust_magnitudes=request.trust_magnitudes,
        of_list=request.of_list,
        missing=request.missing,
        encoding=request.encoding,
    )


def oddity_lines(request: Request, rows: "Sequence[Row]", samples: "Mapping[str, Sample]") -> Iterator[str]:
    """Yield what looks wrong about codes and times, as warnings."""
    from studies.reaction_time.oddities import alike_names, copied_times, piles_at_the_maximum, steps_of_time

    if not request.as_one:
        names = list(dict.fromkeys(row.participant for row in rows))
        yield from (f"Warning: {words}." for words in alike_names(names))
    yield from (f"Warning: {words}" for words in copied_times(samples))
    yield from (f"Warning: {words}." for words in piles_at_the_maximum(samples))
    yield from (f"Note: {words}." for words in steps_of_time(samples))


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals and value):
        raise click.BadParameter(f"{text!r}: write NAME=VALUE", param_hint=option)
    return name, value


def refuse_faults(rows: "Sequence[Row]", selection: "Selection") -> None:
    """Stop where too many times are negative or absurd to be reaction times in the stated unit."""
    counts: dict[str, Counter[str]] = {}
    first: dict[str, str] = {}
    values: dict[str, set[float]] = {}
    for row, verdict in zip(rows, selection.verdicts, strict=True):
        if row.rt_s is not None:
            file = row.source.rpartition(":")[0]
            counts.setdefault(file, Counter())[verdict] += 1
            if verdict in FAULTS:
                first.setdefault(file, f"{row.source} ({row.rt_s:g} s)")
                values.setdefault(file, set()).add(row.rt_s)
    for file, counter in counts.items():
        n_faults, n = sum(counter[fault] for fault in FAULTS), counter.total()
        code = (
            f" All are {next(iter(values[file])):g} s: a code for no response? --missing says so."
            if len(values.get(file, ())) == 1
            else ""
        )
        if n_faults > MOST_FAULTS * n:
            raise InputError(
                f"{file}: {n_faults} of {n} times are negative or above {selection.policy.absurd_above_s:g}"
                f" s, the first at {first[file]}. Is this the column of reaction times (--column rt=NAME),"
                " and is its unit right (--unit)? --allow-faults leaves such rows out and fits the"
                f" rest.{code}"
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
    from studies.reaction_time.read import is_evaluations
    from studies.reaction_time.trial_log import TrialFileError, read_trials

    tasks: dict[str, str] = {}
    for path in files:
        if path.name.endswith(".jsonl"):
            if is_evaluations(path):
                tasks.setdefault("evaluation", path.name)
                continue
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
