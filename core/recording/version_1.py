"""Recordings of version 1: read into today's events, and held against what a session of today says.

Version 1 called two quantities `w_h`: the weight that the scheme used, in `episode-started`; and what the
rule of trust said, in `episode-ended` and `unseen-played`. Version 2 has `weight` and `trust`. What version 1
did not record is None.
"""

from collections.abc import Mapping
from typing import Any, Literal

import msgspec

from core.events import EpisodeEnded, EpisodeStarted, Output, Record, SessionEnded, UnseenPlayed


class EpisodeStarted1(Record, frozen=True, kw_only=True, tag="episode-started", rename={"handover": "share"}):
    """`EpisodeStarted` as version 1 wrote it."""

    episode: int
    time_ns: int
    inputs: int
    episode_seed: int
    policy: int
    form: int
    w_r: float
    w_h: float
    """The weight in use."""
    handover: float

    def upgraded(self) -> EpisodeStarted:
        """Return today's event; what trust said then is not known."""
        fields = msgspec.structs.asdict(self)
        return EpisodeStarted(weight=fields.pop("w_h"), trust=None, **fields)


class EpisodeEnded1(Record, frozen=True, kw_only=True, tag="episode-ended"):
    """`EpisodeEnded` as version 1 wrote it."""

    episode: int
    time_ns: int
    inputs: int
    performance: float
    steps: int
    ended: Literal["termination", "truncation"]
    agreed: int
    agreed_worst: int
    w_h: float
    """What the rule of trust said."""
    digest: str

    def upgraded(self) -> EpisodeEnded:
        """Return today's event."""
        fields = msgspec.structs.asdict(self)
        return EpisodeEnded(trust=fields.pop("w_h"), **fields)


class UnseenPlayed1(Record, frozen=True, kw_only=True, tag="unseen-played"):
    """`UnseenPlayed` as version 1 wrote it."""

    first_episode: int
    time_ns: int
    inputs: int
    policies: list[int]
    performances: list[float]
    steps: list[int]
    agreed: list[int]
    agreed_worst: list[int]
    w_h: float
    """What the rule of trust said."""
    digest: str

    def upgraded(self) -> UnseenPlayed:
        """Return today's event; the weights in use are not known."""
        fields = msgspec.structs.asdict(self)
        return UnseenPlayed(trust=fields.pop("w_h"), weights=None, **fields)


class SessionEnded1(Record, frozen=True, kw_only=True, tag="session-ended"):
    """`SessionEnded` as version 1 wrote it."""

    time_ns: int
    inputs: int
    reason: str
    weights: dict[str, list[float]]
    """The trust in each source is called `w_h`."""
    digest: str

    def upgraded(self) -> SessionEnded:
        """Return today's event."""
        weights = {"trust" if name == "w_h" else name: vector for name, vector in self.weights.items()}
        return SessionEnded(
            time_ns=self.time_ns,
            inputs=self.inputs,
            reason=self.reason,
            weights=weights,
            digest=self.digest,
        )


Changed = EpisodeStarted1 | EpisodeEnded1 | UnseenPlayed1 | SessionEnded1
"""The events that version 2 writes otherwise; all others are the same in both versions."""

CHANGED_TAGS = frozenset({"episode-started", "episode-ended", "unseen-played", "session-ended"})

_ANNEALED = ("annealed", "action-biasing", "control-sharing", "reward-shaping")


def with_schedules(settings: Any) -> Any:
    """Return settings in plain JSON types with the schedules that they took for granted.

    A weight that fell, fell with every episode in version 1, unseen ones included; protocols and settings of
    experiments did not say so. Now they do: `per`.
    """
    if isinstance(settings, list):
        return [with_schedules(value) for value in settings]
    if not isinstance(settings, Mapping):
        return settings
    said = {name: with_schedules(value) for name, value in settings.items()}
    return {**said, "per": "episode"} if said.get("type") in _ANNEALED and "per" not in said else said


def as_far_as_recorded(recorded: Output, replayed: Output) -> Output:
    """Return a replayed output without what the recorded one cannot tell: files of its time did not hold
    it.
    """
    match recorded, replayed:
        case EpisodeStarted(trust=None), EpisodeStarted():
            return msgspec.structs.replace(replayed, trust=None, shaping=0.0, augmentation=0.0)
        case UnseenPlayed(weights=None), UnseenPlayed():
            return msgspec.structs.replace(replayed, weights=None)
        case EpisodeEnded(time=None), EpisodeEnded():
            return msgspec.structs.replace(replayed, time=None)
        case _:
            return replayed
