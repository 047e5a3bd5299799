"""Turn the Tetris logs of Knox's TAMER program into our recordings.

The format, in our words (it is the program's own, written 2009-2015): line 1 is a parameter string; then one
line per step with eight fields separated by colons,

    cells and state : - : macro action : - : reward : [{value @ t}, ...] : training : step start

a blank line between episodes, and `finished` at the end. Three things must be put right:

* the reward of a row belongs to the action of the row before;
* the presses of a row were made during the step of the row before; those of a terminal row (`[]:[]:...`) are
  written a second time on the first row of the next episode, with the identical time;
* presses are not always in the order of their times.

The times are kept as they are, pauses included. Knox's agent chose among all placements it could steer a
piece to, so boards are recorded as they were seen (`StepTaken.observed`) rather than as our rules would make
them.
"""

import bisect
import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import msgspec

from core.combination.config import AgentConfig, HumanOnly
from core.events import EpisodeEnded, EpisodeStarted, Event, FrameShown, KeyPressed, SessionEnded, StepTaken
from core.feedback.credit import PreviousStep
from core.feedback.samples import CreditConfig
from core.learners.human_config import RidgeModel
from core.numerics.clock import NS_PER_S, wall_time_utc
from core.recording.importers.contract import Imported
from core.recording.importers.tamer_rows import COLUMNS, ROWS, Row, read_tamer_log
from core.recording.recorder import write_recording
from core.recording.schema import Header, to_plain
from core.session.protocol import Protocol, SessionConfig
from core.system.bounded_read import read_bounded
from core.system.foreign_text import printable
from core.tetris.action import PlacedPiece
from core.tetris.config import TetrisConfig

KEYS = {1.0: "/", -1.0: "z", 10.0: "?", -10.0: "Z"}
"""The keys that TAMER's Tetris gave to each feedback value."""


@dataclass(frozen=True, slots=True)
class ImportReport:
    """What was found and what was mended."""

    episodes: int
    placements: int
    presses: int
    duplicate_presses: int
    """Presses that were listed a second time and dropped."""
    out_of_order: int
    """Presses that stood behind a later one in the file."""
    longest_step_s: float
    """The longest time a step was on screen: a pause in the session shows here."""

    def lines(self) -> tuple[str, ...]:
        """Return the report in words."""
        return (
            f"{self.episodes} episodes, {self.placements} placements, {self.presses} presses",
            f"dropped: {self.duplicate_presses} presses that were listed twice",
            f"sorted: {self.out_of_order} presses that stood behind a later one",
            f"longest step: {self.longest_step_s:.1f} s (a pause of the session is kept as a long step)",
        )


def tamer_protocol() -> Protocol:
    """Return the agent that what-if replays let live through these logs, if not told otherwise.

    TAMER's features, credit and silence rule; the participant alone decides. The human model is least squares
    instead of TAMER's gradient descent, on the same raw inputs (`docs/decisions/replaying-tamer-logs.md`).
    """
    return Protocol(
        name="tamer-log",
        domain=TetrisConfig(rows=ROWS, columns=COLUMNS, feedback_features="tamer-46"),
        agent=AgentConfig(
            scheme=HumanOnly(),
            credit=CreditConfig(delay=PreviousStep(), scheme="aggregate", silence="zero-label"),
            human_model=RidgeModel(l2=50_000.0, intercept="free", standardise=False),
        ),
        session=SessionConfig(unseen_before=1000, unseen_between=10),
    )


def import_tamer_log(source: Path, target: Path, *, participant: str | None = None) -> ImportReport:
    """Write the recording of a TAMER Tetris log.

    Args:
        source: the log.
        target: the recording to write; must not exist.
        participant: pseudonym for the header; the file's stem where None.

    Raises:
        TamerLogError: a line cannot be understood (file, line number and reason).
        FileExistsError: there is a file at `target` already.
    """
    content = read_bounded(source)
    parameters, episodes = read_tamer_log(source)
    listed = [press for rows in episodes for row in rows for press in row.presses]
    header = Header(
        origin="imported",
        created_utc=wall_time_utc(),
        clock="seconds with an arbitrary zero, as logged",
        clock_resolution_ns=1000,
        started_ns=episodes[0][0].start_ns,
        participant=participant or printable(source.stem),
        root_seed=0,
        protocol=to_plain(tamer_protocol()),
        software={},
        departures=[
            "imported: times, boards and presses are those of the source; frames are its steps",
            "the board after the last placement of a game is not in the source",
        ],
        source={
            "format": "tamer-log",
            "file": printable(source.name),
            "sha256": hashlib.sha256(content).hexdigest(),
            "parameters": parameters,
        },
    )
    write_recording(target, header, _events(episodes))
    steps = [b.start_ns - a.start_ns for rows in episodes for a, b in itertools.pairwise(rows)]
    return ImportReport(
        episodes=len(episodes),
        placements=sum(not row.terminal for rows in episodes for row in rows),
        presses=len(set(listed)),
        duplicate_presses=len(listed) - len(set(listed)),
        out_of_order=sum(a > b for a, b in itertools.pairwise(listed)),
        longest_step_s=max(steps, default=0) / NS_PER_S,
    )


class TamerLog:
    """The importer of these logs (`core.recording.importers.contract`)."""

    name = "tamer-log"
    summary = "A log of TAMER's Tetris (Knox)."
    settings: Mapping[str, str] = {"participant": "pseudonym for the header; the log's name without it"}

    def run(self, source: Path, folder: Path, settings: Mapping[str, str]) -> Imported:
        """Write one recording, called as the log."""
        target = folder / f"{source.stem}.jsonl"
        report = import_tamer_log(source, target, participant=settings.get("participant"))
        return Imported(recordings=(target,), lines=report.lines())


IMPORTER = TamerLog()


def _events(episodes: list[list[Row]]) -> Iterator[Event]:
    """Yield the session's events, mended, in the order of their times."""
    events = [*_outputs(episodes), *_frames_and_presses(episodes)]
    # Ties: an episode begins before its step is decided, a step is decided before it is shown.
    events.sort(key=lambda pair: pair[0])
    inputs = 0
    for _, event in events:
        if isinstance(event, FrameShown | KeyPressed):
            inputs += 1
            yield event
        else:
            yield _with_inputs(event, inputs)
    last_ns = events[-1][0][0]
    yield SessionEnded(time_ns=last_ns, inputs=inputs, reason="end of the log", weights={}, digest="")


Keyed = tuple[tuple[int, int, int], Event]
"""An event with its place in the order: time, rank among equals, number."""


def _with_inputs(event: Event, inputs: int) -> Event:
    return msgspec.structs.replace(event, inputs=inputs)


def _outputs(episodes: list[list[Row]]) -> Iterator[Keyed]:
    step = 0
    for episode, rows in enumerate(episodes):
        start_ns = rows[0].start_ns
        yield (
            (start_ns, 2, episode),
            EpisodeStarted(
                episode=episode,
                time_ns=start_ns,
                inputs=0,
                episode_seed=0,
                policy=0,
                form=-1,
                w_r=0.0,
                # It acted by the human model alone: nothing was weighed.
                trust=1.0,
                weight=1.0,
                handover=0.0,
            ),
        )
        lines = 0
        n_steps = 0
        for row, following in zip(rows, [*rows[1:], None], strict=True):
            if row.terminal:
                continue
            reward = following.reward if following is not None else 0.0
            lines += _lines(reward)
            yield (row.start_ns, 3, step), _step(row, following, episode, step, reward)
            step += 1
            n_steps += 1
        yield (
            (rows[-1].start_ns, 1 if rows[-1].terminal else 9, episode),
            EpisodeEnded(
                episode=episode,
                time_ns=rows[-1].start_ns,
                inputs=0,
                performance=float(lines),
                steps=n_steps,
                ended="termination" if rows[-1].terminal else "truncation",
                agreed=0,
                agreed_worst=0,
                trust=1.0,
                digest="",
            ),
        )


def _lines(reward: float) -> int:
    """Return the lines behind TAMER's reward, 2^(n-1) for n >= 1 lines at once."""
    return int(math.log2(reward)) + 1 if reward > 0 else 0


def _step(row: Row, following: Row | None, episode: int, step: int, reward: float) -> StepTaken:
    observed = {"before": list(row.board)}
    if following is not None and not following.terminal:
        observed["after"] = list(following.board)
    return StepTaken(
        episode=episode,
        step=step,
        time_ns=row.start_ns,
        inputs=0,
        action=-1,
        environment_action=-1,
        human_action=-1,
        detail=PlacedPiece(row.piece).plain(),
        reward=reward,
        observed=observed,
    )


def _frames_and_presses(episodes: list[list[Row]]) -> Iterator[Keyed]:
    rows = [row for episode in episodes for row in episode]
    steps = itertools.accumulate(rows, lambda step, row: step + (not row.terminal), initial=-1)
    shown = [
        FrameShown(frame=frame, step=-1 if row.terminal else step, flushed_ns=row.start_ns)
        for frame, (row, step) in enumerate(zip(rows, itertools.islice(steps, 1, None), strict=True))
    ]
    for record in shown:
        yield (record.flushed_ns, 4, record.frame), record
    starts = [record.flushed_ns for record in shown]
    listed = {press for row in rows for press in row.presses}
    for number, (time_ns, value) in enumerate(sorted(listed)):
        frame = bisect.bisect_right(starts, time_ns) - 1
        yield (
            (time_ns, 5, number),
            KeyPressed(
                press=number,
                time_ns=time_ns,
                key=KEYS.get(value, f"{value:+g}"),
                value=value,
                frame=frame,
                step=shown[frame].step if frame >= 0 else -1,
                verdict="accepted" if frame < 0 or rows[frame].training else "not-playing",
            ),
        )
