"""Read reaction times: our own recordings, tables with named columns, and the files of well-known programs.

The unit is never guessed: it is stated, or in the column's name, or in a BIDS sidecar, or fixed by BIDS or by
the program that wrote the file. The magnitudes must then be those of human reactions.
"""

import csv
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from core.recording.reader import RecordingError, read_recording
from core.system.foreign_text import printable
from studies.evaluations.importer import FORMAT as EVALUATIONS
from studies.evaluations.presses import presses_of
from studies.reaction_time.exclusion import Row
from studies.reaction_time.tables.contract import BIDS, MISSING, SECONDS, Columns, ReadError, Reading, Unit
from studies.reaction_time.tables.registry import PLAIN, read_file
from studies.reaction_time.tables.units import PLAUSIBLE_MEDIAN_S
from studies.reaction_time.trial_log import TrialFileError, read_trials

__all__ = [
    "BIDS",
    "MISSING",
    "PLAUSIBLE_MEDIAN_S",
    "SECONDS",
    "Columns",
    "ReadError",
    "Reading",
    "Unit",
    "is_evaluations",
    "read_files",
    "read_rows",
    "read_table",
    "write_rows",
]


def read_files(
    paths: Iterable[Path], columns: Columns | None = None, preset: str | None = None
) -> list[Reading]:
    """Read any of the supported files: our `.jsonl`, a table, or a program's file, also as `.gz`.

    Args:
        paths: files.
        columns: for tables; BIDS's names unless given.
        preset: how all tables are read (`studies.reaction_time.tables.registry.NAMES`); None recognises each.

    Returns:
        One reading per file, in order; rows keep their order.

    Raises:
        ReadError: where a file, column, unit or value cannot be understood.
    """
    return [
        (
            _read_recording(path)
            if path.name.endswith(".jsonl") and preset is None
            else read_file(path, columns or Columns(), preset)
        )
        for path in paths
    ]


def read_rows(paths: Iterable[Path], columns: Columns | None = None) -> list[Row]:
    """Return the rows of `read_files`, in order."""
    return [row for reading in read_files(paths, columns) for row in reading.rows]


def read_table(path: Path, columns: Columns) -> list[Row]:
    """Read a table by its columns' names; every row that `columns.keep` lets through, good or bad."""
    return read_file(path, columns, PLAIN.name).rows


def write_rows(path: Path, rows: Sequence[Row], verdicts: Sequence[str]) -> None:
    """Write every row and what became of it as a new TSV file, so that an exclusion can be checked."""
    with path.open("x", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(["participant_id", "source", "rt_s", "status", "verdict"])
        for row, verdict in zip(rows, verdicts, strict=True):
            rt = "n/a" if row.rt_s is None else repr(row.rt_s)
            writer.writerow([row.participant, row.source, rt, row.status, verdict])


def is_evaluations(path: Path) -> bool:
    """Return whether a `.jsonl` file is a recording of sessions rather than of reaction trials."""
    with path.open("rb") as file:
        return b'"arl-recording"' in file.read(400)


def _read_evaluations(path: Path) -> Reading:
    """Read the delays of imported evaluations; live sessions do not say what a press judged."""
    try:
        recording = read_recording(path)
    except RecordingError as error:
        raise ReadError(str(error)) from error
    header = recording.header
    if header.source.get("format") != EVALUATIONS:
        raise ReadError(
            f"{path}: a recorded session: what each press judged is not known, so its delay is not measured."
            " `arl presses` reports the presses, `arl calibrate` measures delays"
        )
    presses = presses_of(recording)
    rows = [
        Row(
            participant=header.participant,
            source=f"{printable(path.name)}: press {number}",
            rt_s=press.delay_s,
            status="anticipation" if press.delay_s is not None and press.delay_s < 0 else "ok",
        )
        for number, press in enumerate(presses)
    ]
    return Reading(
        path=path,
        recognised="imported evaluations",
        mapping="delays since the event judged",
        rows=rows,
        taken=Counter({"evaluations": len(rows)}),
    )


def _read_recording(path: Path) -> Reading:
    if is_evaluations(path):
        return _read_evaluations(path)
    try:
        session = read_trials(path)
    except TrialFileError as error:
        raise ReadError(str(error)) from error
    rows = [
        Row(
            participant=session.header.participant,
            source=f"{printable(path.name)}:{number}",
            rt_s=trial.rt_s,
            status=trial.status,
            practice=trial.practice,
            response_asked=bool(trial.expected_keys),
            waited_s=trial.time_out_s if trial.status == "time-out" else None,
            abandoned=trial.comment.startswith("abandoned"),
        )
        for number, trial in enumerate(session.trials, start=2)
    ]
    cut = ("the last line was cut off in writing and is left out",) if session.torn_line else ()
    return Reading(
        path=path,
        recognised="a recording of this program",
        rows=rows,
        taken=Counter({"trials": len(rows)}),
        left_out=Counter({"cut off in writing": 1} if session.torn_line else {}),
        notes=cut,
    )
