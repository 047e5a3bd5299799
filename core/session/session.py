"""A session: watched episodes, and unseen ones between them, in one deterministic order.

Everything that is not in its inputs follows from the protocol and the root seed, so a recording replays
exactly.
"""

from collections.abc import Callable, Iterator
from typing import Any

from core.combination.agent import ArlAgent, EpisodePolicy
from core.domain import Domain
from core.events import Output, SessionEnded, StepTaken, UnseenPlayed
from core.numerics.clock import Clock
from core.numerics.finite import check_numbers
from core.numerics.streams import stream_seed
from core.registry import Player, game_of
from core.session.protocol import Protocol, SessionConfig
from core.session.rollout import Agent, EpisodePlan, FeedbackIntake, FeedbackSource, Played, play_episode


class Session:
    """Runs the episodes of one session; a generator of outputs, fed through a `FeedbackSource`."""

    def __init__(
        self, domain: Domain[Any], agent: Agent, player: Player, config: SessionConfig, *, root_seed: int
    ) -> None:
        self.domain = domain
        self.agent = agent
        self.config = config
        self._player = player
        self._root_seed = root_seed
        self._next_step = 0
        self.before_unseen: Callable[[], None] = lambda: None
        """Called before each block of unseen episodes: the caller may wait there for compiled
        code."""
        self.after_unseen: Callable[[int, int], None] = lambda done, count: None
        """Called after each unseen episode with how many of this block are done, and how many it has."""

    def run(self, feedback: FeedbackSource, clock: Clock) -> Iterator[Output]:
        """Yield the session's outputs.

        The consumer sets the pace: after a `StepTaken` it shows the step, after an `EpisodeEnded` the final
        board, and comes back for more when that has been on screen for long enough.

        Raises:
            DivergedError: the agent's numbers have overflowed; what was yielded before can be recorded.
        """
        for output in self._outputs(feedback, clock):
            check_numbers(output)
            yield output

    def _outputs(self, feedback: FeedbackSource, clock: Clock) -> Iterator[Output]:
        intake = FeedbackIntake(self.agent, feedback)
        for watched in range(self.config.episodes):
            unseen = self.config.unseen_between if watched else self.config.unseen_before
            if unseen:
                yield self._play_unseen(unseen, intake, clock)
                yield from intake.attend(-1)
            if intake.stop_asked is None:
                yield from self._play_watched(intake, clock)
            if intake.stop_asked is not None:
                break
        now_ns = clock.now_ns()
        self.agent.finish(now_ns)
        yield SessionEnded(
            time_ns=now_ns,
            inputs=intake.inputs,
            reason="finished" if intake.stop_asked is None else intake.stop_asked.reason,
            weights=self.agent.export(),
            digest=self.agent.digest(),
        )

    def _play_watched(self, intake: FeedbackIntake, clock: Clock) -> Iterator[Output]:
        policy = self.agent.begin_episode(exploring=self.config.watched == "proposed", watched=True)
        plan = EpisodePlan(
            episode_seed=stream_seed(self._root_seed, "episode", policy.episode),
            policy=policy,
            first_step=self._next_step,
            max_steps=self.config.watched_steps,
        )
        for output in play_episode(self.domain, self.agent, intake, clock, plan):
            if isinstance(output, StepTaken):
                self._next_step = output.step + 1
            yield output

    def _play_unseen(self, count: int, intake: FeedbackIntake, clock: Clock) -> UnseenPlayed:
        self.before_unseen()
        policies: list[EpisodePolicy] = []
        outcomes: list[Played] = []
        for _ in range(count):
            policy = self.agent.begin_episode(exploring=True, watched=False)
            seed = stream_seed(self._root_seed, "episode", policy.episode)
            played = self._player(policy, seed, self.config.unseen_steps)
            self.agent.learn_from_domain(policy, played)
            policies.append(policy)
            outcomes.append(played)
            self.after_unseen(len(outcomes), count)
        return UnseenPlayed(
            first_episode=policies[0].episode,
            time_ns=clock.now_ns(),
            inputs=intake.inputs,
            policies=[policy.policy_id for policy in policies],
            performances=[played.performance for played in outcomes],
            steps=[played.steps for played in outcomes],
            agreed=[played.agreed for played in outcomes],
            agreed_worst=[played.agreed_worst for played in outcomes],
            trust=self.agent.trust,
            weights=[policy.episode_weights.w_h for policy in policies],
            digest=self.agent.digest(),
        )


def build_session(protocol: Protocol, root_seed: int) -> Session:
    """Return a new session: what it does follows from these two arguments and its inputs alone.

    Args:
        protocol: everything the experimenter decided.
        root_seed: >= 0; episodes, policies and all random choices follow from it.

    Raises:
        ValueError: the protocol asks for a participant's measured delay and nobody has put its numbers in.
    """
    if protocol.delay_of != "rule":
        raise ValueError(
            f"delay_of is {protocol.delay_of!r}: put the participant's delay into agent.credit.delay and set "
            "delay_of to 'rule' (`arl play` does both)"
        )
    game = game_of(protocol)
    agent = game.agent(protocol, root_seed)
    return Session(
        game.domain(protocol), agent, game.player(protocol, agent), protocol.session, root_seed=root_seed
    )


def build_agent(protocol: Protocol, root_seed: int) -> ArlAgent:
    """Return a new agent that has learned nothing."""
    return game_of(protocol).agent(protocol, root_seed)
