"""A match that is watched: the same episodes as whole ones, cycle by cycle."""

import numpy as np
import pytest

from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.pitch import OUT, KeepawayConfig
from core.keepaway.viewed_match import Policy, ViewedMatch
from core.learners.sarsa import Sarsa, SarsaConfig, frozen, new_sarsa

CONFIG = KeepawayConfig(exact_state=True)


@pytest.fixture(scope="module")
def learned() -> Sarsa:
    """Learners with weights of their own, as if they had learned."""
    sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(CONFIG), 3, 3)
    sarsa.weights[:] = np.random.default_rng(7).normal(0.0, 1.0, sarsa.weights.shape)
    return sarsa


def watched(match: ViewedMatch, n_episodes: int) -> list[tuple[int, bool]]:
    """Return duration in cycles and whether the ball was out, of each episode."""
    ends = []
    while len(ends) < n_episodes:
        frame = match.step()
        if frame.ended:
            ends.append((frame.cycle, frame.ended == OUT))
    return ends


@pytest.mark.parametrize("policy", ["random", "hand", "learned"])
def test_it_plays_the_episodes_that_whole_episodes_play(policy: str, learned: Sarsa):
    n = 8
    game = Autoplay(CONFIG, 5, "twin")
    whole = game.learn(frozen(learned), n) if policy == "learned" else game.play(policy, n)
    chosen: Policy = learned if policy == "learned" else policy
    match = ViewedMatch(CONFIG, chosen, 5, "twin")
    assert watched(match, n) == list(zip(whole.cycles.tolist(), whole.out.tolist(), strict=True))


def test_watching_teaches_nothing(learned: Sarsa):
    before = learned.weights.copy()
    watched(ViewedMatch(CONFIG, learned, 5, "twin"), 2)
    assert np.array_equal(learned.weights, before)


def test_it_tells_what_the_deciding_learner_thinks_of_each_option(learned: Sarsa):
    match = ViewedMatch(CONFIG, learned, 5, "twin")
    assert match.values() == ()
    n_passes = 0
    for _ in range(300):
        frame = match.step()
        if frame.ended or frame.decider < 0:
            continue
        values = dict(match.values())
        assert next(iter(values)) == "Hold"
        assert set(values) == {"Hold", "K1", "K2", "K3"} - {frame.name(frame.decider)}
        taken = "Hold" if frame.target < 0 else frame.name(frame.target)
        assert values[taken] == max(values.values())
        n_passes += frame.target >= 0
    assert n_passes > 0


def test_a_benchmark_policy_thinks_nothing():
    match = ViewedMatch(CONFIG, "hand", 5, "twin")
    while match.step().decider < 0:
        pass
    assert match.values() == ()


def test_the_next_episode_can_come_early():
    match = ViewedMatch(CONFIG, "hold", 5, "twin")
    match.step()
    frame = match.next_episode()
    assert (frame.episode, frame.cycle, frame.decider) == (2, 0, -1)
    assert match.frame is frame


def test_a_policy_of_another_task_is_an_error(learned: Sarsa):
    with pytest.raises(ValueError, match="no policy 'best'; there are random, hold, hand"):
        ViewedMatch(CONFIG, "best", 5)
    with pytest.raises(
        ValueError, match="4 keepers against 3 takers need 4 learners of 19 variables, got 3 of 13"
    ):
        ViewedMatch(KeepawayConfig(n_keepers=4, n_takers=3), learned, 5)
    with pytest.raises(ValueError, match="need 3 learners of 11 variables, got 3 of 13"):
        ViewedMatch(KeepawayConfig(n_takers=1), learned, 5)
