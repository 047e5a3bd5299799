"""The real reaction times that tests use, read with plain csv: independent of the readers under test."""

import csv
import gzip
from collections import defaultdict
from functools import cache

import numpy as np
from numpy.typing import NDArray

from tests.data_folder import data_folder

Array = NDArray[np.float64]


def _rows(name: str) -> list[dict[str, str]]:
    path = data_folder("reaction_time") / name
    with gzip.open(path, "rt", newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def _by_participant(pairs: list[tuple[str, float]]) -> dict[str, Array]:
    grouped: dict[str, list[float]] = defaultdict(list)
    for participant, time_s in pairs:
        grouped[participant].append(time_s)
    return {participant: np.sort(times) for participant, times in grouped.items()}


@cache
def go_times() -> dict[str, Array]:
    """Successful go reactions above 0.1 s of 257 people (six anticipations of 2 to 65 ms are left out)."""
    rows = _rows("stop_signal_ds000030_events.tsv.gz")
    go = [
        (r["participant_id"], float(r["ReactionTime"])) for r in rows if r["TrialOutcome"] == "SuccessfulGo"
    ]
    return _by_participant([(p, t) for p, t in go if t > 0.1])


@cache
def flanker_times() -> dict[str, Array]:
    """Correct flanker reactions of 26 people."""
    rows = _rows("flanker_ds000102_events.tsv.gz")
    return _by_participant(
        [(r["participant_id"], float(r["response_time"])) for r in rows if r["correctness"] == "correct"]
    )
