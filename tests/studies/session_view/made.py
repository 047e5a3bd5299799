"""Recordings made for tests of the viewer: what a live session writes, and any sequence of events."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import msgspec

from core.events import (
    CreditGiven,
    EpisodeEnded,
    EpisodeStarted,
    Event,
    FocusLost,
    FocusRegained,
    FrameShown,
    KeyPressed,
    PressRetracted,
    Resumed,
    ScreenCleared,
    SessionEnded,
    StepTaken,
    TimeGap,
)
from core.recording.reader import read_recording
from core.recording.recorder import LineWriter
from core.recording.schema import Header, to_plain
from core.session.protocol import Protocol

REFERENCE = Path(__file__).resolve().parents[3] / "recordings" / "reference"
RECORDINGS = sorted([*REFERENCE.glob("*.jsonl"), *REFERENCE.glob("version-2/*.jsonl")])
TETRIS = REFERENCE / "version-2" / "tetris-linear-equation-4.jsonl"
KEEPAWAY = REFERENCE / "version-2" / "keepaway-exponential-equation-4.jsonl"
MS = 1_000_000


def write(
    path: Path, events: Iterable[Event], *, complete: bool = True, protocol: Protocol | None = None
) -> Path:
    """Write events under the header of a session of Tetris; left out, of the default protocol."""
    header = msgspec.structs.replace(
        read_recording(TETRIS).header, origin="live", protocol=to_plain(protocol or Protocol())
    )
    writer = LineWriter(path, header)
    for event in events:
        writer.append(event)
    if complete:
        writer.finish()
    writer.abandon()
    return path


def started(time_ns: int, episode: int = 0) -> EpisodeStarted:
    return EpisodeStarted(
        episode=episode,
        time_ns=time_ns,
        inputs=0,
        episode_seed=7,
        policy=0,
        form=0,
        w_r=1.0,
        trust=0.0,
        weight=0.25,
        handover=0.0,
    )


def taken(time_ns: int, step: int, column: int, episode: int = 0) -> StepTaken:
    return StepTaken(
        episode=episode, step=step, time_ns=time_ns, inputs=0, action=0, environment_action=0, human_action=-1,  # noqa: E501
        detail={"piece": 1, "orientation": 0, "column": column}, reward=0.0,
    )  # fmt: skip


def ended(time_ns: int, episode: int = 0) -> EpisodeEnded:
    return EpisodeEnded(
        episode=episode, time_ns=time_ns, inputs=0, performance=2.0, steps=2, ended="termination", agreed=1, agreed_worst=0,  # noqa: E501
        trust=0.5, digest="",
    )  # fmt: skip


def pressed(
    time_ns: int,
    press: int,
    step: int,
    value: float | None = 1.0,
    verdict: str = "accepted",
    *,
    key: str = "j",
    frame: int = 0,
) -> KeyPressed:
    return KeyPressed(
        press=press,
        time_ns=time_ns,
        key=key,
        value=value,
        frame=frame,
        step=step,
        verdict=verdict,  # type: ignore[arg-type]
    )


def live_events() -> list[Event]:
    """Return a game of two pieces with a pause within the first, a gap, lost focus, and presses of every
    kind.

    Frames every 80 ms; step 0 has frames 1-5, the pause lasts from 1,400 to 5,400 ms, step 1 begins at 6,000
    ms.
    """
    shown = [FrameShown(frame=1 + k, step=0, flushed_ns=(1000 + 80 * k) * MS) for k in range(5)]
    again = FrameShown(frame=6, step=0, flushed_ns=5410 * MS)
    rest = [FrameShown(frame=7 + k, step=0, flushed_ns=(5480 + 80 * k) * MS) for k in range(3)]
    second = [FrameShown(frame=10 + k, step=1, flushed_ns=(6000 + 80 * k) * MS) for k in range(8)]
    return [
        started(900 * MS),
        FrameShown(frame=0, step=-1, flushed_ns=950 * MS),
        taken(990 * MS, 0, 0),
        *shown,
        pressed(1380 * MS, 0, 0, frame=5),
        CreditGiven(press=0, steps=[0], shares=[0.75], before_first=0.25, in_gaps=0.0),
        ScreenCleared(time_ns=1400 * MS, reason="pause"),
        pressed(1500 * MS, 1, -1, verdict="covered", frame=-1),
        Resumed(time_ns=5400 * MS),
        again,
        *rest,
        taken(5990 * MS, 1, 4),
        *second,
        FocusLost(time_ns=6600 * MS),
        FocusRegained(time_ns=6700 * MS),
        pressed(6800 * MS, 2, 1, value=-1.0, key="f", frame=17),
        CreditGiven(press=2, steps=[0], shares=[1.0], before_first=0.0, in_gaps=0.0),
        pressed(6900 * MS, 3, 1, value=None, verdict="other", key="u", frame=17),
        PressRetracted(press=2, time_ns=6900 * MS, reason="participant"),
        TimeGap(last_ns=7000 * MS, time_ns=9000 * MS),
        ended(9500 * MS),
        FrameShown(frame=20, step=-1, flushed_ns=9510 * MS),
        SessionEnded(time_ns=10_000 * MS, inputs=0, reason="finished", weights={}, digest=""),
    ]


def large(path: Path, n_steps: int = 330_000) -> Path:
    """Write a recording of three events a step, a million by default, in games of 50 steps."""

    def events() -> Iterator[Event]:
        for step in range(n_steps):
            now = step * 1000 * MS
            if step % 50 == 0:
                yield started(now, step // 50)
            yield taken(now, step, step % 9, step // 50)
            yield FrameShown(frame=step, step=step, flushed_ns=now + MS)
            yield pressed(now + 500 * MS, step, step)
            if step % 50 == 49:
                yield ended(now + 900 * MS, step // 50)

    return write(path, events())


__all__ = ["KEEPAWAY", "MS", "RECORDINGS", "TETRIS", "Header", "large", "live_events", "write"]
