"""Late feedback in Keepaway: how a press is shared out among options, by hand, and who learns from it."""

import numpy as np
import pytest
from scipy.stats import gamma

from core.combination.human_learner import HumanLearner
from core.domain import Choices
from core.feedback.config import CreditConfig
from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from core.keepaway.domain import HOLD, Keepaway
from core.keepaway.pitch import KeepawayConfig
from core.learners.human_config import TileModel
from core.numerics.clock import NS_PER_S

EXACT = KeepawayConfig(exact_state=True)


def density_mass(low_s: float, high_s: float) -> float:
    """Mass of the paper's gamma(2.5, 0.3) between two delays."""
    return float(gamma.cdf(high_s, 2.5, scale=0.3) - gamma.cdf(low_s, 2.5, scale=0.3))


class Viewer:
    """Sees the decisions of one episode at given times."""

    def __init__(self, delay, *, shared: bool = False) -> None:
        self.domain = Keepaway(EXACT, shared_feedback=shared)
        self.state = self.domain.initial(1)
        self.human = HumanLearner(
            CreditConfig(delay=delay), TileModel(shared=shared), 13, tiles=self.domain.feedback_tiles
        )
        self.steps: list[tuple[Choices, int]] = []

    def see(self, at_s: float, action: int) -> None:
        """See an option begin."""
        choices = self.domain.choices(self.state)
        self.human.step_shown(len(self.steps), choices.feedback_features[action], round(at_s * NS_PER_S))
        self.steps.append((choices, action))
        self.state = self.domain.transition(self.state, action).next_state

    def end(self, at_s: float) -> None:
        """See the final picture."""
        self.human.step_hidden(round(at_s * NS_PER_S))

    def press(self, at_s: float, value: float = 1.0, number: int = 0):
        return self.human.learn_from_press(number, round(at_s * NS_PER_S), value)

    def opinion(self, step: int) -> list[float]:
        """H of each option in the state of a step."""
        return list(self.human.model.predict(self.steps[step][0].feedback_features))


def pass_between_two_keepers(viewer: Viewer) -> None:
    """Two holds of 100 ms, a pass of 900 ms, two holds by the one who caught it; the last goes on."""
    for at_s, action in [(0.0, HOLD), (0.1, HOLD), (0.2, 1), (1.1, HOLD), (1.2, HOLD)]:
        viewer.see(at_s, action)


def test_a_press_is_shared_out_by_the_density_over_the_time_each_option_was_on_screen():
    viewer = Viewer(GammaDelay())
    pass_between_two_keepers(viewer)
    given = viewer.press(1.25)
    # Step 4 was on screen from 0.05 s before the press, step 3 from 0.15 s to 0.05 s before it, and so on.
    by_hand = [
        density_mass(1.15, 1.25),
        density_mass(1.05, 1.15),
        density_mass(0.15, 1.05),  # the pass in flight: nearly all of it
        density_mass(0.05, 0.15),
        density_mass(0.0, 0.05),
    ]
    assert given.steps == [0, 1, 2, 3, 4]
    assert given.shares == pytest.approx(by_hand, abs=1e-6)
    assert given.before_first == pytest.approx(1.0 - sum(by_hand), abs=1e-6)
    assert given.shares[2] > 0.6


def test_without_the_density_all_goes_to_the_latest_decision():
    viewer = Viewer(CurrentStep())
    pass_between_two_keepers(viewer)
    assert (given := viewer.press(1.25)).steps == [4]
    assert given.shares == [1.0]
    other = Viewer(PreviousStep())
    pass_between_two_keepers(other)
    assert other.press(1.25).steps == [3]


def test_a_press_after_the_end_reaches_the_last_options():
    viewer = Viewer(GammaDelay())
    pass_between_two_keepers(viewer)
    viewer.end(1.3)
    given = viewer.press(1.8)
    by_hand = {
        4: density_mass(0.5, 0.6),
        3: density_mass(0.6, 0.7),
        2: density_mass(0.7, 1.6),
        1: density_mass(1.6, 1.7),
        0: density_mass(1.7, 1.8),
    }
    assert dict(zip(given.steps, given.shares, strict=True)) == pytest.approx(by_hand, abs=1e-6)
    assert given.in_gaps == pytest.approx(density_mass(0.0, 0.5), abs=1e-6)  # the final picture


def test_a_press_too_late_for_the_last_option_says_nothing_of_it():
    viewer = Viewer(UniformDelay(0.2, 0.8))
    pass_between_two_keepers(viewer)
    viewer.end(1.3)
    given = viewer.press(2.2)
    assert (given.steps, given.in_gaps) == ([], 1.0)
    assert not viewer.human.knows_something


def test_every_keeper_who_decided_in_the_window_learns_and_no_other():
    viewer = Viewer(GammaDelay())
    pass_between_two_keepers(viewer)
    keepers = {choices.actor for choices, _ in viewer.steps}
    assert len(keepers) == 2
    viewer.press(1.25, -1.0)
    weights = viewer.human.weights.reshape(3, 3, -1)
    learned = {(k, option) for k in range(3) for option in range(3) if weights[k, option].any()}
    assert learned == {(choices.actor, action) for choices, action in viewer.steps}
    assert weights.max() <= 0.0  # blame only


def test_the_share_is_the_weight_of_the_lesson():
    viewer = Viewer(GammaDelay())
    viewer.see(0.0, 1)
    viewer.press(0.75)
    # One step of gradient descent from zero: H of the option becomes 0.125 x its share of the press.
    share = density_mass(0.0, 0.75)
    assert viewer.opinion(0) == pytest.approx([0.0, 0.125 * share, 0.0], abs=1e-6)


def test_keepers_may_share_what_they_are_told():
    viewer = Viewer(CurrentStep(), shared=True)
    pass_between_two_keepers(viewer)
    viewer.press(1.25)
    assert len(viewer.human.weights) == 3 * viewer.domain.coder.n_tiles
    # The catcher was praised for holding; the passer, asked in its own state, has heard of it as well.
    alone = Viewer(CurrentStep())
    pass_between_two_keepers(alone)
    alone.press(1.25)
    assert viewer.opinion(2)[HOLD] > 0.0 == alone.opinion(2)[HOLD]


def test_a_press_taken_back_leaves_the_model_as_if_it_had_never_been_made():
    silent, viewer = Viewer(GammaDelay()), Viewer(GammaDelay())
    for one in (silent, viewer):
        pass_between_two_keepers(one)
    viewer.press(1.25, number=0)
    silent.press(1.26, -1.0, number=1)
    viewer.press(1.26, -1.0, number=1)
    viewer.human.retract(0)
    np.testing.assert_array_equal(viewer.human.weights, silent.human.weights)


def test_a_second_keeper_deciding_in_the_same_moment_takes_the_screen():
    viewer = Viewer(GammaDelay())
    for at_s, action in [(0.0, HOLD), (0.1, 1), (0.1, HOLD)]:
        viewer.see(at_s, action)
    given = viewer.press(0.6)
    assert dict(zip(given.steps, given.shares, strict=True)) == pytest.approx(
        {0: density_mass(0.5, 0.6), 2: density_mass(0.0, 0.5)}, abs=1e-6
    )
