"""Tables of an index: rows of fixed size, written one by one and read from the disk without loading the file.

While an index is built, each table grows in a temporary file of its own, so that memory does not grow with
the recording. The finished index is one file: a line of JSON that says where each table begins, then the
rows.
"""

import os
import struct
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any, BinaryIO

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.system.private_files import create_private, write_all

Rows = NDArray[Any]
"""A structured array, memory-mapped."""

DTYPES: dict[str, np.dtype[Any]] = {
    "frames": np.dtype([("time", "<i8"), ("covered", "<i8"), ("step", "<i4"), ("nth", "<i4"), ("number", "<i4")]),  # noqa: E501
    "steps": np.dtype(
        [
            ("offset", "<i8"), ("time", "<i8"), ("shown", "<i8"), ("covered", "<i8"), ("number", "<i4"),
            ("frame", "<i4"), ("episode", "<i4"), ("action", "<i4"), ("environment", "<i4"), ("human", "<i4"),
        ]
    ),
    "episodes": np.dtype(
        [
            ("offset", "<i8"), ("start", "<i8"), ("end", "<i8"), ("seed", "<i8"), ("number", "<i4"),
            ("first_step", "<i4"), ("n_steps", "<i4"), ("policy", "<i4"), ("form", "<i4"), ("ended", "<i4"),
            ("w_r", "<f8"), ("trust", "<f8"), ("weight", "<f8"), ("handover", "<f8"), ("performance", "<f8"),
            ("trust_after", "<f8"), ("agreed", "<i4"), ("agreed_worst", "<i4"),
        ]
    ),
    "presses": np.dtype(
        [
            ("offset", "<i8"), ("time", "<i8"), ("value", "<f8"), ("number", "<i4"), ("frame", "<i4"), ("step", "<i4"),  # noqa: E501
            ("person", "<i4"), ("verdict", "<i2"), ("simulated", "<i2"), ("asked_wrong", "<i2"), ("key", "S14"),  # noqa: E501
        ]
    ),
    "retractions": np.dtype([("time", "<i8"), ("press", "<i4"), ("auto_repeat", "<i4")]),
    "credits": np.dtype([("offset", "<i8"), ("press", "<i4"), ("merged_into", "<i4")]),
    "marks": np.dtype([("time", "<i8"), ("since", "<i8"), ("kind", "<i4"), ("detail", "<i4")]),
    "questions": np.dtype([("offset", "<i8"), ("time", "<i8"), ("answer", "<i8"), ("end", "<i8"), ("number", "<i4")]),  # noqa: E501
    "unseen": np.dtype([("time", "<i8"), ("mean", "<f8"), ("trust", "<f8"), ("first", "<i4"), ("count", "<i4")]),  # noqa: E501
}  # fmt: skip
"""Columns of each table. Times are ns of the recording's clock; an absent one is -1, an absent number NaN or
-1.

frames: `covered` is how long the game had been covered before, `nth` counts the new frames of a step from 0
(-1 where a frame shows again what a pause had covered). steps: `shown` and `frame` belong to the first frame
of the step, `episode` is a row. episodes: `first_step` is a row of steps. questions: `answer` is where the
line of the answer begins, and `end` when the question was over.
"""
_CODES = {"<i8": "q", "<i4": "i", "<i2": "h", "<f8": "d", "|S14": "14s"}


def _format(dtype: np.dtype[Any]) -> struct.Struct:
    """Return what packs a row of a table as numpy reads it."""
    return struct.Struct("<" + "".join(_CODES[dtype[column].str] for column in dtype.names or ()))


_FORMATS = {name: _format(dtype) for name, dtype in DTYPES.items()}


class Growing:
    """A table that is being written."""

    def __init__(self, name: str) -> None:
        """Begin an empty table with the columns of DTYPES[name]."""
        self.name = name
        self.n = 0
        self._pack = _FORMATS[name].pack
        self.size = DTYPES[name].itemsize
        self._file: IO[bytes] = tempfile.TemporaryFile(buffering=1 << 16)  # noqa: SIM115 - closed in `close`

    def add(self, *values: Any) -> None:
        """Append a row; values in the order of the columns."""
        self._file.write(self._pack(*values))
        self.n += 1

    def change(self, row: int, column: str, value: float) -> None:
        """Change one value of a row that has been written.

        Raises:
            ValueError: there is no such row.
        """
        if not 0 <= row < self.n:
            raise ValueError(f"a table of {self.n} {self.name} has no row {row}")
        dtype = DTYPES[self.name]
        assert dtype.fields is not None
        kind, offset = dtype.fields[column][:2]
        self._file.seek(row * self.size + offset)
        self._file.write(np.array(value, dtype=kind).tobytes())
        self._file.seek(0, os.SEEK_END)

    def copy_to(self, file: BinaryIO) -> None:
        """Write all rows to another file."""
        self._file.seek(0)
        while part := self._file.read(1 << 20):
            write_all(file, part)

    def close(self) -> None:
        """Give the temporary file up."""
        self._file.close()


class Contents(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """First line of an index."""

    index: int
    """Version of the index."""
    of: str
    """Fingerprint of the recording's file (`studies.session_view.index`)."""
    facts: dict[str, Any]
    """What is known of the recording as a whole."""
    tables: dict[str, tuple[int, int]]
    """Where each table begins, in bytes after the first line, and its number of rows."""


def write_tables(path: Path, tables: Mapping[str, Growing], contents: Contents) -> None:
    """Write an index; the file is there whole or not at all.

    Raises:
        OSError: it cannot be written.
    """
    places, at = {}, 0
    for name, table in tables.items():
        places[name] = (at, table.n)
        at += -(-table.n * table.size // 8) * 8
    first = msgspec.json.encode(msgspec.structs.replace(contents, tables=places))
    first += b" " * (-(len(first) + 1) % 8) + b"\n"
    being_written = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        with create_private(being_written) as file:
            write_all(file, first)
            for table in tables.values():
                table.copy_to(file)
                write_all(file, b"\0" * (-table.n * table.size % 8))
        os.replace(being_written, path)
    finally:
        being_written.unlink(missing_ok=True)


def read_tables(path: Path) -> tuple[Contents, dict[str, Rows]]:
    """Return an index: what is on its first line, and its tables, memory-mapped.

    Raises:
        ValueError: the file is no index, or is cut off.
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        first = file.readline(1 << 24)
    contents = msgspec.json.decode(first, type=Contents)
    if set(contents.tables) != set(DTYPES):
        raise ValueError(f"{path}: an index with tables {sorted(contents.tables)}")
    tables: dict[str, Rows] = {}
    for name, dtype in DTYPES.items():
        at, n = contents.tables[name]
        if not n:
            tables[name] = np.zeros(0, dtype=dtype)
        else:
            tables[name] = np.memmap(path, dtype=dtype, mode="r", offset=len(first) + at, shape=(n,))
    return contents, tables
