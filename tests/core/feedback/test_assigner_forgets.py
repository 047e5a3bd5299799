"""A long session: the assigner keeps what a press may still need, and no more."""

import numpy as np
import pytest

from core.feedback.assigner import CreditAssigner, CreditConfig
from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from core.numerics.clock import NS_PER_S
from tests.core.feedback.test_assigner import features, ns, told

EPISODE_S = 40.0


def test_a_long_session_keeps_only_the_features_that_a_press_may_still_need():
    assigner = CreditAssigner(CreditConfig())
    for step in range(2000):
        assigner.step_shown(step, step * NS_PER_S, np.full(3, float(step)))
        if step in (500, 501):
            assigner.add_press(step, step * NS_PER_S + 600_000_000, 1.0)
    kept = set(assigner._features)
    assert {499, 500, 501} & kept
    assert len(kept) < 100
    before = [sample.features.tolist() for sample in assigner.samples]
    assert before
    assigner.retract(501)
    assert [sample.features.tolist() for sample in assigner.samples] == before[: len(assigner.samples)]
    assigner.add_press(2000, 1999 * NS_PER_S + 600_000_000, -1.0)
    assert assigner.samples[-1].features[0] >= 1998.0


def play_episodes(assigner: CreditAssigner, n_episodes: int, *, begins: bool) -> list[object]:
    """Play episodes of steps of half a second; in each, a press is taken back, some in the next episode."""
    given: list[object] = []
    held = -1
    for episode in range(n_episodes):
        began_s, first = episode * EPISODE_S, episode * 60
        if begins:
            assigner.episode_begins()
        if held >= 0:
            assigner.retract(held)  # a key that was held over the end of the last episode
        for step in range(60):
            shown_s = began_s + step / 2
            assigner.step_shown(first + step, ns(shown_s), features(first + step))
            if step % 7 == 3:
                given.append(assigner.add_press(first + step, ns(shown_s + 0.1), 1.0 - step % 2 * 2))
            if step == 40:
                assigner.retract(first + 31)
        assigner.step_hidden(first + 59, ns(began_s + 30))
        given.append(told(list(assigner.take())))
        held = first + 59 if episode % 3 == 0 else -1
    assigner.finish(ns(n_episodes * EPISODE_S))
    return [*given, told(list(assigner.samples)), assigner.account]


@pytest.mark.parametrize("scheme", ["individual", "aggregate"])
@pytest.mark.parametrize("silence", ["no-update", "zero-label"])
@pytest.mark.parametrize("delay", [UniformDelay(), GammaDelay(3.0, 0.2, 0.1), CurrentStep(), PreviousStep()])
def test_forgetting_what_no_press_can_reach_changes_no_sample(scheme, silence, delay):
    if silence == "zero-label" and scheme == "individual":
        return
    config = CreditConfig(delay=delay, scheme=scheme, silence=silence, merge_within_s=0.6)
    forgetting, keeping = CreditAssigner(config), CreditAssigner(config)
    assert play_episodes(forgetting, 9, begins=True) == play_episodes(keeping, 9, begins=False)
    assert len(forgetting._ledger._steps) < 60 * 5 < len(keeping._ledger._steps)


def test_a_session_of_many_episodes_keeps_what_happened_in_two():
    for n_episodes in (4, 12):
        assigner = CreditAssigner(CreditConfig())
        play_episodes(assigner, n_episodes, begins=True)
        assert len(assigner._log) + len(assigner._before) < 2 * 60 + 2 * 15
        assert len(assigner._ledger._steps) < 60 * 5
        assert len(assigner._features) < 60 * 5


def test_a_press_of_an_episode_of_long_ago_is_settled():
    assigner = CreditAssigner(CreditConfig())
    assigner.step_shown(0, 0, features(0))
    assigner.add_press(0, ns(0.5), 1.0)
    assigner.episode_begins()
    assigner.episode_begins()
    with pytest.raises(ValueError, match="made before the last episode"):
        assigner.retract(0)
    assert assigner.account.presses == 1


def test_a_press_for_a_step_that_was_forgotten_is_refused_with_the_reason():
    assigner = CreditAssigner(CreditConfig())
    for episode in range(9):
        assigner.episode_begins()
        for step in range(60):
            number = episode * 60 + step
            assigner.step_shown(number, number * NS_PER_S, features(number))
    with pytest.raises(ValueError, match="press 1 is for a step, which left the screen more than 60 s ago"):
        assigner.add_press(1, 50 * NS_PER_S, 1.0)


def test_a_press_for_a_step_of_long_ago_is_refused_with_the_reason():
    assigner = CreditAssigner(CreditConfig())
    for step in range(300):
        assigner.step_shown(step, step * NS_PER_S, np.zeros(3))
    with pytest.raises(ValueError, match="left the screen more than 60 s ago"):
        assigner.add_press(1, 50 * NS_PER_S + 600_000_000, 1.0)
