"""A session in which a participant watches every episode, played in compiled code between the moments that
matter.

A simulated participant speaks a few times per game. Whether they feel like it at a step is drawn in advance,
so everything between is one compiled call; what they say, how it is credited and what is learned from it is
done by the classes of a live session. The result is that of `core.session.session.Session` with a
`SimulatedParticipant`, bit for bit (tested), in a hundredth of the time.
"""

import heapq
import math
from dataclasses import dataclass, field

from core.combination.agent import ArlAgent
from core.combination.tally import AGREED, AGREED_WORST, Tally, agreement_of, new_tally
from core.events import KeyPressed
from core.feedback.delays import CurrentStep, PreviousStep
from core.feedback.keys import PressGate
from core.feedback.source import Oracle
from core.feedback.trainers import IntendedPress, SimulatedTrainer
from core.numerics.clock import NS_PER_MS, NS_PER_S
from core.numerics.streams import stream_seed
from core.session.protocol import Protocol
from core.session.rollout import Played
from core.tetris.afterstate import Tetris, TetrisState
from core.tetris.kept_game import KeptGame
from core.tetris.sessions import open_game, tetris_rules


@dataclass(frozen=True, slots=True)
class WatchedEpisode:
    """What came of one watched episode."""

    performance: float
    """Lines cleared."""
    steps: int
    """Pieces placed."""
    presses: int
    """Accepted presses during the episode and the pause after it."""
    weight: float
    """Weight w_h of the participant's values that the scheme used in this episode."""


@dataclass(slots=True, eq=False)
class _Showing:
    """The episode that is being watched."""

    game: KeptGame
    seed: int
    first_step: int
    """Number of its first step in the session."""
    began_ns: int
    next_unshown: int = 0
    """First step of the episode that the agent has not been shown."""
    tally: Tally = field(default_factory=new_tally)
    """Agreement in the decisions while there was a human policy."""
    presses: int = 0

    def state(self, step: int) -> tuple[TetrisState, int]:
        """Return the state before one of the last steps of the episode, and the action taken in it."""
        columns, action = self.game.kept(step)
        return TetrisState(columns, self.seed, step), action


class WatchedTetris:
    """Plays the watched episodes of a session in which the learner's own proposals are watched."""

    def __init__(
        self,
        protocol: Protocol,
        agent: ArlAgent,
        trainer: SimulatedTrainer,
        oracle: Oracle[TetrisState],
        *,
        root_seed: int,
        step_ns: int,
    ) -> None:
        """Sit down.

        Args:
            protocol: of the session; all placements are offered, `session.watched` is "proposed", no episode
                is unseen.
            agent: learns.
            trainer: watches and presses.
            oracle: by which the trainer judges.
            root_seed: of the session.
            step_ns: how long each step stays on screen, > 0.

        Raises:
            ValueError: the protocol asks for what is not there between the presses; says what.
        """
        _check(protocol)
        self._protocol = protocol
        self._rules = tetris_rules(protocol)
        self._domain = Tetris(self._rules)
        self.agent = agent
        self._trainer = trainer
        self._oracle = oracle
        self._root_seed = root_seed
        self._step_ns = step_ns
        self._pause_ns = round(protocol.screen.pause_between_episodes_s * 1000) * NS_PER_MS
        self._gate = PressGate(protocol.keys)
        self._reach = _steps_reached(protocol, step_ns)
        # With no step on screen, the rules that are no densities look at the last one alone.
        by_rule = isinstance(protocol.agent.credit.delay, PreviousStep | CurrentStep)
        self._reach_from_pause = 1 if by_rule else self._reach
        self._first_step = 0
        self._now_ns = 0
        # Presses to come; the counter keeps those of equal times in order.
        self._due: list[tuple[int, int, IntendedPress]] = []
        self._planned = 0

    def play(self) -> WatchedEpisode:
        """Play the next episode and the pause after it."""
        policy = self.agent.begin_episode(exploring=True, watched=True)
        seed = stream_seed(self._root_seed, "episode", policy.episode)
        game = open_game(self.agent, policy, seed, self._rules, window=self._reach + 1)
        showing = _Showing(game, seed, self._first_step, self._now_ns)
        self._trainer.watch_episode(policy.episode)
        self._gate.episode_started()
        self._play_out(showing)
        self.agent.learn_from_domain(
            policy,
            Played(
                performance=float(game.lines),
                steps=game.pieces,
                agreed=int(showing.tally[AGREED]),
                agreed_worst=int(showing.tally[AGREED_WORST]),
                ended="termination" if game.finished else "truncation",
                agreement=agreement_of(showing.tally),
            ),
        )
        self._pause(showing)
        self._first_step += game.pieces
        return WatchedEpisode(float(game.lines), game.pieces, showing.presses, policy.episode_weights.w_h)

    def finish(self) -> None:
        """End the session."""
        self.agent.finish(self._now_ns)

    def _play_out(self, showing: _Showing) -> None:
        """Play to the end of the game or the episode; stop where they feel like speaking, and where a press
        comes.
        """
        game, first, cap = showing.game, showing.first_step, self._protocol.session.watched_steps
        while not game.finished and game.pieces < cap:
            inclined = self._trainer.next_inclined(first + game.pieces, first + cap) - first
            step = min(inclined, self._step_of_next_press(showing), cap - 1)
            self._decide(showing, step + 1)
            if game.pieces <= step:
                return  # it ended before
            shown_ns = showing.began_ns + step * self._step_ns
            if step == inclined:
                self._watch(showing, step, shown_ns)
            self._gate.step = first + step
            if self._press_until(showing, shown_ns + self._step_ns):
                game.set_human_weights(self.agent.human.weights)

    def _decide(self, showing: _Showing, pieces: int) -> None:
        """Let the agent make its decisions until there are so many pieces, with the human model as it is."""
        game = showing.game
        before = game.tally.copy()
        game.advance(pieces)
        if self.agent.human.knows_something:
            showing.tally += game.tally - before

    def _step_of_next_press(self, showing: _Showing) -> int:
        """Return the step of this episode that will be on screen at the next press to come; a far one if none
        will.
        """
        if not self._due:
            return self._protocol.session.watched_steps
        since_ns = self._due[0][0] - showing.began_ns
        return max(showing.game.pieces, -(-since_ns // self._step_ns) - 1)

    def _watch(self, showing: _Showing, step: int, shown_ns: int) -> None:
        """Let the participant judge a step, and plan what they will press."""
        state, action = showing.state(step)
        for press in self._trainer.watch(
            showing.first_step + step,
            self._oracle(state),
            action,
            shown_ns=shown_ns,
            hidden_ns=shown_ns + self._step_ns,
        ):
            heapq.heappush(self._due, (press.time_ns, self._planned, press))
            self._planned += 1

    def _press_until(self, showing: _Showing, until_ns: int) -> bool:
        """Press what is due; return whether anything was."""
        pressed = False
        while self._due and self._due[0][0] <= until_ns:
            self._show_last_steps(showing, at_most=self._reach)
            time_ns, _, press = heapq.heappop(self._due)
            key = self._gate.config.good if press.value > 0 else self._gate.config.bad
            self._gate.wrong_asked = press.deliberate
            for item in self._gate.judge(key, time_ns, source="simulated"):
                if not isinstance(item, KeyPressed):
                    self.agent.retract(item.press)
                    showing.presses -= 1
                elif item.verdict == "accepted" and item.value is not None:
                    self.agent.learn_from_press(item.press, item.time_ns, item.value)
                    showing.presses += 1
            self._gate.wrong_asked = False
            pressed = True
        return pressed

    def _show_last_steps(self, showing: _Showing, *, at_most: int) -> None:
        """Tell the agent of those steps on screen until now that a press can still reach."""
        n_steps = showing.game.pieces
        first = max(showing.next_unshown, n_steps - at_most)
        if 0 < showing.next_unshown < first:
            # What comes between was on screen, too, but no press can reach it.
            self.agent.step_hidden(showing.began_ns + showing.next_unshown * self._step_ns)
        for step in range(first, n_steps):
            state, action = showing.state(step)
            features = self._domain.choices(state).feedback_features[action]
            self.agent.step_shown(
                showing.first_step + step, features, showing.began_ns + step * self._step_ns
            )
        showing.next_unshown = n_steps

    def _pause(self, showing: _Showing) -> None:
        """Show the final board: late presses on the last steps."""
        self._show_last_steps(showing, at_most=self._reach_from_pause)
        self._now_ns = showing.began_ns + showing.game.pieces * self._step_ns
        self.agent.step_hidden(self._now_ns)
        self._gate.step = -1
        self._now_ns += self._pause_ns
        self._press_until(showing, self._now_ns)


def _check(protocol: Protocol) -> None:
    """Refuse what would need every step, or decisions that are not kept."""
    for fine, wanted in (
        (tetris_rules(protocol).placements == "all", 'domain.placements = "all"'),
        (protocol.session.watched == "proposed", 'session.watched = "proposed"'),
        (
            protocol.session.unseen_before == protocol.session.unseen_between == 0,
            "no unseen episodes",
        ),
        (protocol.agent.credit.scheme == "individual", 'agent.credit.scheme = "individual"'),
        (
            protocol.agent.scheme.acts_on != "policy",
            "a scheme whose presses teach the human model, not the learner itself",
        ),
        (protocol.n_participants == 1, "one participant: no others, no people"),
        (protocol.agent.asking.per_episode == 0, "no questions: agent.asking.per_episode = 0"),
        (
            not protocol.agent.bootstrap.trust.needs.window,
            "a trust rule that needs no window of decisions (give it its chance level)",
        ),
    ):
        if not fine:
            raise ValueError(f"a session between whose presses compiled code plays needs {wanted}")


def _steps_reached(protocol: Protocol, step_ns: int) -> int:
    """Return how many of the last steps a press can be about, the one on screen included."""
    delay = protocol.agent.credit.delay
    if isinstance(delay, PreviousStep | CurrentStep):
        return 2
    return math.ceil((delay.horizon_s * NS_PER_S + 1) / step_ns) + 1
