"""Policy gradient in whole games of Tetris: compiled play is the play one would make step by step."""

import numpy as np
import pytest

from core.combination.config import EXPONENTIAL, LINEAR, LINEAR_RAW, EpisodeWeights
from core.combination.preference import best_action, worst_action
from core.combination.tally import COMPARED
from core.learners.linear import action_values
from core.learners.policy_gradient import PolicyGradient, PolicyGradientConfig
from core.numerics.compiled import JIT_DISABLED
from core.numerics.counters import uniform_at
from core.numerics.fixed_point import exact_weights
from core.numerics.streams import stream, stream_seed
from core.tetris.afterstate import Tetris
from core.tetris.config import TetrisConfig
from core.tetris.policy_gradient import PolicyGradientGame, placement_scales
from tests.core.tetris.playing import play_policy_gradient
from tests.naive.policy_gradient import NaiveLearner, logits, probabilities

SMALL = TetrisConfig(rows=10, columns=6)
N_EPISODES = 2 if JIT_DISABLED else 12
CASES = {
    "alone": (SMALL, EpisodeWeights(LINEAR, 1.0, 0.0)),
    "linear": (SMALL, EpisodeWeights(LINEAR, 1.0, 0.6)),
    "raw": (SMALL, EpisodeWeights(LINEAR_RAW, 1.0, 0.3)),
    "exponential": (SMALL, EpisodeWeights(EXPONENTIAL, 1.0, 0.9)),
    "shaped": (SMALL, EpisodeWeights(LINEAR, 1.0, 0.0, shaping=0.05)),
    "sharing": (SMALL, EpisodeWeights(LINEAR, 1.0, 0.0, 0.3)),
    "overflow": (
        TetrisConfig(rows=10, columns=6, game_over="overflow", features="paper-12"),
        EpisodeWeights(LINEAR, 1.0, 0.5),
    ),
}


def pupil_for(config, **changes):
    return PolicyGradient(PolicyGradientConfig(**changes), scales=placement_scales(config))


def likes(config):
    """A human model that prefers flat boards without holes, with some noise."""
    names = Tetris(config).feedback_feature_names
    base = [-4.0 if n == "holes" else -1.0 if "difference" in n else -0.3 for n in names]
    return np.array(base) + stream(1, "human").normal(size=len(names)) * 0.1


def naive_episode(pupil, human, seed, config, weights, chance_seed, handover_seed):
    """Lines, pieces, agreements with the participant's best and worst: over the domain's own steps."""
    domain, scales = Tetris(config), placement_scales(config)
    state, agreed, worst = domain.initial(seed), 0, 0
    while not domain.terminal(state):
        choices = domain.choices(state)
        rows, out = choices.features / scales, choices.ruled_out
        env = np.zeros(len(rows))
        for column, weight in zip(rows.T, pupil.theta, strict=True):  # in order: equal placements stay equal
            env = env + column * weight
        heard = action_values(choices.feedback_features, exact_weights(human))
        n = len(rows)
        human_best = best_action(heard, out, n)
        agreed += best_action(env, out, n) == human_best
        worst += best_action(env, out, n) == worst_action(heard, out, n)
        open_ = ~out if not out.all() else np.arange(n) == 0
        if uniform_at(handover_seed, state.k) < weights.handover:
            action, score = human_best, np.zeros(len(scales))
        else:
            shares = np.zeros(n)
            shares[open_] = probabilities(logits(env, heard, weights.w_h, weights.form, open_))
            action = int(np.searchsorted(np.cumsum(shares), uniform_at(chance_seed, state.k), side="right"))
            gains = np.ones(n)
            if weights.form == EXPONENTIAL:
                low, high = heard[open_].min(), heard[open_].max()
                gains = (
                    1 + np.clip((heard - low) / (high - low), 0, 1) ** weights.w_h if high > low else gains
                )
            relative = rows - rows[worst_action(env, out, n)]
            score = gains[action] * relative[action] - (shares * gains) @ relative
        transition = domain.transition(state, action)
        pupil.learn(score, transition.reward + weights.shaping * heard[action])
        state = transition.next_state
    return state.lines, state.k, agreed, worst


@pytest.mark.parametrize("update", ["step", "episode"])
@pytest.mark.parametrize("case", CASES)
def test_compiled_episodes_are_those_of_the_slow_twin(case, update):
    config, weights = CASES[case]
    human = likes(config)
    rates = {"step_size": 0.02, "trace_decay": 0.8, "baseline_rate": 0.05}
    pupil = pupil_for(config, update=update, **rates)
    twin = NaiveLearner(len(pupil.scales), **rates, online=update == "step")
    for k in range(N_EPISODES):
        seed, chance, handover = (stream_seed(4, name, k) >> 1 for name in ("episode", "softmax", "share"))
        played = play_policy_gradient(
            pupil, human, seed, config, weights, chance_seed=chance, handover_seed=handover
        )
        twin.trace, twin.gradient = np.zeros(len(pupil.scales)), np.zeros(len(pupil.scales))
        expected = naive_episode(twin, human, seed, config, weights, chance, handover)
        if update == "episode":
            twin.theta = twin.theta + rates["step_size"] * twin.gradient
        compared, agreed, agreed_worst = played.tally.tolist()
        assert (played.lines, played.pieces, agreed, agreed_worst) == expected
        assert played.finished
        assert compared == played.pieces
        np.testing.assert_allclose(pupil.memory.weights, twin.theta, rtol=1e-7, atol=1e-12)
    assert pupil.memory.weights.any() or JIT_DISABLED  # so few games may clear no line


def test_a_game_can_be_stopped_and_continued():
    whole, halting = pupil_for(SMALL), pupil_for(SMALL)
    human, weights = likes(SMALL), EpisodeWeights(LINEAR, 1.0, 0.5)
    for k in range(3):
        played = play_policy_gradient(whole, human, k, SMALL, weights, chance_seed=k)
        game = PolicyGradientGame(halting, human, k, SMALL, weights, chance_seed=k)
        while not game.finished:
            before = game.pieces
            game.advance(before + 1)
            assert game.pieces == before + 1 or game.finished
        halting.end_episode()
        assert (game.lines, game.pieces) == (played.lines, played.pieces)
        assert game.tally.tolist() == played.tally.tolist()
    assert whole.state_bytes() == halting.state_bytes()


def nobody(config=SMALL):
    return np.zeros(len(Tetris(config).feedback_feature_names))


def test_decisions_kept_are_those_that_led_to_the_boards():
    domain = Tetris(SMALL)
    game, state = (
        PolicyGradientGame(pupil_for(SMALL), nobody(), 9, SMALL, chance_seed=3, window=3),
        domain.initial(9),
    )
    while not domain.terminal(state):
        game.advance(state.k + 1)
        columns, action = game.kept(state.k)
        assert columns == state.columns
        state = domain.transition(state, action).next_state
    game.advance(state.k + 1)
    assert game.finished
    with pytest.raises(ValueError, match="not one of the last 3"):
        game.kept(state.k - 4)


def test_the_human_model_may_change_between_two_pieces():
    early, late = (
        PolicyGradientGame(pupil_for(SMALL), human, 5, SMALL, EpisodeWeights(LINEAR, 1.0, 5.0), chance_seed=1)
        for human in (likes(SMALL), nobody())
    )
    late.advance(3)
    assert late.tally[COMPARED] == 0
    late.set_human_weights(likes(SMALL))
    for game in (early, late):
        game.advance(8)
    assert (early.tally[COMPARED], late.tally[COMPARED]) == (8, 5)


def test_without_a_human_policy_nothing_is_compared():
    played = play_policy_gradient(pupil_for(SMALL), nobody(), 1, SMALL, chance_seed=1)
    assert played.tally.tolist() == [0, 0, 0]


def test_the_human_alone_plays_greedily_and_teaches_the_learner_nothing():
    pupil = pupil_for(SMALL)
    alone = EpisodeWeights(LINEAR, 0.0, 1.0)
    played = [
        play_policy_gradient(pupil, likes(SMALL), 2, SMALL, alone, chance_seed=seed, piece_cap=60)
        for seed in (1, 2)
    ]
    assert played[0].lines == played[1].lines > 0
    assert not pupil.memory.weights.any()


def test_scales_are_powers_of_two_near_the_spread_of_each_feature():
    scales = placement_scales(SMALL)
    assert np.array_equal(np.exp2(np.rint(np.log2(scales))), scales)
    domain = Tetris(SMALL)
    spread = domain.choices(domain.initial(0)).features.std(axis=0)
    # On an empty board placements differ less than later: within a factor of 8 is all that is asked.
    assert ((scales / np.maximum(spread, 0.25) < 8) & (scales >= 1)).all()


def test_a_learner_of_another_width_is_refused():
    with pytest.raises(ValueError, match=r"13 features, the learner 21"):
        play_policy_gradient(pupil_for(TetrisConfig()), np.zeros(13), 0, SMALL, chance_seed=0)


@pytest.mark.statistical
@pytest.mark.jit
def test_the_learner_learns():
    """On 10 x 6 a uniform policy clears hardly any line; after 300 episodes most clear several."""
    config, lines = TetrisConfig(rows=10, columns=6), []
    pupil = pupil_for(config)
    for k in range(300):
        lines.append(play_policy_gradient(pupil, nobody(), k, config, chance_seed=k, piece_cap=500).lines)
    assert np.mean(lines[:20]) < 2
    assert np.mean(lines[-50:]) > 10
