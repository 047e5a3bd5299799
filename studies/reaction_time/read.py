"""Read reaction times: our own recordings, BIDS `_beh.tsv` and `_events.tsv`, CSV with named columns.

The unit is never guessed: it is stated, or in the column's name, or in the BIDS sidecar, or fixed by BIDS
(`response_time` is in seconds). The magnitudes must then be those of human reactions.
"""

import csv
import gzip
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from studies.reaction_time.exclusion import Row
from studies.reaction_time.trial_log import TrialFileError, read_trials

Unit = Literal["s", "ms", "us", "ns"]
SECONDS: dict[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_UNIT_WORDS: dict[str, Unit] = {
    "s": "s",
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "ms": "ms",
    "msec": "ms",
    "millisecond": "ms",
    "milliseconds": "ms",
    "us": "us",
    "microseconds": "us",
    "ns": "ns",
    "nanoseconds": "ns",
}
MISSING = frozenset(
    {"", "n/a", "na", "nan", "null", "none", ".", "-", "--", "?", "missing", "#n/a", "<na>", "#num!"}
)
"""Texts that mean: no value (compared in lower case)."""
PLAUSIBLE_MEDIAN_S = (0.03, 20.0)
"""A median of recorded times outside this is a wrong unit, not a person."""

_ENOUGH_FOR_A_MEDIAN = 5


class ReadError(ValueError):
    """This file cannot be used; the message says where, what came and what to do."""


class Columns(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Which columns of a table hold what."""

    rt: str
    """Column of the reaction time."""
    unit: Unit | None = None
    """Its unit; None takes it from the column's name or the sidecar."""
    participant: str | None = "participant_id"
    """Column of the participant; where the table lacks it (or None), the file name tells."""
    keep: dict[str, tuple[str, ...]] = {}
    """Rows to read: column to allowed values, e.g. {"TrialOutcome": ("SuccessfulGo",)}."""
    by: tuple[str, ...] = ()
    """Columns of conditions: each participant's rows are taken apart by their values."""
    decimal: Literal[".", ","] = "."
    """What separates decimals; never guessed, because 1,023 may be a thousand."""
    waited_s: float | None = None
    """The task's time-out in seconds, for rows without a response; None where not known."""
    trust_magnitudes: bool = False
    """Accept medians outside `PLAUSIBLE_MEDIAN_S`."""


BIDS = Columns(rt="response_time")
"""What BIDS defines: `response_time` in seconds (specification, task events)."""


def read_rows(paths: Iterable[Path], columns: Columns | None = None) -> list[Row]:
    """Read any of the supported files by its name: `.jsonl` of ours, `.tsv`, `.csv`, each also `.gz`.

    Args:
        paths: files; rows keep their order.
        columns: for tables; `BIDS` unless given.

    Raises:
        ReadError: where a file, column, unit or value cannot be understood.
    """
    rows: list[Row] = []
    for path in paths:
        if path.name.endswith(".jsonl"):
            rows += _read_recording(path)
        else:
            rows += read_table(path, columns or BIDS)
    return rows


def read_table(path: Path, columns: Columns) -> list[Row]:
    """Read a CSV or TSV file (also gzipped); every row that `columns.keep` lets through, good or bad."""
    header, lines = cells_of(path)
    wanted = [columns.rt, *columns.keep, *columns.by]
    absent = [name for name in wanted if name not in header]
    if absent:
        raise ReadError(
            f"{path}: no column {absent[0]!r}; the columns are {', '.join(map(repr, header))}. Name yours."
        )
    factor = SECONDS[columns.unit or _unit_of(path, columns.rt)]
    rt_at = header.index(columns.rt)
    person_at = header.index(columns.participant) if columns.participant in header else None
    default = _participant_of(path)
    by_at = [header.index(name) for name in columns.by]
    tests = [(header.index(name), frozenset(values)) for name, values in columns.keep.items()]
    rows = []
    for number, cells in lines:
        if len(cells) != len(header):
            raise ReadError(
                f"{path}:{number}: {len(cells)} cells in a row, {len(header)} columns in the header"
            )
        if any(cells[at] not in allowed for at, allowed in tests):
            continue
        rt = _number(cells[rt_at], path, number, columns)
        participant = cells[person_at].strip() if person_at is not None else default
        if participant.lower() in MISSING:
            raise ReadError(
                f"{path}:{number}: no participant in column {columns.participant!r}, but {participant!r}; leave such rows "
                "out by the values of another column, or complete them"
            )
        participant = " ".join([participant, *(cells[at].strip() or "(none)" for at in by_at)])
        rows.append(
            Row(
                participant=participant,
                source=f"{path.name}:{number}",
                rt_s=None if rt is None else rt * factor,
                waited_s=columns.waited_s,
            )
        )
    if not rows:
        raise ReadError(f"{path}: no row left to read" + (f" with {columns.keep}" if columns.keep else ""))
    if not columns.trust_magnitudes:
        check_magnitudes(path, columns.rt, rows, factor)
    return rows


def check_magnitudes(path: Path, column: str, rows: Sequence[Row], factor: float) -> None:
    """Raise ReadError where a file's or a participant's median is that of another unit."""
    groups: dict[str, list[float]] = {}
    for row in rows:
        if row.rt_s is not None and row.rt_s > 0.0:
            groups.setdefault(row.participant, []).append(row.rt_s)
    unit = next(name for name, seconds in SECONDS.items() if seconds == factor)
    low, high = PLAUSIBLE_MEDIAN_S
    groups = {p: times for p, times in groups.items() if len(times) >= _ENOUGH_FOR_A_MEDIAN} or {
        "all": [t for times in groups.values() for t in times] or [1.0]
    }
    medians = {p: float(np.median(times)) for p, times in groups.items()}
    strange = {p: median for p, median in medians.items() if not low <= median <= high}
    if not strange:
        return
    participant, median = next(iter(strange.items()))
    fits = [name for name, seconds in SECONDS.items() if 0.1 <= median / factor * seconds <= 5.0]
    guess = f"they look like {fits[0]}: say unit={fits[0]!r}" if fits else "no unit makes reactions of them"
    raise ReadError(
        f"{path}: column {column!r} read in {unit} has a median of {median:g} s for {participant!r}"
        f"{f' and {len(strange) - 1} more' if len(strange) > 1 else ''}; human reactions have {low:g} to {high:g} s. "
        f"The numbers are about {median / factor:g}; {guess}, or trust_magnitudes if they are right."
    )


def write_rows(path: Path, rows: Sequence[Row], verdicts: Sequence[str]) -> None:
    """Write every row and what became of it as a new TSV file, so that an exclusion can be checked."""
    with path.open("x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(["participant_id", "source", "rt_s", "status", "verdict"])
        for row, verdict in zip(rows, verdicts, strict=True):
            rt = "n/a" if row.rt_s is None else repr(row.rt_s)
            writer.writerow([row.participant, row.source, rt, row.status, verdict])


def _read_recording(path: Path) -> list[Row]:
    try:
        session = read_trials(path)
    except TrialFileError as error:
        raise ReadError(str(error)) from error
    return [
        Row(
            participant=session.header.participant,
            source=f"{path.name}:{number}",
            rt_s=trial.rt_s,
            status=trial.status,
            practice=trial.practice,
            response_asked=bool(trial.expected_keys),
            waited_s=trial.time_out_s if trial.status == "time-out" else None,
            abandoned=trial.comment.startswith("abandoned"),
        )
        for number, trial in enumerate(session.trials, start=2)
    ]


def cells_of(path: Path) -> tuple[list[str], list[tuple[int, list[str]]]]:
    """Return the header and (line number, cells) of a table; cells of a row that stand empty beyond the header go.

    Raises:
        ReadError: no text, no header, or two columns of one name.
    """
    try:
        raw = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        text = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise ReadError(f"{path}: cannot be read as text in UTF-8 ({error}); save it as UTF-8") from error
    first = text.split("\n", 1)[0]
    delimiter = max("\t;,", key=first.count)  # ties go to the tab, then the semicolon
    reader = csv.reader(text.splitlines(), delimiter=delimiter, skipinitialspace=delimiter != "\t")
    table = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    if not table:
        raise ReadError(f"{path}: empty; expected a header line with column names")
    header = [name.strip() for name in table[0][1]]
    if len(set(header)) != len(header):
        raise ReadError(f"{path}: two columns have the same name in {header}; rename one")
    n = len(header)
    return header, [(line, cells[:n] if not any(cells[n:]) else cells) for line, cells in table[1:]]


def _number(text: str, path: Path, number: int, columns: Columns) -> float | None:
    """Return the number in a cell, None where the cell says that there is none."""
    text = text.strip()
    if text.lower() in MISSING:
        return None
    try:
        # With a decimal comma a point can only separate thousands, which we do not take.
        value = float(text if columns.decimal == "." else text.replace(".", "?").replace(",", "."))
    except ValueError:
        advice = "leave missing values empty or n/a"
        if columns.decimal == "." and re.fullmatch(r"-?\d*,\d+", text):
            advice = "if that is a decimal comma, say decimal=',' (`arl fit --decimal ,`)"
        raise ReadError(
            f"{path}:{number}: column {columns.rt!r} holds {text!r}, not a number; {advice}"
        ) from None
    return value if math.isfinite(value) else None


def _unit_of(path: Path, column: str) -> Unit:
    """Return the unit from the column's name, the BIDS sidecar, or BIDS itself; raise ReadError without one."""
    ending = re.split(r"[_.\s(\[-]+|(?<=[a-z])(?=[A-Z])", column.strip(" )]"))
    if len(ending) > 1 and ending[-1].lower() in _UNIT_WORDS:
        return _UNIT_WORDS[ending[-1].lower()]
    stated = _sidecar_unit(path, column)
    if stated is not None:
        if stated.lower() not in _UNIT_WORDS:
            raise ReadError(
                f"{path}: the sidecar gives unit {stated!r} for {column!r}; known are {sorted(_UNIT_WORDS)}"
            )
        return _UNIT_WORDS[stated.lower()]
    if column == "response_time" and re.search(r"_(events|beh)\.tsv(\.gz)?$", path.name):
        return "s"
    raise ReadError(
        f"{path}: column {column!r} has no unit. State it: unit='s' or unit='ms' in the column mapping "
        f'(`arl fit --unit ms`), or name the column {column}_s or {column}_ms, or put "Units" into the JSON sidecar.'
    )


def _sidecar_unit(path: Path, column: str) -> str | None:
    """Return "Units" of a column from the JSON file beside a BIDS table, None where there is none."""
    sidecar = path.with_name(re.sub(r"\.(tsv|csv)(\.gz)?$", ".json", path.name))
    if sidecar == path or not sidecar.is_file():
        return None
    try:
        described = msgspec.json.decode(sidecar.read_bytes())
    except msgspec.MsgspecError as error:
        raise ReadError(f"{sidecar}: not JSON: {error}") from error
    entry = described.get(column) if isinstance(described, dict) else None
    unit = entry.get("Units") if isinstance(entry, dict) else None
    return unit if isinstance(unit, str) else None


def _participant_of(path: Path) -> str:
    """Return sub-XX of a BIDS file name, else the name without its endings."""
    found = re.match(r"(sub-[A-Za-z0-9]+)", path.name)
    return found.group(1) if found else path.name.split(".")[0]
