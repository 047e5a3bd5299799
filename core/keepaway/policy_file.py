"""Learned policies on disk: an npz archive with the weights and a header in JSON that says where they come
from.
"""

import io
import lzma
import math
import struct
import tokenize
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.configuration.reading import ConfigurationError, read
from core.keepaway.autoplay import keepaway_tiles
from core.keepaway.pitch import KeepawayConfig
from core.learners.sarsa import Sarsa, new_sarsa
from core.learners.sarsa_config import SarsaConfig

FORMAT: Final = "arl keepaway policy"
VERSION: Final = 1
N_LAST: Final = 500
"""Episodes that the mean duration in a header is taken over."""


LARGEST_FILE: Final = 1 << 28
"""Bytes of a file: 256 MB."""
LARGEST_HEADER: Final = 1 << 20
"""Bytes of a header: it has one or two thousand."""
_UNREADABLE = (
    ValueError,  # numpy, JSON
    LookupError,  # a part is missing
    OSError,  # a place before the archive's beginning
    EOFError,
    RuntimeError,  # encrypted; nested too deeply
    NotImplementedError,  # packed by a method that Python does not know
    OverflowError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    tokenize.TokenError,  # numpy reads an old header
)
"""What damaged archives and arrays raise."""

MOST_TILINGS: Final = 128
"""More tilings than these would ask for memory that no machine has."""


class PolicyFileError(ValueError):
    """A file holds no policy that can be used; the message says why."""


class PolicyHeader(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where a policy comes from: enough to learn it again."""

    format: str = FORMAT
    version: int = VERSION
    task: KeepawayConfig
    learner: SarsaConfig
    n_tilings: int
    """Tilings per variable, 1..`MOST_TILINGS`."""
    root_seed: int
    hours: float
    """Simulated time it has learned for."""
    episodes: int
    """Episodes it has learned from."""
    duration_s: float
    """Mean duration of the last of these (at most `N_LAST`), while learning."""
    created_utc: str
    software: dict[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class SavedPolicy:
    """The weights of keepers that have learned, and where they come from."""

    header: PolicyHeader
    weights: NDArray[np.float64]
    """Shape (n, a, t): learners (1 where they share), options, tiles."""

    def __post_init__(self) -> None:
        header = self.header
        _check_size(header)
        expected = _empty(header).weights.shape
        if self.weights.shape != expected:
            raise PolicyFileError(
                f"the weights of {header.task.n_keepers} keepers against {header.task.n_takers} takers have "
                f"shape {expected}, got {self.weights.shape}"
            )
        if not np.isfinite(self.weights).all():
            raise PolicyFileError("some weights are not finite numbers")

    def sarsa(self) -> Sarsa:
        """Return learners with these weights; they would go on learning (see
        `core.learners.sarsa.frozen`).
        """
        return _empty(self.header)._replace(weights=self.weights.copy())


def _check_size(header: PolicyHeader) -> None:
    """Refuse what no memory could hold, before any is asked for."""
    if not 1 <= header.n_tilings <= MOST_TILINGS:
        raise PolicyFileError(f"n_tilings is 1..{MOST_TILINGS} tilings, got {header.n_tilings}")
    try:
        read(msgspec.to_builtins(header.task), header.task, to_run=False)
        read(msgspec.to_builtins(header.learner), header.learner, to_run=False)
    except ConfigurationError as error:
        raise PolicyFileError(str(error)) from error


def _empty(header: PolicyHeader) -> Sarsa:
    task = header.task
    return new_sarsa(header.learner, keepaway_tiles(task, header.n_tilings), task.n_keepers, task.n_actions)


def save_policy(path: Path, policy: SavedPolicy) -> None:
    """Write a policy; an existing file is replaced only by a complete one.

    Raises:
        OSError: the file cannot be written.
    """
    data = io.BytesIO()
    header = np.frombuffer(msgspec.json.encode(policy.header), np.uint8)
    np.savez_compressed(data, header=header, weights=policy.weights)
    partial = path.with_name(path.name + ".partial")
    try:
        partial.write_bytes(data.getvalue())
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def load_policy(path: Path) -> SavedPolicy:
    """Read a policy. No more memory is asked for than its header needs, whatever the archive claims to hold.

    Raises:
        PolicyFileError: the file is not a policy, or of a version that is not known here.
        OSError: the file cannot be read.
    """
    too_large = path.stat().st_size > LARGEST_FILE
    content = b"" if too_large else path.read_bytes()
    try:
        if too_large:
            raise ValueError(f"more than {LARGEST_FILE:,} bytes")
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            header = _header(_array(archive, "header", LARGEST_HEADER, np.dtype(np.uint8)).tobytes())
            _check_size(header)
            needed = _empty(header).weights.nbytes
            weights = _array(archive, "weights", needed + LARGEST_HEADER, np.dtype(np.float64))
        return SavedPolicy(header, weights)
    except PolicyFileError as error:
        raise PolicyFileError(f"{path}: {error}") from error
    except (*_UNREADABLE, MemoryError) as error:
        raise PolicyFileError(
            f"{path}: not a policy of Keepaway ({type(error).__name__}: {error}); `arl train keepaway --save "
            "FILE` makes one"
        ) from error


def _array(archive: zipfile.ZipFile, name: str, most_bytes: int, dtype: np.dtype[Any]) -> NDArray[Any]:
    """Return an array of an archive, of exactly this type, after a look at how large it says it is."""
    with archive.open(f"{name}.npy") as member:
        content = member.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise ValueError(f"{name} holds more than {most_bytes:,} bytes")
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    read_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }.get(version)
    if read_header is None:
        raise ValueError(f"{name} is of version {version} of numpy's format, expected 1.0 or 2.0")
    shape, _, found = read_header(file)
    if found != dtype:
        raise ValueError(f"{name} is of the type {found}, expected {dtype}")
    if math.prod(shape) * dtype.itemsize != len(content) - file.tell():
        raise ValueError(f"{name} says its shape is {shape}, and holds {len(content) - file.tell():,} bytes")
    file.seek(0)
    return np.asarray(np.lib.format.read_array(file, allow_pickle=False))


def _header(raw: bytes) -> PolicyHeader:
    named = msgspec.json.decode(raw, type=dict)
    if (named.get("format"), named.get("version")) != (FORMAT, VERSION):
        raise PolicyFileError(
            f"need {FORMAT!r} of version {VERSION}, got {named.get('format')!r} of version "
            f"{named.get('version')!r}"
        )
    return msgspec.json.decode(raw, type=PolicyHeader)
