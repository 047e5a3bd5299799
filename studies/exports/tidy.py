"""Tidy tables of a folder of data, as CSV or Parquet, with their codebook.

One file is read at a time and its rows are written at once, so memory does not grow with the number of files.
"""

import csv
import json
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, Self

from core.recording.reader import RecordingError, read_recording
from core.system.private_files import make_private_folder
from studies.exports.columns import Cell, Column, Row, Table, codebook, codebook_page
from studies.exports.event_rows import (
    credit_rows,
    frame_rows,
    interruption_rows,
    press_rows,
    question_rows,
    step_rows,
)
from studies.exports.event_tables import CREDIT, FRAMES, INTERRUPTIONS, PRESSES, QUESTIONS, STEPS
from studies.exports.other_rows import answer_rows, trial_rows
from studies.exports.session_rows import SessionRows
from studies.exports.sources import Source, Trouble, find_sources
from studies.exports.tables import ANSWERS, PLAYED, SESSIONS, SETTINGS, TABLES, TRIALS
from studies.lab.sealed import SealedFileError
from studies.lab.sitting_log import read_sitting
from studies.reaction_time.trial_log import TrialFileError, read_trials

FileFormat = Literal["csv", "parquet"]
ROWS_AT_ONCE = 10_000
"""Rows of a Parquet table that are held in memory."""

_SAME = ("participant", "created_utc", "root_seed", "duration_s", "steps", "presses_counted")
"""Columns in which two files of one session agree, and two sessions do not."""


class ExportError(ValueError):
    """An export cannot be made; the message says why and what to do."""


@dataclass(slots=True)
class Exported:
    """What came of it."""

    rows: dict[str, int] = field(default_factory=lambda: {table.name: 0 for table in TABLES})
    """Rows of each table."""
    files: int = 0
    """Files that were read."""
    left_out: list[Trouble] = field(default_factory=list)
    """Files of other kinds."""
    damaged: list[Trouble] = field(default_factory=list)
    """Files that could not be read."""
    origins: Counter[str] = field(default_factory=Counter)
    """Sessions by who pressed: live, simulated, or imported."""
    twice: list[tuple[str, str]] = field(default_factory=list)
    """Pairs of sessions that seem to be the same one: copies, or the same session in two versions of the
    format."""


def simulated_note(origins: Counter[str]) -> str:
    """Return a sentence on simulated sessions; "" where there are none."""
    if not origins["simulated"]:
        return ""
    sessions = f"{origins['simulated']} of {origins.total()} sessions"
    return f"SIMULATED: in {sessions} a simulated participant pressed (column `origin`)."


class TableFile(ABC):
    """A table's file that rows are added to."""

    @abstractmethod
    def add(self, row: Row) -> None:
        """Add a row with the table's columns."""

    @abstractmethod
    def close(self) -> None:
        """Write what is left."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class CsvFile(TableFile):
    """A table in CSV (RFC 4180, UTF-8): TRUE and FALSE, and an empty cell where there is no value."""

    def __init__(self, path: Path, table: Table) -> None:
        self._file = path.open("x", newline="", encoding="utf-8", errors="backslashreplace")
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._writer.writerow(table.names)

    def add(self, row: Row) -> None:
        """Add a row."""
        self._writer.writerow([_in_csv(cell) for cell in row.values()])

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class ParquetFile(TableFile):
    """A table in Parquet; each column's description is in its field's metadata."""

    def __init__(self, path: Path, table: Table) -> None:
        """Open the file.

        Raises:
            ExportError: pyarrow is not installed.
        """
        try:
            import pyarrow
            from pyarrow import parquet
        except ImportError as error:
            raise ExportError("Parquet needs pyarrow: pip install 'arl-tui[parquet]', or take CSV") from error
        self._schema = pyarrow.schema([_in_arrow(pyarrow, column) for column in table.columns])
        self._arrow = pyarrow
        self._writer = parquet.ParquetWriter(path, self._schema)
        self._rows: list[Row] = []

    def add(self, row: Row) -> None:
        """Add a row; written when there are many."""
        self._rows.append(row)
        if len(self._rows) >= ROWS_AT_ONCE:
            self._write()

    def close(self) -> None:
        """Write what is left and close the file."""
        self._write()
        self._writer.close()

    def _write(self) -> None:
        self._writer.write_table(self._arrow.Table.from_pylist(self._rows, self._schema))
        self._rows.clear()


def _in_csv(cell: Cell) -> Cell:
    if isinstance(cell, bool):
        return "TRUE" if cell else "FALSE"
    return cell


def _in_arrow(arrow: Any, column: Column) -> Any:
    kinds = {
        "text": arrow.string(),
        "integer": arrow.int64(),
        "number": arrow.float64(),
        "boolean": arrow.bool_(),
    }
    return arrow.field(
        column.name, kinds[column.kind], metadata={"description": column.meaning, "unit": column.unit}
    )


def export_tidy(place: Path, into: Path, *, file_format: FileFormat = "csv") -> Exported:
    """Write all tables of the data in a folder, and their codebook.

    Args:
        place: a folder of data, or one file.
        into: a new or an empty folder.
        file_format: of the tables.

    Raises:
        ExportError: `into` is not empty, or pyarrow is missing.
        OSError: something cannot be read or written.
    """
    if into.exists() and any(into.iterdir()):
        raise ExportError(f"{into} is not empty: name a new folder")
    sources = list(find_sources(place))
    make_private_folder(into)
    kind = CsvFile if file_format == "csv" else ParquetFile
    result, seen = Exported(), dict[tuple[Cell, ...], str]()
    with ExitStack() as stack:
        files = {
            table.name: stack.enter_context(kind(into / f"{table.name}.{file_format}", table))
            for table in TABLES
        }
        for source in sources:
            try:
                for table, row in rows_of(source):
                    files[table.name].add(table.checked(row))
                    result.rows[table.name] += 1
                    if table is SESSIONS:
                        result.origins[str(row["origin"])] += 1
                        first = seen.setdefault(tuple(row[name] for name in _SAME), source.session)
                        if first != source.session:
                            result.twice.append((first, source.session))
                result.files += 1
            except (RecordingError, TrialFileError, SealedFileError) as error:
                result.damaged.append(Trouble(source.path, str(error)))
            except OtherKindError as other:
                result.left_out.append(Trouble(source.path, str(other)))
    write_codebook(into, ending=file_format)
    return result


def write_codebook(into: Path, *, ending: str) -> None:
    """Write codebook.md and codebook.json."""
    (into / "codebook.md").write_text(codebook_page(TABLES), encoding="utf-8")
    described = json.dumps(codebook(TABLES, ending=ending), indent=2, ensure_ascii=False)
    (into / "codebook.json").write_text(described + "\n", encoding="utf-8")


class OtherKindError(ValueError):
    """A file is none of those that tables are made of."""


def rows_of(source: Source) -> Iterator[tuple[Table, Row]]:
    """Yield the rows of one file, each with its table.

    Raises:
        RecordingError, TrialFileError, SealedFileError: the file is damaged; nothing has been yielded then.
        OtherKindError: the file is of another kind.
        OSError: it cannot be read.
    """
    name = source.session
    match source.kind:
        case "recording":
            yield from _of_session(SessionRows(read_recording(source.path), name))
        case "sitting":
            header, lines = read_sitting(source.path)
            yield from ((ANSWERS, row) for row in answer_rows(header, lines, name))
        case "trials":
            yield from ((TRIALS, row) for row in trial_rows(read_trials(source.path), name))
        case _:
            raise OtherKindError(
                f"{source.path}: {source.format or 'another format'}: no table is made of it"
            )


def _of_session(session: SessionRows) -> Iterator[tuple[Table, Row]]:
    yield SESSIONS, session.session_row()
    yield from ((SETTINGS, row) for row in session.setting_rows())
    yield from ((PLAYED, row) for row in session.game_rows())
    yield from ((STEPS, row) for row in step_rows(session))
    yield from ((PRESSES, row) for row in press_rows(session))
    yield from ((CREDIT, row) for row in credit_rows(session))
    yield from ((FRAMES, row) for row in frame_rows(session))
    yield from ((INTERRUPTIONS, row) for row in interruption_rows(session))
    yield from ((QUESTIONS, row) for row in question_rows(session))
