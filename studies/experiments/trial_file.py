"""The file of one trial: whether it is whole, and the trial's own. Damaged ones are named, never averaged in.

Beside each file lies its seal: what the file's SHA-256 is, of which trial it is, and with which settings it
was played. The seal is written first, so a file without one was written by an earlier version; of such a file
only the form can be checked, and that it is as long as the others of its condition: in episodes, or in hours
of play where the trials last so many hours and take as many episodes as fit.
"""

import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

_NAME = re.compile(r"seed-(\d{7,})\.csv")
HOURS = "hours"
"""Column of hours of play at the end of each episode, where a trial lasts so many hours."""


class DamagedTrial(ValueError):
    """A trial's file cannot be used; the message says why."""


class Seal(msgspec.Struct, frozen=True, kw_only=True):
    """What is known of a trial's file."""

    file: str
    """Condition and name, as `linear/seed-0000003.csv`."""
    sha256: str
    """Of the file's bytes, hex."""
    settings: str
    """SHA-256 of the condition's settings in JSON with sorted keys, hex."""
    quick: bool
    """Played as a smoke test."""


@dataclass(frozen=True, slots=True)
class Played:
    """What the trials of a condition were played with."""

    settings: Any
    """Plain, as in JSON."""
    quick: bool

    @property
    def digest(self) -> str:
        """SHA-256 of the settings, hex."""
        return hashlib.sha256(msgspec.json.encode(self.settings, order="sorted")).hexdigest()


def seal_path(path: Path) -> Path:
    """Return where the seal of a trial's file lies."""
    return path.with_suffix(".seal.json")


def seal_of(path: Path, content: bytes, played: Played) -> str:
    """Return the seal of a trial's file as text.

    Args:
        path: of the file, in the folder of its condition.
        content: its bytes.
        played: with what.
    """
    seal = Seal(
        file=f"{path.parent.name}/{path.name}",
        sha256=hashlib.sha256(content).hexdigest(),
        settings=played.digest,
        quick=played.quick,
    )
    return msgspec.json.encode(seal).decode() + "\n"


def seed_of(path: Path) -> int:
    """Return the root seed in a file's name.

    Raises:
        DamagedTrial: there is none.
    """
    match = _NAME.fullmatch(path.name)
    if match is None:
        raise DamagedTrial("no trial's file is called so: seed-0000003.csv")
    return int(match[1])


def read_rows(path: Path, played: Played) -> dict[str, NDArray[np.float64]]:
    """Return a trial's columns by name, after all checks that one file allows.

    Args:
        path: of the file.
        played: with what its condition is played.

    Raises:
        DamagedTrial: it is damaged, another trial's, or was played with other settings.
        OSError: it cannot be read.
    """
    content = path.read_bytes()
    _check_seal(path, content, played)
    try:
        text = content.decode()
        if not text.endswith("\n"):
            raise DamagedTrial("its last line is cut off")
        first, *lines = text[:-1].split("\n")
        names = first.split(",")
        if names[0] != "episode" or len(set(names)) != len(names) or len(names) < 2:
            raise DamagedTrial(f"its first line names no columns of a trial: {first[:60]!r}")
        if not lines:
            raise DamagedTrial("it holds no row")
        table = np.array([line.split(",") for line in lines], dtype=np.float64)
    except DamagedTrial:
        raise
    except ValueError as error:
        raise DamagedTrial(f"it is no table of numbers: {str(error)[:200]}") from error
    if table.shape[1] != len(names):
        raise DamagedTrial(f"{len(names)} columns are named, rows have {table.shape[1]}")
    if not np.array_equal(table[:, 0], np.arange(len(table))):
        raise DamagedTrial("its episodes are not 0, 1, 2, ...: rows are missing or moved")
    return {name: table[:, place] for place, name in enumerate(names)}


def _check_seal(path: Path, content: bytes, played: Played) -> None:
    beside = seal_path(path)
    if not beside.exists():
        return
    try:
        seal = msgspec.json.decode(beside.read_bytes(), type=Seal)
    except (ValueError, RecursionError) as error:
        raise DamagedTrial(f"its seal {beside.name} is damaged: {error}") from error
    if seal.sha256 != hashlib.sha256(content).hexdigest():
        raise DamagedTrial("it was changed after it was written, or is not whole")
    if seal.file != f"{path.parent.name}/{path.name}":
        raise DamagedTrial(f"it is another trial's: {seal.file}")
    if (seal.settings, seal.quick) != (played.digest, played.quick):
        raise DamagedTrial("it was played with other settings")


def read_trials(
    paths: Iterable[Path], played: Played
) -> tuple[dict[Path, dict[str, NDArray[np.float64]]], dict[Path, str]]:
    """Return the sound trials of a condition, and why each of the others cannot be used.

    Args:
        paths: of their files.
        played: with what the condition is played.
    """
    sound: dict[Path, dict[str, NDArray[np.float64]]] = {}
    damaged: dict[Path, str] = {}
    for path in paths:
        try:
            seed_of(path)
            sound[path] = read_rows(path, played)
        except DamagedTrial as error:
            damaged[path] = str(error)
        except OSError as error:
            damaged[path] = f"it cannot be read: {error.strerror}"
    for path, reason in _unlike_the_others(sound).items():
        damaged[path] = reason
        del sound[path]
    return sound, damaged


def _unlike_the_others(trials: dict[Path, dict[str, NDArray[np.float64]]]) -> dict[Path, str]:
    """Return the trials that have other columns than the rest of their condition, and those without a seal
    that are not as long.
    """
    sealed = {path for path in trials if seal_path(path).exists()}
    names = Counter(tuple(trials[path]) for path in sealed or trials)
    usual = names.most_common(1)[0][0] if names else ()
    found = {
        path: "its columns are not those of the condition's other trials"
        for path, rows in trials.items()
        if tuple(rows) != usual
    }
    alike = {path: rows for path, rows in trials.items() if path not in found}
    complete = [rows for path, rows in alike.items() if path in sealed] or list(alike.values())
    n_rows = max((len(rows["episode"]) for rows in complete), default=0)
    by_time = all(_is_by_time(rows) for rows in alike.values())
    for path, rows in alike.items():
        if path in sealed:
            continue  # whole by its seal
        if by_time:
            if _ends_early(rows, complete):
                found[path] = (
                    f"it ends after {rows[HOURS][-1]:.3g} hours of play, the condition's other trials go on"
                )
        elif len(rows["episode"]) != n_rows:
            found[path] = f"it has {len(rows['episode'])} rows, the condition's other trials have {n_rows}"
    return found


def _is_by_time(rows: Mapping[str, NDArray[np.float64]]) -> bool:
    """Return whether a trial says the hours of play at the end of each episode."""
    return HOURS in rows and bool(rows[HOURS][0] > 0 and np.all(np.diff(rows[HOURS]) > 0))


def _ends_early(
    rows: Mapping[str, NDArray[np.float64]], others: Iterable[Mapping[str, NDArray[np.float64]]]
) -> bool:
    """Return whether another trial began an episode at or after the end of this one.

    A trial ends with the episode that reaches the hours of its condition: no whole one does so.
    """
    return any(len(other[HOURS]) > 1 and other[HOURS][-2] >= rows[HOURS][-1] for other in others)
