"""Domains, learners, human feedback, their combination, recording and replay. No screen, no printing.

What users import stands here; a name is loaded when it is asked for, because compiled code comes with some.
Modules may be imported by their own names, too, but what is not in `__all__` may change without notice.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from core.combination.agent import ArlAgent
    from core.combination.config import AgentConfig, BootstrapConfig
    from core.combination.trust.contract import Evidence, Needs, RecentEpisodes, Trust
    from core.domain import Choices, Domain, Transition
    from core.feedback.config import CreditConfig, TrainerConfig
    from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay
    from core.numerics.clock import ManualClock, MonotonicClock
    from core.numerics.streams import stream
    from core.recording.reader import Recording, read_recording
    from core.recording.recorder import Recorder
    from core.recording.schema import Header
    from core.recording.summary import RecordingSummary, summarise_recording
    from core.recording.undo import RecordingError
    from core.session.protocol import DEFAULTS, Protocol, ScreenConfig, SessionConfig
    from core.session.protocol_file import ProtocolError
    from core.session.protocol_reading import load_protocol, protocol_from
    from core.session.replay import Recorded, ReplayResult, replay_exactly
    from core.session.rollout import FeedbackSource, play_unseen
    from core.session.session import Session, build_session
    from core.session.what_if import Relearned, relearn, watched_steps

__all__ = [
    "DEFAULTS",
    "AgentConfig",
    "ArlAgent",
    "BootstrapConfig",
    "Choices",
    "CreditConfig",
    "CurrentStep",
    "Domain",
    "Evidence",
    "FeedbackSource",
    "GammaDelay",
    "Header",
    "ManualClock",
    "MonotonicClock",
    "Needs",
    "PreviousStep",
    "Protocol",
    "ProtocolError",
    "RecentEpisodes",
    "Recorded",
    "Recorder",
    "Recording",
    "RecordingError",
    "RecordingSummary",
    "Relearned",
    "ReplayResult",
    "ScreenConfig",
    "Session",
    "SessionConfig",
    "TrainerConfig",
    "Transition",
    "Trust",
    "UniformDelay",
    "build_session",
    "load_protocol",
    "play_unseen",
    "protocol_from",
    "read_recording",
    "relearn",
    "replay_exactly",
    "stream",
    "summarise_recording",
    "watched_steps",
]

_PLACES = {
    "AgentConfig": "core.combination.config",
    "ArlAgent": "core.combination.agent",
    "BootstrapConfig": "core.combination.config",
    "Choices": "core.domain",
    "CreditConfig": "core.feedback.config",
    "CurrentStep": "core.feedback.delays",
    "DEFAULTS": "core.session.protocol",
    "Domain": "core.domain",
    "Evidence": "core.combination.trust.contract",
    "FeedbackSource": "core.session.rollout",
    "GammaDelay": "core.feedback.delays",
    "Header": "core.recording.schema",
    "ManualClock": "core.numerics.clock",
    "MonotonicClock": "core.numerics.clock",
    "Needs": "core.combination.trust.contract",
    "PreviousStep": "core.feedback.delays",
    "Protocol": "core.session.protocol",
    "ProtocolError": "core.session.protocol_file",
    "RecentEpisodes": "core.combination.trust.contract",
    "Recorded": "core.session.replay",
    "Recorder": "core.recording.recorder",
    "Recording": "core.recording.reader",
    "RecordingError": "core.recording.undo",
    "RecordingSummary": "core.recording.summary",
    "Relearned": "core.session.what_if",
    "ReplayResult": "core.session.replay",
    "ScreenConfig": "core.session.protocol",
    "Session": "core.session.session",
    "SessionConfig": "core.session.protocol",
    "TrainerConfig": "core.feedback.config",
    "Transition": "core.domain",
    "Trust": "core.combination.trust.contract",
    "UniformDelay": "core.feedback.delays",
    "build_session": "core.session.session",
    "load_protocol": "core.session.protocol_reading",
    "play_unseen": "core.session.rollout",
    "protocol_from": "core.session.protocol_reading",
    "read_recording": "core.recording.reader",
    "relearn": "core.session.what_if",
    "replay_exactly": "core.session.replay",
    "stream": "core.numerics.streams",
    "summarise_recording": "core.recording.summary",
    "watched_steps": "core.session.what_if",
}


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it offers {', '.join(__all__)}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
