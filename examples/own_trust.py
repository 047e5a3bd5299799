"""A rule of trust of your own, in a session that is recorded and replayed exactly.

    python examples/own_trust.py

The rule: trust is the plain mean agreement of all episodes so far. To use a rule in protocols, too, put its two classes
into a file in core/combination/trust/ and add its name to the union there (docs/extending.md).
"""  # noqa: E501

import tempfile
from pathlib import Path
from typing import ClassVar

import msgspec

from core import (
    AgentConfig,
    BootstrapConfig,
    Evidence,
    Needs,
    Protocol,
    SessionConfig,
    Trust,
    build_session,
    read_recording,
    replay_exactly,
)
from core.combination.ranking import EpisodeReport
from core.events import EpisodeEnded
from studies.demo import simulate_session


class MeanAgreement(msgspec.Struct, frozen=True, tag="mean-agreement"):
    """The settings of the rule: it has none."""

    needs: ClassVar[Needs] = Needs()

    def begin(self, *, root_seed: int) -> Trust:
        """Return trust of 0."""
        return _MeanAgreement()


class _MeanAgreement(Trust):
    """What the rule remembers of one participant."""

    def __init__(self) -> None:
        self._matches: list[float] = []

    def revise(self, report: EpisodeReport, evidence: Evidence) -> None:
        """Take in an episode; one without a human policy changes nothing."""
        if report.agreement is not None:
            self._matches.append(self.match(report.agreement))
            self.w_h = sum(self._matches) / len(self._matches)

    def state_bytes(self) -> bytes:
        """Return everything that decides about later trust: replays compare it."""
        return super().state_bytes() + repr(self._matches).encode()


def main() -> None:
    """Record a session under the rule, replay it, and print how trust went."""
    protocol = Protocol(
        session=SessionConfig(episodes=4, unseen_between=20, watched_steps=20, unseen_steps=100),
        agent=AgentConfig(bootstrap=BootstrapConfig(trust=MeanAgreement())),
    )
    path = Path(tempfile.mkdtemp()) / "session.jsonl"
    simulate_session(protocol, root_seed=1, target=path, software={})
    recording = read_recording(path)
    difference = replay_exactly(recording, build_session(protocol, 1)).difference
    trust = [event.trust for event in recording.outputs if isinstance(event, EpisodeEnded)]
    print(f"Replay: {'exact' if difference is None else difference}")
    print("Trust after each watched game:", ", ".join(f"{value:.2f}" for value in trust))


if __name__ == "__main__":
    main()
