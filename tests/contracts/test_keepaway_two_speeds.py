"""Compiled Keepaway and the parts of a session, given the same episodes and the same presses, learn the
same."""

import numpy as np
import pytest

from core.combination.agent import ArlAgent
from core.combination.config import AgentConfig, BootstrapConfig, Equation4, Exponential, Linear, Tried
from core.combination.tally import EpisodeTally
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import CurrentStep, GammaDelay
from core.keepaway.arl_autoplay import ArlAutoplay, ArlKeepawayConfig
from core.keepaway.decisions import DecisionPlay
from core.keepaway.domain import Keepaway
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import CYCLE_NS, KeepawayConfig
from core.learners.human_config import TileModel
from core.learners.sarsa_config import SarsaConfig
from core.learners.sarsa_learner import SarsaLearner
from core.numerics.streams import stream
from core.session.rollout import Played

ROOT_SEED = 21
TASK = KeepawayConfig(exact_state=True)
PERSON = KeepawayPersonConfig(trainer=TrainerConfig(press_probability=0.5, max_presses=2))
AGENTS = {
    "linear, Eq. 4, gamma": AgentConfig(
        credit=CreditConfig(delay=GammaDelay()),
        bootstrap=BootstrapConfig(trust=Equation4()),
        scheme=Linear(),
        human_model=TileModel(),
    ),
    "exponential, tried, on screen, shared": AgentConfig(
        credit=CreditConfig(delay=CurrentStep()),
        bootstrap=BootstrapConfig(trust=Tried(consistent_above=0.0, minimum_episodes=2, better_by=0.5)),
        scheme=Exponential(),
        human_model=TileModel(shared=True),
    ),
}


def compiled(config, n_episodes):
    """Play episodes that begin as those of sessions do; return the game and what became of each episode."""
    game = ArlAutoplay(config, ROOT_SEED)
    episodes = []
    for episode in range(n_episodes):
        session = DecisionPlay(TASK, episode)
        for array, theirs in zip(game.match, session.match, strict=True):
            array[...] = theirs
        for rng, their_rng in zip(game.streams, session.streams, strict=True):
            rng.bit_generator.state = their_rng.bit_generator.state
        explore = stream(game._seed, "explore", episode)
        game.streams.policy.bit_generator.state = explore.bit_generator.state
        episodes.append(game.play_episode())
    return game, episodes


class StepByStep:
    """The loop of a session: the real domain and the real agent, presses at given times."""

    def __init__(self, config, presses, root_seed):
        self.domain = Keepaway(TASK, shared_feedback=config.agent.human_model.shared)
        learner = SarsaLearner(
            SarsaConfig(), self.domain.coder, n_learners=3, n_actions=3, reward_is_time=True
        )
        names = self.domain.feedback_feature_names
        tiles = self.domain.feedback_tiles
        self.agent = ArlAgent(
            learner, config.agent, n_feedback_features=len(names), root_seed=root_seed, feedback_tiles=tiles
        )
        self.learner, self.presses, self.made, self.steps = learner, presses, 0, 0
        self.pause_ns = round(config.pause_s * 1e9)

    def press_until(self, now_ns):
        while self.made < len(self.presses) and self.presses[self.made].time_ns <= now_ns:
            press = self.presses[self.made]
            self.agent.learn_from_press(self.made, press.time_ns, press.value)
            self.made += 1

    def play_episode(self, episode, start_ns):
        """Return (cycles, trust, end of the pause)."""
        domain, agent = self.domain, self.agent
        trust, policy = agent.trust, agent.begin_episode(exploring=True, watched=True)
        state, n = domain.initial(episode), 0
        tally = EpisodeTally()
        while not domain.terminal(state):
            now_ns = start_ns + state.cycle * CYCLE_NS
            self.press_until(now_ns)
            choices = domain.choices(state)
            decision = agent.choose(choices, policy, step=n)
            agent.step_shown(self.steps, choices.feedback_features[decision.action], now_ns)
            transition = domain.transition(state, decision.action)
            agent.learn_from_step(choices, decision.action, transition.reward)
            tally.add(decision)
            state, n, self.steps = transition.next_state, n + 1, self.steps + 1
        end_ns = start_ns + state.cycle * CYCLE_NS
        # Presses made while the last option was under way come before its end.
        self.press_until(end_ns - 1)
        agent.step_hidden(end_ns)
        agent.learn_from_domain(policy, self._played(state, n, tally.agreement))
        self.press_until(end_ns + self.pause_ns)
        return state.cycle, trust, end_ns + self.pause_ns

    def _played(self, state, steps, agreement):
        return Played(
            performance=self.domain.performance(state),
            steps=steps,
            agreed=agreement.agreed if agreement else 0,
            agreed_worst=agreement.agreed_worst if agreement else 0,
            ended="termination",
            time=state.cycle,
            agreement=agreement,
        )


@pytest.mark.jit
@pytest.mark.parametrize("name", AGENTS)
def test_compiled_play_and_the_parts_of_a_session_learn_the_same_from_the_same_presses(name):
    config = ArlKeepawayConfig(task=TASK, agent=AGENTS[name], person=PERSON)
    game, episodes = compiled(config, 12)
    presses = [press for episode in episodes for press in episode.presses if press.accepted]
    slow, now_ns = StepByStep(config, presses, game._seed), 0
    for number, episode in enumerate(episodes):
        assert episode.start_ns == now_ns
        cycles, trust, now_ns = slow.play_episode(number, now_ns)
        assert (cycles, trust) == (episode.cycles, episode.trust)
    assert slow.made == len(presses) > 8
    np.testing.assert_array_equal(game.sarsa.weights, slow.learner.sarsa.weights)
    np.testing.assert_allclose(game.human.weights.ravel(), slow.agent.human.weights, rtol=1e-9, atol=1e-15)
