"""A simulated session from start to end: played, recorded, replayed, summarised. What `arl demo` does without
a terminal.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from core.events import (
    EpisodeEnded,
    EpisodeStarted,
    Input,
    KeyPressed,
    Output,
    PressRetracted,
    UnseenPlayed,
)
from core.feedback.keys import PressGate
from core.feedback.source import ParticipantParts, SimulatedParticipant
from core.feedback.trainers import SimulatedTrainer
from core.numerics.clock import ManualClock, wall_time_utc
from core.numerics.streams import stream_seed
from core.recording.reader import Recording
from core.recording.recorder import LineWriter
from core.recording.schema import Header, to_plain
from core.registry import game_of
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.session import build_session


def simulate_session(
    protocol: Protocol,
    root_seed: int,
    target: Path,
    *,
    software: dict[str, str],
    participant: str = "simulated",
    source: Mapping[str, str] | None = None,
    study: Mapping[str, str] | None = None,
) -> Path:
    """Play a session with a simulated participant, as fast as the machine can, and record it.

    Where the session fails, what was recorded until then stays, without an end line.

    Args:
        protocol: of the session; `protocol.trainer` is the participant.
        root_seed: of the session.
        target: the recording to write; must not exist.
        software: versions for the header.
        participant: code for the header.
        source: where the credit rule comes from, for the header.
        study: where the session belongs in a study, for the header.
    """
    clock = ManualClock()
    session = build_session(protocol, root_seed)
    first, *others = simulated_people(protocol, root_seed)
    simulated = SimulatedParticipant[Any](
        session.domain,
        first.oracle,
        first.trainer,
        first.gate,
        clock,
        game_of(protocol).viewing(protocol),
        others=others,
        asking=protocol.agent.asking,
    )
    header = _header(protocol, root_seed, clock, participant=participant, software=software)
    header = msgspec.structs.replace(header, source=dict(source or {}), study=dict(study or {}))
    writer = LineWriter(target, header)
    _record(writer, session.run(simulated, clock), simulated.watch)
    return target


def _header(
    protocol: Protocol, root_seed: int, clock: ManualClock, *, participant: str, software: dict[str, str]
) -> Header:
    """Return the first line of the recording of a simulated session."""
    return Header(
        origin="simulated",
        created_utc=wall_time_utc(),
        clock="simulated",
        clock_resolution_ns=1,
        started_ns=clock.now_ns(),
        participant=participant,
        root_seed=root_seed,
        protocol=to_plain(protocol),
        software=software,
        departures=protocol.departures(),
        participants=protocol.participants,
    )


def _record(
    writer: LineWriter, outputs: Iterable[Output], watched: Callable[[Output], Iterable[Input]]
) -> None:
    """Record a session's outputs, and what its participant did at each; close the file however it ends."""
    try:
        for output in outputs:
            writer.write(output)
            for item in watched(output):
                writer.write(item)
    except BaseException:
        writer.abandon()
        raise
    writer.close()


def simulated_people(protocol: Protocol, root_seed: int) -> list[ParticipantParts[Any]]:
    """Return the simulated participants of a session, each with their gate: `trainer`, then `others`.

    Args:
        protocol: of the session; where it has `people`, those without an entry in `others` are as `trainer`.
        root_seed: of the session.
    """
    game, numbers = game_of(protocol), count()
    trainers = [protocol.trainer, *protocol.others]
    trainers += [protocol.trainer] * (protocol.n_participants - len(trainers))
    keys = protocol.keys_of_people if protocol.people else (protocol.keys,) * len(trainers)
    return [
        ParticipantParts(
            game.oracle(msgspec.structs.replace(protocol, trainer=trainer)),
            SimulatedTrainer(
                trainer,
                root_seed=stream_seed(root_seed, "person", person) if person else root_seed,
                graded=bool(own.graded),
            ),
            PressGate(own, person=person, numbers=numbers),
        )
        for person, (trainer, own) in enumerate(zip(trainers, keys, strict=True))
    ]


@dataclass(frozen=True, slots=True)
class SessionSummary:
    """What a participant or experimenter wants to know of a session at a glance."""

    game: str
    """Its name, as in `core.session.protocol.Protocol.game`."""
    episodes: int
    """Watched episodes."""
    unseen_episodes: int
    performances: tuple[float, ...]
    """Lines cleared, or seconds the ball was kept, in each watched episode."""
    unseen_means: tuple[float, ...]
    """Mean performance of the unseen episodes between two watched ones."""
    accepted: int
    """Presses that counted and were not taken back."""
    praised: int
    other_presses: int
    """Presses that did not count, for whatever reason."""
    trust: float
    """What the rule of trust said of the participant after the last watched episode."""
    weight: float
    """Weight w_h of the participant's values that the scheme used in the last watched episode."""
    complete: bool


def summarise(recording: Recording) -> SessionSummary:
    """Return the summary of a recording."""
    ended = [event for event in recording.outputs if isinstance(event, EpisodeEnded)]
    started = [event for event in recording.outputs if isinstance(event, EpisodeStarted)]
    unseen = [event for event in recording.outputs if isinstance(event, UnseenPlayed)]
    presses = [event for event in recording.inputs if isinstance(event, KeyPressed)]
    taken_back = {event.press for event in recording.inputs if isinstance(event, PressRetracted)}
    accepted = [press for press in presses if press.verdict == "accepted" and press.press not in taken_back]
    return SessionSummary(
        game=protocol_from(recording.header.protocol).game,
        episodes=len(ended),
        unseen_episodes=sum(len(block.policies) for block in unseen),
        performances=tuple(event.performance for event in ended),
        unseen_means=tuple(_mean(block.performances) for block in unseen),
        accepted=len(accepted),
        praised=sum(press.value is not None and press.value > 0 for press in accepted),
        other_presses=len(presses) - len(accepted),
        trust=ended[-1].trust if ended else 0.0,
        weight=started[-1].weight if started else 0.0,
        complete=recording.complete,
    )


def _mean(values: list[float]) -> float:
    array: NDArray[np.float64] = np.asarray(values)
    return float(array.mean())
