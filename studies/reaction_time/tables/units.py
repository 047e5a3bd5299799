"""The unit of a column: in its name, in a BIDS sidecar, or fixed by BIDS. Never guessed."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import numpy as np

from studies.reaction_time.exclusion import Row
from studies.reaction_time.tables.contract import SECONDS, ReadError, Unit, shown

PLAUSIBLE_MEDIAN_S = (0.03, 20.0)
"""A median of recorded times outside this is a wrong unit, not a person."""
_ENOUGH_FOR_A_MEDIAN = 5
_ENOUGH_FOR_A_CLOCK = 10
_LEAST_STEP_OF_A_CLOCK_S = 0.1
_SHARE_OF_A_CLOCK = 0.9
"""A clock may begin anew with each block."""
_UNIT_WORDS: dict[str, Unit] = {
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "sek", "sekunden", "secondes"), "s"),
    **dict.fromkeys(("ms", "msec", "msecs", "millisecond", "milliseconds", "millis"), "ms"),
    **dict.fromkeys(("us", "µs", "μs", "usec", "microsecond", "microseconds"), "us"),
    **dict.fromkeys(("ns", "nsec", "nanosecond", "nanoseconds"), "ns"),
}
_BIDS_NAME = re.compile(r"(?P<entities>.*)_(?P<suffix>events|beh)\.tsv(\.gz)?$")
_FOLDERS_UP = 6


def unit_of(path: Path, column: str, values: Sequence[str] = ()) -> Unit:
    """Return the unit from the column's name, a sidecar, or BIDS itself.

    Args:
        path: the table.
        column: its column of times.
        values: some of its cells, for the message.

    Raises:
        ReadError: nothing states the unit.
    """
    named = unit_in_name(column)
    if named is not None:
        return named
    stated = sidecar_unit(path, column)
    if stated is not None:
        sidecar, text = stated
        if text.lower() not in _UNIT_WORDS:
            raise ReadError(
                f"{path}: the sidecar {sidecar} gives unit {shown(text)} for {shown(column)}; "
                f"known are {sorted(_UNIT_WORDS)}"
            )
        return _UNIT_WORDS[text.lower()]
    if column == "response_time" and is_bids(path):
        return "s"
    raise ReadError(
        f"{path}: column {shown(column)} has no unit. State it: unit='s' or unit='ms' in the column mapping "
        f"(`arl fit --unit ms`), or name the column {column}_s or {column}_ms and say so (`--column "
        f'rt={column}_ms`), or put "Units" into the JSON sidecar.'
        f"{_likely_unit(values)}"
    )


def unit_in_name(column: str) -> Unit | None:
    """Return the unit at the end of a column's name (`rt_ms`, `RT (s)`, `rtMs`); None where there is none."""
    ending = re.split(r"[_.\s(\[-]+|(?<=[a-z])(?=[A-Z])", column.strip(" )]"))
    return _UNIT_WORDS.get(ending[-1].lower()) if len(ending) > 1 else None


def is_bids(path: Path) -> bool:
    """Return whether a file is named like BIDS's behavioural tables."""
    return _BIDS_NAME.match(path.name) is not None


def sidecar_unit(path: Path, column: str) -> tuple[Path, str] | None:
    """Return "Units" of a column and the nearest sidecar that states it (BIDS's inheritance principle).

    A sidecar applies if it has the table's suffix and no entity that the table has not (BIDS specification,
    common principles). Sidecars are looked for from the table's folder up to the one with
    `dataset_description.json`.
    """
    for sidecar in _sidecars(path):
        try:
            described = msgspec.json.decode(sidecar.read_bytes().removeprefix(b"\xef\xbb\xbf"))
        except (msgspec.MsgspecError, OSError, RecursionError) as error:
            raise ReadError(f"{sidecar}: not JSON: {error}") from error
        entry = described.get(column) if isinstance(described, dict) else None
        unit = entry.get("Units") if isinstance(entry, dict) else None
        if isinstance(unit, str):
            return sidecar, unit.strip()
    return None


def _sidecars(path: Path) -> Iterator[Path]:
    """Yield the sidecars that apply, nearest first; of one folder the one with more entities first."""
    own = path.with_name(re.sub(r"\.(tsv|csv)(\.gz)?$", ".json", path.name))
    if own != path and own.is_file():
        yield own
    found = _BIDS_NAME.match(path.name)
    if found is None:
        return
    entities = set(found["entities"].split("_"))
    for folder in _folders_up(path):
        candidates = []
        for sidecar in folder.glob(f"*{found['suffix']}.json"):
            stem = sidecar.stem.removesuffix(found["suffix"]).rstrip("_")
            theirs = set(stem.split("_")) if stem else set()
            if theirs <= entities and sidecar != own:
                candidates.append((len(theirs), sidecar))
        yield from (sidecar for _, sidecar in sorted(candidates, reverse=True))


def _folders_up(path: Path) -> Iterator[Path]:
    """Yield the table's folder and those above it, up to the data set's own."""
    folders = [path.resolve().parent, *path.resolve().parent.parents][:_FOLDERS_UP]
    root = next(
        (i for i, folder in enumerate(folders) if (folder / "dataset_description.json").is_file()), None
    )
    for i, folder in enumerate(folders):
        yield folder
        inside = re.match(r"(sub|ses)-|(beh|func|eeg|meg|ieeg|nirs|motion)$", folder.name)
        if i == root or (root is None and not inside):
            return


def check_magnitudes(path: Path, column: str, rows: Sequence[Row], factor: float) -> None:
    """Raise ReadError where a participant's median is that of another unit, or the times are a clock's."""
    groups: dict[str, list[float]] = {}
    for row in rows:
        if row.rt_s is not None and row.rt_s > 0.0:
            groups.setdefault(row.participant, []).append(row.rt_s)
    _refuse_a_clock(path, column, groups)
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
    fits = _units_of_reactions(median / factor)
    guess = f"they look like {fits[0]}: say unit={fits[0]!r}" if fits else "no unit makes reactions of them"
    raise ReadError(
        f"{path}: column {shown(column)} read in {unit} has a median of {median:g} s for "
        f"{shown(participant)}{f' and {len(strange) - 1} more' if len(strange) > 1 else ''}; human reactions "
        f"have {low:g} to {high:g} s. The numbers are about {median / factor:g}; {guess}, or "
        "trust_magnitudes if they are right."
    )


def _refuse_a_clock(path: Path, column: str, groups: dict[str, list[float]]) -> None:
    """Raise ReadError where a participant's times grow from row to row, by more than sorted times do."""
    for participant, times in groups.items():
        steps = np.diff(times)
        growing = (steps >= _LEAST_STEP_OF_A_CLOCK_S).mean() if steps.size else 0.0
        if len(times) >= _ENOUGH_FOR_A_CLOCK and growing >= _SHARE_OF_A_CLOCK:
            raise ReadError(
                f"{path}: column {shown(column)} grows from row to row for {shown(participant)}, from"
                f" {times[0]:g} to {times[-1]:g} s: it holds times on a clock, not reaction times. Name the"
                " column of reaction times (--column rt=NAME), or subtract the stimuli's times;"
                " trust_magnitudes if they are right"
            )


def _units_of_reactions(number: float) -> list[str]:
    return [name for name, seconds in SECONDS.items() if 0.1 <= number * seconds <= 5.0]


def _likely_unit(values: Sequence[str]) -> str:
    numbers = []
    for text in values[:1000]:
        try:
            numbers.append(float(text.replace(",", ".")))
        except ValueError:
            continue
    positive = [number for number in numbers if number > 0]
    if len(positive) < _ENOUGH_FOR_A_MEDIAN:
        return ""
    median = float(np.median(positive))
    fits = _units_of_reactions(median)
    return f" The median is {median:g}: reactions in {fits[0]}?" if fits else f" The median is {median:g}."
