"""Programs' files with bytes changed, cut, doubled: read, or the documented error; never another
exception."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from core.numerics.streams import stream
from core.recording.importers.contract import ImporterError
from studies.evaluations.table import EvaluationColumns, read_evaluations
from studies.reaction_time.read import Columns, ReadError, read_files
from tests.studies.reaction_time.program_files import FILES, made

PER_FILE = 60
SIGNS = b"\x00\x1b\"',;\t\n\r[]{}:-.0159eEnaN\xff\x85\xc3*!"


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """Return the content with one to four faults: a byte changed, a piece cut out, doubled, or moved."""
    for _ in range(int(rng.integers(1, 5))):
        a, b = sorted(rng.integers(0, len(content) + 1, 2).tolist())
        kind = int(rng.integers(5))
        if kind == 0 and content:
            content = content[:a] + bytes([SIGNS[int(rng.integers(len(SIGNS)))]]) + content[a + 1 :]
        elif kind == 1:
            content = content[:a] + content[min(b, a + 30) :]
        elif kind == 2:
            content = content[:b] + content[a:b] + content[b:]
        elif kind == 3:
            content = content[: max(b, 1)]
        else:
            content = content[:a] + bytes(rng.choice(list(SIGNS), 5).tolist()) + content[a:]
    return content


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_read_or_refused_with_the_documented_error(tmp_path: Path, name: str) -> None:
    whole = made(tmp_path, name).read_bytes()
    rng = stream(4, f"damaged {name}")
    for turn in range(PER_FILE):
        content = damaged(whole, rng)
        packed = turn % 10 == 9
        path = tmp_path / f"{turn}{'.csv.gz' if packed else '.csv'}"
        path.write_bytes(damaged(gzip.compress(content), rng) if packed else content)
        said = []
        for preset, columns in ((None, Columns()), (name, Columns()), ("table", Columns(rt="rt", unit="ms"))):
            try:
                (reading,) = read_files([path], columns, preset)
                said.append(f"{path}: read {reading.taken.total() - len(reading.rows)} rows too many")
            except ReadError as error:
                said.append(str(error))
        try:
            read_evaluations(
                path, EvaluationColumns(participant="participant", time="resp.rt", value="resp.corr")
            )
        except ImporterError as error:
            said.append(str(error))
        assert all(str(path) in words and "\x1b" not in words for words in said)
        assert all("rows too many" not in words or "read 0 rows" in words for words in said)
