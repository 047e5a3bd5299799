"""What an agent thought at each decision of a recorded session: R, H and f(R, H) of its best actions.

The values of a session's own agent come from the exact replay: the session is run again and every output is
compared with the recording. Those of a what-if, and of an imported log, come from an agent that learns from
the same steps and presses again (`core.session.what_if`).
"""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from core.combination.agent import ArlAgent, Decision, EpisodePolicy
from core.combination.episode_weights import EXPONENTIAL
from core.combination.preference import score, takes_control, terms_of
from core.domain import Choices
from core.recording.reader import Recording, read_recording
from core.registry import game_of
from core.session.protocol import Protocol
from core.session.protocol_reading import protocol_from
from core.session.replay import replay_exactly
from core.session.session import Session
from core.session.what_if import WatchedStep, relearn, watched_steps
from studies.session_view.thoughts import BEST, THOUGHT

FLUSH_EVERY: Final = 32
"""Decisions after which what has been written can be read by others."""


def combined_values(
    env_values: NDArray[np.float64],
    human_values: NDArray[np.float64],
    ruled_out: NDArray[np.bool_],
    policy: EpisodePolicy,
) -> NDArray[np.float64]:
    """Return f(R, H) of each action as `core.combination.preference.choose` compares them, shape (n,).

    -inf where an action is ruled out. Where one side has no weight, the other's values.
    """
    weights, n = policy.episode_weights, len(env_values)
    if weights.w_h == 0.0:
        combined = env_values.copy()
    elif weights.w_r == 0.0 and weights.form != EXPONENTIAL:
        combined = human_values * np.sign(weights.w_h)
    else:
        terms = terms_of(
            env_values, human_values, ruled_out, n, weights.form, weights.w_r, weights.w_h, False
        )
        combined = np.array([score(env_values[a], human_values[a], terms)[0] for a in range(n)])
    combined[ruled_out] = -np.inf
    return combined


def row_of(
    agent: ArlAgent, choices: Choices, policy: EpisodePolicy, decision: Decision, number: int
) -> NDArray[Any]:
    """Return a decision as a row of THOUGHT; right after the agent has made it.

    Args:
        agent: who decided.
        choices: between what.
        policy: of the episode.
        decision: what it decided.
        number: of the decision in its episode, from 0.
    """
    env_values, human_values = agent.last_values
    combined = combined_values(env_values, human_values, choices.ruled_out, policy)
    order = np.argsort(-combined, kind="stable")[:BEST].tolist()
    order += [
        action
        for action in dict.fromkeys((decision.action, decision.environment_action, decision.human_action))
        if action >= 0 and action not in order
    ]
    row = np.zeros(1, dtype=THOUGHT)
    known = decision.human_action >= 0
    facts = (
        ("n", len(env_values)),
        ("chosen", decision.action),
        ("environment", decision.environment_action),
        ("human", decision.human_action),
        ("policy", policy.policy_id),
        ("form", policy.episode_weights.form),
        ("handed", known and takes_control(policy.handover_seed, number, policy.episode_weights.handover)),
        ("known", known),
        ("trust", policy.trust),
        ("weight", policy.episode_weights.w_h),
        ("w_r", policy.episode_weights.w_r),
        ("handover", policy.episode_weights.handover),
    )
    for name, value in facts:
        row[name] = value
    row["action"] = -1
    kept = len(order)
    row["action"][0, :kept] = order
    row["r"][0, :kept] = env_values[order]
    row["h"][0, :kept] = human_values[order]
    row["f"][0, :kept] = combined[order]
    return row


class ThoughtWriter:
    """Writes decisions, one row after the other, to a file that others read meanwhile."""

    def __init__(self, path: Path) -> None:
        """Begin an empty file."""
        self._file = path.open("wb")
        self._n = 0

    def add(
        self, agent: ArlAgent, choices: Choices, policy: EpisodePolicy, decision: Decision, number: int
    ) -> None:
        """Append a decision; arguments as in `row_of`."""
        self._file.write(row_of(agent, choices, policy, decision, number).tobytes())
        self._n += 1
        if self._n % FLUSH_EVERY == 0:
            self._file.flush()

    def close(self) -> None:
        """Write what is left."""
        self._file.close()


class _Tapped:
    """An agent whose decisions are written down."""

    def __init__(self, agent: ArlAgent, writer: ThoughtWriter) -> None:
        self._agent = agent
        self._writer = writer

    def choose(self, choices: Choices, policy: EpisodePolicy, *, step: int) -> Decision:
        decision = self._agent.choose(choices, policy, step=step)
        self._writer.add(self._agent, choices, policy, decision, step)
        return decision

    def __getattr__(self, name: str) -> Any:
        return getattr(self._agent, name)


def own_thoughts(recording_path: Path, out: Path) -> str:
    """Write what a session's own agent thought; of an imported log, what an agent that learns from it thinks.

    Raises:
        RecordingError: the recording cannot be read, or its steps come out otherwise now.
        ValueError: its protocol cannot be used.
    """
    recording = read_recording(recording_path)
    protocol = protocol_from(recording.header.protocol)
    if recording.header.origin == "imported":
        _relearn(recording, protocol, out)
        return "imported: its agent cannot be run again; these are of one that learns from the same log"
    writer = ThoughtWriter(out)
    try:
        game = game_of(protocol)
        agent = game.agent(protocol, recording.header.root_seed)
        session = Session(
            game.domain(protocol),
            _Tapped(agent, writer),
            game.player(protocol, agent),
            protocol.session,
            root_seed=recording.header.root_seed,
        )
        result = replay_exactly(recording, session)
    finally:
        writer.close()
    if result.difference is not None:
        return f"not exact: {result.difference}. Values are right up to there, and none are shown behind"
    return f"exact replay: {result.outputs:,} outputs equal"


def what_if_thoughts(recording_path: Path, out: Path, protocol: Protocol) -> str:
    """Write what an agent thinks that learns from a recording under another protocol."""
    recording = read_recording(recording_path)
    _relearn(recording, protocol, out)
    return "learned again from the same steps and presses"


def _relearn(recording: Recording, protocol: Protocol, out: Path) -> None:
    writer = ThoughtWriter(out)

    def on_decision(
        agent: ArlAgent, watched: WatchedStep, policy: EpisodePolicy, decision: Decision, number: int
    ) -> None:
        writer.add(agent, watched.choices, policy, decision, number)

    try:
        relearn(
            recording,
            protocol,
            watched_steps(recording, protocol),
            root_seed=recording.header.root_seed,
            on_decision=on_decision,
        )
    finally:
        writer.close()
