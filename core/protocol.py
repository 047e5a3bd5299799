"""What an experimenter decides about a session, in one TOML file. No compiled code is imported.

Every field has a default, and every default names its source, so an empty file is a protocol. The whole protocol
is written to each recording's header, and a session is built from that alone (`core.session.build_session`).
"""

import tomllib
from pathlib import Path
from typing import Literal

import msgspec

from core.combination.config import AgentConfig
from core.feedback.config import TrainerConfig
from core.feedback.delays import GammaDelay, describe
from core.keys import KeyConfig
from core.learners.cross_entropy_config import CrossEntropyConfig
from core.tetris.config import TetrisConfig


class SessionConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many episodes there are, who sees them, and how long they may last."""

    episodes: int = 10
    """Watched episodes."""
    unseen_before: int = 0
    """Unseen episodes before the first watched one: 0 shows the agent as it begins."""
    unseen_between: int = 100
    """Unseen episodes between two watched ones; 100 are one iteration of the cross-entropy method."""
    watched: Literal["top", "proposed"] = "top"
    """What is watched: one of the top policies, drawn by performance and match, or the learner's next proposal, so
    that watched episodes are the learner's own (`docs/decisions/watched-and-unseen-episodes.md`)."""
    watched_steps: int = 60
    """A watched episode is truncated after this many steps (a good policy would play for hours)."""
    unseen_steps: int = 5000
    """An unseen episode is truncated after this many steps."""

    def __post_init__(self) -> None:
        for name in ("episodes", "watched_steps", "unseen_steps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} is >= 1, got {getattr(self, name)}")
        for name in ("unseen_before", "unseen_between"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} is >= 0, got {getattr(self, name)}")


class ScreenConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the session looks and how fast it goes."""

    tick_ms: int = 80
    """Time per primitive action and per row of gravity, in milliseconds (TAMER's demo: 150)."""
    pause_between_episodes_s: float = 2.0
    """How long the final board of an episode stays, in seconds."""
    palette: Literal["standard", "colour-blind", "high-contrast", "sixteen"] = "standard"
    """Colours of the pieces; each piece has its own texture, too, outside the standard palette."""

    def __post_init__(self) -> None:
        if not 10 <= self.tick_ms <= 2000:
            raise ValueError(f"tick_ms is 10..2000 milliseconds, got {self.tick_ms}")
        if not 0.0 <= self.pause_between_episodes_s <= 60.0:
            raise ValueError(
                f"pause_between_episodes_s is 0..60 seconds, got {self.pause_between_episodes_s}"
            )


DelayOf = Literal["rule", "feedback-lag", "simple", "pooled", "paper"]
"""Whose delay gives credit: as written in the protocol, or of whoever takes part (see `Protocol.delay_of`)."""


class Protocol(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A session, completely."""

    name: str = "default"
    """What the experimenter calls it."""
    domain: TetrisConfig = TetrisConfig(placements="reachable")
    """Board and rules. What is shown must be what the paper's four actions can do, hence "reachable"."""
    learner: CrossEntropyConfig = CrossEntropyConfig()
    agent: AgentConfig = AgentConfig()
    delay_of: DelayOf = "rule"
    """Credit by `agent.credit.delay` ("rule"), by the participant's own measured delay of judging ("feedback-lag"), of
    reacting ("simple"), of judging pooled with others ("pooled"), or by the paper's density ("paper"). All but "rule"
    are replaced by "rule" and its numbers when a session starts, so that a recording needs no other file."""
    keys: KeyConfig = KeyConfig()
    session: SessionConfig = SessionConfig()
    screen: ScreenConfig = ScreenConfig()
    trainer: TrainerConfig = TrainerConfig()
    """The simulated participant of demonstrations and of simulated sessions."""

    def departures(self) -> list[str]:
        """Return, in plain sentences, where this protocol does otherwise than the paper, or fills its silence."""
        credit, trust = self.agent.credit, self.agent.bootstrap.trust
        session = self.session
        found = [
            "R and H are standardised over the actions of each decision (the paper does not say how they are scaled)",
            f"watched episodes stop after {session.watched_steps} steps, unseen ones after {session.unseen_steps}",
            "the symmetric update is made explicit: top policies are drawn by performance and match",
        ]
        if not (isinstance(credit.delay, GammaDelay) and credit.delay == GammaDelay()):
            found.append(f"a press is credited by the rule {describe(credit.delay)}")
        else:
            found.append("gamma(2.5, 0.3) is read as shape and scale: mean 0.75 s, mode 0.45 s, not 0.5 s")
        found.append(f"w_h follows the rule {type(trust).__name__}")
        if self.domain.features != "bertsekas-21":
            found.append(f"the environment's learner sees the features {self.domain.features}")
        return found


class ProtocolError(ValueError):
    """A protocol file cannot be used; the message names file, place and reason."""


def load_protocol(path: Path | None) -> Protocol:
    """Return the protocol in a TOML file; the defaults for None.

    Raises:
        ProtocolError: the file is not TOML, or a field is unknown, of the wrong type or out of range.
        OSError: the file cannot be read.
    """
    if path is None:
        return Protocol()
    try:
        return msgspec.convert(tomllib.loads(path.read_text(encoding="utf-8")), Protocol)
    except tomllib.TOMLDecodeError as error:
        raise ProtocolError(f"{path}: not a TOML file: {error}") from error
    except (msgspec.ValidationError, ValueError) as error:
        raise ProtocolError(
            f"{path}: {error}. `arl protocol` prints a complete protocol to start from."
        ) from error
