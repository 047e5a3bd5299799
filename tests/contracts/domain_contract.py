"""The contract of a domain, written once: a test class that gets a domain inherits all of it."""

import math
from typing import Any

import numpy as np
import pytest

from core.domain import Domain
from core.numerics.streams import stream

MAX_STEPS = 5000


class DomainContract:
    """Inherit, and give the fixtures `domain` and, where episodes are long, `long_enough`."""

    @pytest.fixture
    def domain(self) -> Domain[Any]:
        raise NotImplementedError("the test class gives its domain")

    def random_episode(
        self, domain: Domain[Any], seed: int, *, policy_seed: int = 0
    ) -> list[tuple[Any, int]]:
        """Play at random; return states and actions, the terminal state last with action -1."""
        rng = stream(policy_seed, "random policy", seed)
        state = domain.initial(seed)
        trajectory = []
        while not domain.terminal(state) and len(trajectory) < MAX_STEPS:
            n_actions = len(domain.choices(state).ruled_out)
            action = int(rng.integers(n_actions))
            trajectory.append((state, action))
            state = domain.transition(state, action).next_state
        return [*trajectory, (state, -1)]

    def test_the_same_seed_gives_the_same_episode(self, domain):
        assert self.random_episode(domain, 3) == self.random_episode(domain, 3)

    def test_another_seed_gives_another_episode(self, domain):
        assert self.random_episode(domain, 3) != self.random_episode(domain, 4)

    def test_random_play_ends(self, domain):
        assert len(self.random_episode(domain, 5)) <= MAX_STEPS
        assert domain.terminal(self.random_episode(domain, 5)[-1][0])

    def test_a_transition_leaves_the_old_state_as_it_was(self, domain):
        # An episode may end before any decision: keepers who do not see all only hold.
        starts = (domain.initial(seed) for seed in range(7, 27))
        state = next(start for start in starts if not domain.terminal(start))
        before = repr(state)
        for action in range(len(domain.choices(state).ruled_out)):
            domain.transition(state, action)
        assert repr(state) == before

    def test_every_listed_action_can_be_taken_and_described(self, domain):
        for state, _ in self.random_episode(domain, 11)[:-1]:
            for action in range(len(domain.choices(state).ruled_out)):
                assert np.isfinite(domain.transition(state, action).reward)
                assert all(isinstance(n, int) for n in domain.action_record(state, action).plain().values())

    def test_what_is_recorded_of_a_state_is_nothing_or_finite_numbers(self, domain):
        for state, _ in self.random_episode(domain, 11)[:-1]:
            recorded = domain.recorded_state(state)
            assert recorded is None or np.isfinite(recorded).all()

    def test_an_action_that_is_not_listed_is_refused(self, domain):
        state = domain.initial(1)
        for action in (-1, len(domain.choices(state).ruled_out)):
            with pytest.raises(ValueError, match=f"no action {action}"):
                domain.transition(state, action)

    def test_features_are_finite_and_have_the_shape_their_names_say(self, domain):
        for state, _ in self.random_episode(domain, 13)[:-1]:
            choices = domain.choices(state)
            n_actions = len(choices.ruled_out)
            assert choices.features.shape == (n_actions, len(domain.feature_names))
            assert choices.feedback_features.shape == (n_actions, len(domain.feedback_feature_names))
            assert choices.observation.shape == (len(domain.observation_names),)
            assert bool(domain.feature_names) != bool(domain.observation_names)
            assert np.isfinite(choices.features).all()
            assert np.isfinite(choices.observation).all()
            assert np.isfinite(choices.feedback_features).all()

    def test_time_goes_on_by_the_durations_and_choices_say_when(self, domain):
        episode = self.random_episode(domain, 17)
        assert domain.time(episode[0][0]) >= 0
        for state, action in episode[:-1]:
            transition = domain.transition(state, action)
            assert transition.duration >= 0
            assert domain.time(transition.next_state) == domain.time(state) + transition.duration
            assert domain.choices(state).time == domain.time(state)
        assert domain.time(episode[-1][0]) > domain.time(episode[0][0])

    def test_performance_is_finite(self, domain):
        assert all(math.isfinite(domain.performance(state)) for state, _ in self.random_episode(domain, 17))

    def test_a_terminal_state_has_no_choices(self, domain):
        end = self.random_episode(domain, 19)[-1][0]
        with pytest.raises(ValueError, match=r"terminal|at least one action"):
            domain.choices(end)

    def test_performance_grows_by_the_rewards(self, domain):
        for seed in range(3):
            total = domain.performance(domain.initial(seed))
            for state, action in self.random_episode(domain, seed)[:-1]:
                transition = domain.transition(state, action)
                total += transition.reward
                assert domain.performance(transition.next_state) == pytest.approx(total)

    def test_looking_and_acting_twice_gives_the_same_twice(self, domain):
        for state, action in self.random_episode(domain, 5)[:-1]:
            one, other = domain.choices(state), domain.choices(state)
            np.testing.assert_array_equal(one.features, other.features)
            np.testing.assert_array_equal(one.feedback_features, other.feedback_features)
            np.testing.assert_array_equal(one.ruled_out, other.ruled_out)
            assert domain.transition(state, action) == domain.transition(state, action)

    def test_two_episodes_side_by_side_do_not_disturb_each_other(self, domain):
        alone = self.random_episode(domain, 1)
        state, other = domain.initial(1), domain.initial(2)
        for expected, action in alone[:-1]:
            assert state == expected
            state = domain.transition(state, action).next_state
            if not domain.terminal(other):
                other = domain.transition(other, 0).next_state
        assert state == alone[-1][0]
