"""What recorded presses tell without any agent: values, delays, and bursts."""

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from core.events import Event, FrameShown, KeyPressed, PressRetracted
from core.numerics.clock import NS_PER_S
from core.recording.reader import Recording
from core.recording.schema import code_of

BURST_WITHIN_S = 0.5
"""Presses of the same sign within this time of the one before are one burst. TAMER's logs: 0.18 to 0.20 s
between the presses of a burst. (Our choice.)"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Press:
    """One accepted press that was not taken back."""

    participant: str
    file: str
    time_s: float
    """Since the recording's first event."""
    value: float
    delay_s: float | None
    """Since the event judged (imported evaluations), else since the step appeared; None if unknown."""
    burst: int
    """Number of the burst in its recording, from 0; a press alone is a burst of one."""


def presses_of(recording: Recording, *, burst_within_s: float = BURST_WITHIN_S) -> list[Press]:
    """Return the presses of a recording in the order of their times."""
    events = recording.events
    retracted = {event.press for event in events if isinstance(event, PressRetracted)}
    shown_ns, first_of_step_ns = _frames(events)
    begin_ns = min(_times_ns(events), default=0)
    presses: list[Press] = []
    lasts: dict[int, KeyPressed] = {}  # of each person: two who press at once make no burst
    bursts: dict[int, int] = {}
    burst = -1
    for event in events:
        if not isinstance(event, KeyPressed) or event.verdict != "accepted" or event.press in retracted:
            continue
        value = event.value or 0.0
        last = lasts.get(event.person)
        joined = last is not None and np.sign(last.value or 0.0) == np.sign(value)
        if last is None or not joined or event.time_ns - last.time_ns > burst_within_s * NS_PER_S:
            burst += 1
            bursts[event.person] = burst
        lasts[event.person] = event
        since = first_of_step_ns.get(event.step) if event.step >= 0 else shown_ns.get(event.frame)
        presses.append(
            Press(
                participant=code_of(recording.header, event.person),
                file=recording.path.name,
                time_s=(event.time_ns - begin_ns) / NS_PER_S,
                value=value,
                delay_s=None if since is None else (event.time_ns - since) / NS_PER_S,
                burst=bursts[event.person],
            )
        )
    return presses


def _frames(events: Iterable[Event]) -> tuple[dict[int, int], dict[int, int]]:
    """Return when each frame was shown, and when each step appeared."""
    shown: dict[int, int] = {}
    steps: dict[int, int] = {}
    for event in events:
        if isinstance(event, FrameShown):
            shown[event.frame] = event.flushed_ns
            steps.setdefault(event.step, event.flushed_ns)
    return shown, steps


def _times_ns(events: Iterable[Event]) -> list[int]:
    times = []
    for event in events:
        if isinstance(event, FrameShown):
            times.append(event.flushed_ns)
        elif isinstance(event, KeyPressed):
            times.append(event.time_ns)
    return times


def report_lines(presses: Sequence[Press], *, delays_of_what: str) -> list[str]:
    """Return a report of one group of presses, in lines of text.

    Args:
        presses: of one or several recordings, each recording's in order.
        delays_of_what: what delays are measured from, for the heading.
    """
    if not presses:
        return ["no accepted presses"]
    bursts: dict[tuple[str, str, int], list[Press]] = {}
    for press in presses:
        bursts.setdefault((press.participant, press.file, press.burst), []).append(press)
    sizes = np.array([len(burst) for burst in bursts.values()])
    gaps = np.array([b.time_s - a.time_s for burst in bursts.values() for a, b in itertools.pairwise(burst)])
    lines = [
        f"{len(presses)} presses in {len(bursts)} bursts ({(sizes > 1).sum()} of more than one press"
        + (f", {np.median(gaps):.2f} s between their presses)" if gaps.size else ")"),
        (
            f"{'value':>7}{'presses':>9}{'part':>7}   delay {delays_of_what} (s): 5 %   25 %   50 %   75 %  "
            " 95 %"
        ),
    ]
    for value in sorted({press.value for press in presses}):
        some = [press for press in presses if press.value == value]
        lines.append(
            f"{value:>+7g}{len(some):>9}{len(some) / len(presses):>7.0%}  "
            f" {'':<{len(delays_of_what)}}{_quantiles(some)}"
        )
    lines.append(f"{'all':>7}{len(presses):>9}{1:>7.0%}   {'':<{len(delays_of_what)}}{_quantiles(presses)}")
    return lines


def _quantiles(presses: Sequence[Press]) -> str:
    delays = [press.delay_s for press in presses if press.delay_s is not None]
    if not delays:
        return f"{'not known':>23}"
    cells = "".join(f"{x:>7.2f}" for x in np.quantile(delays, (0.05, 0.25, 0.5, 0.75, 0.95)))
    return " " * 9 + cells
