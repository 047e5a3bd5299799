"""Sessions beside each other: performance, presses, agreement, consistency, delay, trust and weight."""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from core.numerics.arrays import Floats
from core.numerics.clock import NS_PER_S
from core.numerics.streams import stream
from core.recording.reader import RecordingError, read_recording
from core.recording.schema import Header
from core.session.what_if import replay_human_model, watched_steps
from studies.session_view.session import SessionView, open_session
from studies.statistics import Interval, mean_interval, paired_difference

By = Literal["participant", "condition", "protocol"]

MEASURES: Final = {
    "performance": "performance per game",
    "presses": "presses per game",
    "praise": "fraction of praise",
    "agreement": "agreement with the learned policy",
    "match": "match of both sides",
    "consistency": "consistency",
    "delay_s": "delay of presses (s)",
    "trust": "trust",
    "weight": "weight in use",
}
"""Figures of a session by name, and how they are headed."""


@dataclass(frozen=True, slots=True, eq=False)
class SessionFigures:
    """One session in figures. What is not known is NaN. Arrays have an entry per game."""

    file: str
    participant: str
    condition: str
    protocol: str
    game: str
    origin: str
    """Who pressed: live, simulated, or imported."""
    performances: Floats
    """Of games that came to an end; NaN for one that did not."""
    steps: Floats
    good: Floats
    """Presses for good that counted."""
    bad: Floats
    match: Floats
    """Fraction of steps at which environment and human policy would have done the same, in [0, 1]."""
    trust: Floats
    """What the rule of trust said after each game."""
    weight: Floats
    """Weight w_h that the scheme used in each game."""
    taken_back: int
    refused: int
    agreement: float
    """Share of the presses' credit that says what the learned policy says, in [0, 1]: praise for what the
    environment's side would have done itself, blame for anything else."""
    consistency: float
    """Standard errors by which a model foresaw the presses better than chance
    (`core.learners.consistency`)."""
    delay_s: float
    """Median time from when a step came on screen to the press, seconds."""
    own_delay_s: float
    """Mean of the participant's measured delay of judging (`arl calibrate`), seconds."""

    def value(self, measure: str) -> float:
        """Return a figure of MEASURES for the whole session; NaN where there is none."""
        match measure:
            case "performance":
                return _mean(self.performances)
            case "presses":
                return _mean(self.good + self.bad)
            case "praise":
                presses = float(np.sum(self.good + self.bad))
                return float(np.sum(self.good)) / presses if presses else math.nan
            case "match" | "trust" | "weight":
                return _mean(getattr(self, measure))
            case _:
                return float(getattr(self, measure))

    def group(self, by: By) -> str:
        """Return the group that the session belongs to."""
        return str(getattr(self, by)) or "(none)"


@dataclass(frozen=True, slots=True)
class Difference:
    """How a group differs from the first one in one measure."""

    group: str
    control: str
    measure: str
    pairs: int
    paired_by: str
    """What pairs have in common: participant, or game number."""
    interval: Interval | None
    """Mean of group less control over pairs; None where there are no pairs."""


class NothingToCompareError(Exception):
    """A recording holds no games."""


def _condition(header: Header) -> str:
    """Return the condition: that of a study, of an import, or of the protocol; "" where there is none."""
    of_import = header.source.get("condition", header.protocol.get("condition", ""))
    return str(header.study.get("condition", of_import))


def figures_of(path: Path, *, own_delay_s: float = math.nan) -> SessionFigures:
    """Return a session in figures.

    Args:
        path: the recording.
        own_delay_s: mean of its participant's measured delay; NaN where there is none.

    Raises:
        RecordingError: the recording is damaged.
        OSError: it cannot be read.
        NothingToCompareError: it holds evaluations without their games.
        ValueError: its protocol cannot be used.
    """
    session = open_session(path)
    header, games = session.index.header, session.games
    if header.origin == "imported" and "domain" not in header.protocol:
        raise NothingToCompareError(
            f"{path}: imported evaluations without their games: there is nothing to compare. `arl presses` "
            "reports presses and delays, `arl fit` fits the delays"
        )
    protocol = header.protocol
    counted = (session.presses["verdict"] == 0) & ~np.isin(
        session.presses["number"], sorted(session.taken_back)
    )
    value, times = session.presses["value"], session.presses["time"]
    after = (
        np.append(games["start"][1:], np.iinfo(np.int64).max) if len(games) else np.zeros(0, dtype=np.int64)
    )
    begin = games["start"].copy()
    if len(begin):
        begin[0] = np.iinfo(np.int64).min
    steps = np.where(games["n_steps"] > 0, games["n_steps"], np.nan)
    agreed = np.where((games["agreed"] >= 0) & ~np.isnan(steps), games["agreed"], np.nan)
    agreement, delay_s = _of_presses(session, counted)
    return SessionFigures(
        file=path.name,
        participant=header.participant,
        condition=_condition(header),
        protocol=str(protocol.get("name", "")),
        game=session.protocol.game if session.protocol is not None else "",
        origin=header.origin,
        performances=np.asarray(games["performance"], dtype=np.float64),
        steps=steps,
        good=_per_game(times[counted & (value > 0)], begin, after),
        bad=_per_game(times[counted & (value < 0)], begin, after),
        match=agreed / steps if not session.imported else np.full(len(games), np.nan),
        trust=np.asarray(games["trust_after"], dtype=np.float64),
        weight=np.asarray(games["weight"], dtype=np.float64),
        taken_back=int(((session.presses["verdict"] == 0) & ~counted).sum()),
        refused=int(((session.presses["verdict"] != 0) & ~np.isnan(value)).sum()),
        agreement=agreement,
        consistency=_consistency(session, path),
        delay_s=delay_s,
        own_delay_s=own_delay_s,
    )


def _per_game(times: NDArray[np.int64], begin: NDArray[np.int64], end: NDArray[np.int64]) -> Floats:
    ordered = np.sort(times)
    return np.asarray(np.searchsorted(ordered, end) - np.searchsorted(ordered, begin), dtype=np.float64)


def _of_presses(session: SessionView, counted: NDArray[np.bool_]) -> tuple[float, float]:
    """Return how far the presses agree with the environment's side, and their median delay in seconds."""
    agreeing = total = 0.0
    delays: list[float] = []
    for row in np.flatnonzero(counted).tolist():
        press = session.press_at(row)
        shown = session.step_row(press.step) if press.step >= 0 else -1
        if shown >= 0:
            delays.append((press.time_ns - int(session.steps["shown"][shown])) / NS_PER_S)
        given = session.credit_of(press.number)
        if given is None or session.imported:
            continue  # logs of other programs do not say what the agent chose between
        for number, share in zip(given.steps, given.shares, strict=True):
            step = session.steps[session.step_row(number)]
            own_choice = step["action"] == step["environment"]
            agreeing += share * (own_choice == (press.value > 0))
            total += share
    return (
        agreeing / total if total > 0 else math.nan,
        float(np.median(delays)) if delays else math.nan,
    )


def _consistency(session: SessionView, path: Path) -> float:
    """Return how far the presses follow from the steps they are about; NaN where states were not recorded."""
    protocol = session.protocol
    if protocol is None or not len(session.steps) or not len(session.presses):
        return math.nan
    recording = read_recording(session.index.path)
    try:
        steps = watched_steps(recording, protocol)
    except RecordingError:
        return math.nan  # the game plays otherwise now, and its states were not recorded
    return replay_human_model(recording, protocol, steps, count=lambda press: True).human.consistency


def _mean(values: Floats) -> float:
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else math.nan


def groups_of(sessions: Sequence[SessionFigures], by: By) -> dict[str, list[SessionFigures]]:
    """Return sessions by group, groups in the order in which they come."""
    found: dict[str, list[SessionFigures]] = defaultdict(list)
    for session in sessions:
        found[session.group(by)].append(session)
    return dict(found)


def group_interval(sessions: Sequence[SessionFigures], measure: str) -> Interval | None:
    """Return the mean of a measure over sessions with a 95 % bootstrap interval; None where it is not
    known.
    """
    values = [value for session in sessions if not math.isnan(value := session.value(measure))]
    return mean_interval(values, rng=stream(0, "compare", "bootstrap")) if values else None


def over_games(sessions: Sequence[SessionFigures], what: str) -> Floats:
    """Return the mean over sessions of a figure per game, shape (most games,); NaN where no session has that
    game.

    Args:
        sessions: of a group.
        what: "performances", "presses", "trust", "weight" or "match".
    """
    rows = [
        session.good + session.bad if what == "presses" else getattr(session, what) for session in sessions
    ]
    n = max((len(row) for row in rows), default=0)
    table = np.full((len(rows), n), np.nan)
    for place, row in enumerate(rows):
        table[place, : len(row)] = row
    known = ~np.isnan(table)
    sums = np.where(known, table, 0.0).sum(axis=0)
    return np.asarray(np.where(known.any(axis=0), sums / np.maximum(known.sum(axis=0), 1), np.nan))


def differences_of(groups: dict[str, list[SessionFigures]], by: By) -> Iterator[Difference]:
    """Yield how each group differs from the first one, with paired intervals.

    Groups of conditions or protocols are paired by participant: the means of those who are in both.
    Participants are paired by game number: the same game of both, for performance, presses, trust, weight and
    match.
    """
    (control, first), *others = groups.items()
    for name, sessions in others:
        for measure in MEASURES:
            if by == "participant":
                pairs = list(_pairs_of_games(sessions, first, measure))
            else:
                pairs = list(_pairs_of_participants(sessions, first, measure))
            if pairs or by != "participant":
                interval = None
                if pairs:
                    treated, against = zip(*pairs, strict=True)
                    interval = paired_difference(treated, against, rng=stream(0, "compare", "bootstrap"))
                what = "game number" if by == "participant" else "participant"
                yield Difference(name, control, measure, len(pairs), what, interval)


def _pairs_of_participants(
    treated: Sequence[SessionFigures], control: Sequence[SessionFigures], measure: str
) -> Iterator[tuple[float, float]]:
    def means(sessions: Sequence[SessionFigures]) -> dict[str, float]:
        values: dict[str, list[float]] = defaultdict(list)
        for session in sessions:
            if not math.isnan(value := session.value(measure)):
                values[session.participant].append(value)
        return {participant: float(np.mean(found)) for participant, found in values.items()}

    first, second = means(treated), means(control)
    for participant in first:
        if participant in second:
            yield first[participant], second[participant]


_PER_GAME: Final = {
    "performance": "performances",
    "presses": "presses",
    "match": "match",
    "trust": "trust",
    "weight": "weight",
}


def _pairs_of_games(
    treated: Sequence[SessionFigures], control: Sequence[SessionFigures], measure: str
) -> Iterator[tuple[float, float]]:
    if measure not in _PER_GAME:
        return
    first, second = over_games(treated, _PER_GAME[measure]), over_games(control, _PER_GAME[measure])
    for one, other in zip(first, second, strict=False):
        if not (math.isnan(one) or math.isnan(other)):
            yield float(one), float(other)


def game_rows(sessions: Sequence[SessionFigures], by: By) -> Iterator[dict[str, object]]:
    """Yield a row per game of every session, for a table in a file; what is not known is an empty field."""
    for session in sessions:
        for game in range(len(session.performances)):
            yield {
                "file": session.file,
                "participant": session.participant,
                "condition": session.condition,
                "protocol": session.protocol,
                "origin": session.origin,
                "group": session.group(by),
                "game_name": session.game,
                "game": game + 1,
                "performance": _field(session.performances[game]),
                "steps": _field(session.steps[game]),
                "good": int(session.good[game]),
                "bad": int(session.bad[game]),
                "match": _field(session.match[game]),
                "trust": _field(session.trust[game]),
                "weight": _field(session.weight[game]),
                "session_agreement": _field(session.agreement),
                "session_consistency": _field(session.consistency),
                "session_delay_s": _field(session.delay_s),
                "session_own_delay_s": _field(session.own_delay_s),
                "session_taken_back": session.taken_back,
                "session_refused": session.refused,
            }


def _field(value: float) -> object:
    return "" if math.isnan(value) else float(value)
