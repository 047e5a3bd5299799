"""The decision kernels, the schemes' weights and control sharing."""

import math
import subprocess
import sys

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from core.combination.config import (
    ADVISE,
    ENVIRONMENT_WEIGHTS,
    EXPONENTIAL,
    LINEAR,
    LINEAR_RAW,
    SCHEMES,
    ActionBiasing,
    Advise,
    Annealed,
    Coach,
    Constant,
    ControlSharing,
    EnvironmentOnly,
    EpisodeWeights,
    Exponential,
    HumanOnly,
    Linear,
    QAugmentation,
    RewardShaping,
    Scheme,
)
from core.combination.preference import best_action, chance_of_right, choose, takes_control, worst_action
from core.numerics.streams import stream
from tests.naive.combination import advised_choice, exponential_choice, linear_choice


def row(*values: float) -> NDArray[np.float64]:
    return np.array(values, dtype=np.float64)


def nothing_ruled_out(n: int) -> NDArray[np.bool_]:
    return np.zeros(n, dtype=np.bool_)


def test_linear_scheme_by_hand() -> None:
    # R = 0, 2, 4: mean 2, sd sqrt(8/3) = 1.633, so R becomes -1.225, 0, 1.225.
    # H = 9, 0, 0: mean 3, sd sqrt(54/3) = 4.243, so H becomes 1.414, -0.707, -0.707.
    # Action 0 wins over action 2 when -1.225 + 1.414 w > 1.225 - 0.707 w, that is w > 2.449 / 2.121 = 1.155.
    env, human, ruled_out = row(0, 2, 4), row(9, 0, 0), nothing_ruled_out(3)
    assert choose(env, human, ruled_out, 3, LINEAR, 1.0, 1.15) == 2
    assert choose(env, human, ruled_out, 3, LINEAR, 1.0, 1.16) == 0


def test_linear_scheme_on_raw_values_by_hand() -> None:
    # 0 + 9 w > 4 + 0 w when w > 4/9 = 0.444
    env, human, ruled_out = row(0, 2, 4), row(9, 0, 0), nothing_ruled_out(3)
    assert choose(env, human, ruled_out, 3, LINEAR_RAW, 1.0, 0.44) == 2
    assert choose(env, human, ruled_out, 3, LINEAR_RAW, 1.0, 0.45) == 0


def test_exponential_scheme_by_hand() -> None:
    # R = -1, 1, 2 is shifted to 0, 2, 3. H = -4, 4, 0 is mapped to 0, 1, 0.5.
    # With w = 1: 0, 2 (1 + 1) = 4, 3 (1 + 0.5) = 4.5. With w = 3: 0, 4, 3 (1 + 0.125) = 3.375.
    env, human, ruled_out = row(-1, 1, 2), row(-4, 4, 0), nothing_ruled_out(3)
    assert choose(env, human, ruled_out, 3, EXPONENTIAL, 1.0, 1.0) == 2
    assert choose(env, human, ruled_out, 3, EXPONENTIAL, 1.0, 3.0) == 1


def test_advise_by_hand() -> None:
    # Two actions: R' = -1, 1 and H' = 1, -1. pi_R(0) / pi_R(1) = e^-2; with C = 0.9 odds are ln 9 = 2.197:
    # pi_H = 0.9 and 0.1, so action 0 has 0.9 e^-2 = 0.1218 to 0.1: taken, though R is as sure of action 1.
    env, human, ruled_out = row(0, 1), row(5, 3), nothing_ruled_out(2)
    assert chance_of_right(math.log(9.0)) == pytest.approx(0.9)
    assert choose(env, human, ruled_out, 2, ADVISE, 1.0, math.log(9.0)) == 0
    # C = 0.85: 0.85 e^-2 = 0.115 to 0.15
    assert choose(env, human, ruled_out, 2, ADVISE, 1.0, math.log(0.85 / 0.15)) == 1
    # A human as consistent as a coin says nothing; one who is mostly wrong means the opposite.
    assert choose(env, human, ruled_out, 2, ADVISE, 1.0, 0.0) == 1
    assert choose(row(1, 1.001, 0), row(9, 3, 0), nothing_ruled_out(3), 3, ADVISE, 1.0, -9.0) == 1


def test_advice_is_the_formula_of_counts() -> None:
    # C^d / (C^d + (1 - C)^d) with C = 0.8, d = 3 and d = -2
    odds = math.log(0.8 / 0.2)
    assert chance_of_right(3 * odds) == pytest.approx(0.8**3 / (0.8**3 + 0.2**3), rel=1e-14)
    assert chance_of_right(-2 * odds) == pytest.approx(0.8**-2 / (0.8**-2 + 0.2**-2), rel=1e-14)


def test_a_negative_weight_turns_the_humans_order_round_in_every_form() -> None:
    env, human, ruled_out = row(1, 1.1, 1), row(5, 4, -5), nothing_ruled_out(3)
    assert choose(env, human, ruled_out, 3, LINEAR, 1.0, -9.0) == 2
    assert choose(env, human, ruled_out, 3, LINEAR_RAW, 1.0, -9.0) == 2
    assert choose(env, human, ruled_out, 3, LINEAR, 0.0, -1.0) == 2
    # Shifted R = 0, 1, 3; 1 - h = 0, 1/10, 1: the participant's worst action gets the whole factor 2.
    assert choose(row(0, 1, 3), human, ruled_out, 3, EXPONENTIAL, 1.0, -2.0) == 2


def test_a_constant_row_has_no_say() -> None:
    # 0.1 * 3 / 3 is not 0.1 in floating point: a constant row must become zeros, not noise over nearly zero.
    ruled_out = nothing_ruled_out(3)
    assert choose(row(1, 3, 2), row(0.1, 0.1, 0.1), ruled_out, 3, LINEAR, 1.0, 1e6) == 1
    assert choose(row(0.1, 0.1, 0.1), row(1, 2, 3), ruled_out, 3, LINEAR, 1e6, 1.0) == 2
    assert choose(row(1, 3, 2), row(7, 7, 7), ruled_out, 3, EXPONENTIAL, 1.0, 2.0) == 1


def test_ruled_out_actions_are_not_taken_and_do_not_set_the_scale() -> None:
    env, human = row(0, 1, 1e9), row(1, 0, -1e9)
    ruled_out = np.array([False, False, True])
    # Without the third action R and H are 0, 1 and 1, 0: both standardise to -1, 1 and 1, -1.
    assert choose(env, human, ruled_out, 3, LINEAR, 1.0, 0.9) == 1
    assert choose(env, human, ruled_out, 3, LINEAR, 1.0, 1.1) == 0


@pytest.mark.parametrize("form", [LINEAR, EXPONENTIAL, LINEAR_RAW, ADVISE])
def test_the_first_action_is_taken_when_all_are_ruled_out(form: int) -> None:
    all_out = np.ones(3, dtype=np.bool_)
    assert choose(row(1, 2, 3), row(3, 2, 1), all_out, 3, form, 1.0, 0.5) == 0
    assert best_action(row(1, 2, 3), all_out, 3) == 0
    assert worst_action(row(3, 2, 1), all_out, 3) == 0


def test_the_lowest_index_wins_ties() -> None:
    ruled_out = np.array([True, False, False, False])
    assert best_action(row(9, 2, 2, 1), ruled_out, 4) == 1
    assert worst_action(row(0, 5, 3, 3), ruled_out, 4) == 2
    assert choose(row(9, 2, 2, 1), row(0, 4, 4, 4), ruled_out, 4, LINEAR, 1.0, 1.0) == 1


def test_entries_behind_n_are_not_read() -> None:
    env, human, ruled_out = row(1, 2, 9), row(1, 2, 9), nothing_ruled_out(3)
    assert choose(env, human, ruled_out, 2, LINEAR, 1.0, 1.0) == 1


def test_without_trust_the_environments_best_action_is_taken_even_where_scaling_would_round() -> None:
    # Standardised, 1e16 and 1e16 + 2 are hardly apart; as they come, they are not equal.
    env = row(1e16, 1e16 + 2, -1e300)
    assert choose(env, row(5, 1, 1), nothing_ruled_out(3), 3, LINEAR, 1.0, 0.0) == 1


VALUES = st.floats(-1e6, 1e6, allow_subnormal=False)


@given(st.data())
def test_kernel_and_naive_twin_choose_the_same_action(data: st.DataObject) -> None:
    n = data.draw(st.integers(1, 34))
    env, human = (np.array(data.draw(st.lists(VALUES, min_size=n, max_size=n))) for _ in range(2))
    ruled_out = np.array(data.draw(st.lists(st.booleans(), min_size=n, max_size=n)))
    w_r = data.draw(st.sampled_from([0.0, 0.5, 1.0]))
    w_h = data.draw(st.floats(-3, 3))
    lists = env.tolist(), human.tolist(), ruled_out.tolist()
    assert choose(env, human, ruled_out, n, LINEAR, w_r, w_h) == linear_choice(*lists, w_r, w_h)
    assert choose(env, human, ruled_out, n, LINEAR_RAW, w_r, w_h) == linear_choice(
        *lists, w_r, w_h, standardise=False
    )
    assert choose(env, human, ruled_out, n, EXPONENTIAL, 1.0, w_h) == exponential_choice(*lists, 1.0, w_h)
    advised = choose(env, human, ruled_out, n, ADVISE, 1.0, w_h)
    assert advised_choice(*lists, 1.0, w_h, taken=advised)


@given(
    st.lists(st.integers(-50, 50), min_size=2, max_size=12, unique=True),
    st.integers(1, 64),
    st.integers(-100, 100),
    st.integers(0, 2**32 - 1),
)
def test_a_participant_on_another_scale_leads_to_the_same_action(
    env_values: list[int], factor: int, shift: int, seed: int
) -> None:
    n = len(env_values)
    env = np.array(env_values, dtype=np.float64)
    human = stream(seed, "human").normal(size=n)
    ruled_out = nothing_ruled_out(n)
    for form in (LINEAR, EXPONENTIAL, ADVISE):
        one = choose(env, human, ruled_out, n, form, 1.0, 0.7)
        assert choose(env, factor * human + shift, ruled_out, n, form, 1.0, 0.7) == one


def test_weights_of_every_scheme_by_hand() -> None:
    trust = 0.25
    assert Linear().episode_weights(trust, 7) == EpisodeWeights(LINEAR, 1.0, 0.25)
    assert Linear(scale="raw").episode_weights(trust, 7) == EpisodeWeights(LINEAR_RAW, 1.0, 0.25)
    assert Exponential().episode_weights(trust, 7) == EpisodeWeights(EXPONENTIAL, 1.0, 0.25)
    # 2 * 0.5^3 = 0.25
    assert Annealed(beta_0=2.0, decay=0.5).episode_weights(0.9, 3) == EpisodeWeights(LINEAR, 1.0, 0.25)
    assert Constant(w_h=0.4).episode_weights(trust, 7) == EpisodeWeights(LINEAR, 1.0, 0.4)
    assert EnvironmentOnly().episode_weights(trust, 7) == EpisodeWeights(LINEAR, 1.0, 0.0)
    assert HumanOnly().episode_weights(trust, 7) == EpisodeWeights(LINEAR, 0.0, 1.0)
    # 10 * 0.5^2 = 2.5, on raw values
    assert ActionBiasing(decay=0.5).episode_weights(trust, 2) == EpisodeWeights(LINEAR_RAW, 1.0, 2.5)
    # 4 * 0.5^k = 4, 2, 1, 0.5: a probability is clipped at 1
    shares = [ControlSharing(beta_0=4.0, decay=0.5).episode_weights(trust, k).handover for k in range(4)]
    assert shares == [1.0, 1.0, 1.0, 0.5]
    assert ControlSharing().episode_weights(trust, 0).w_h == 0.0
    # 4 * 0.5^3 = 0.5 in the reward, nothing in the choice
    assert RewardShaping(beta_0=4.0, decay=0.5).episode_weights(trust, 3) == EpisodeWeights(
        LINEAR, 1.0, 0.0, shaping=0.5
    )
    assert QAugmentation(beta=2.0).episode_weights(trust, 3) == EpisodeWeights(
        LINEAR_RAW, 1.0, 2.0, augmentation=2.0
    )
    # ln(0.8 / 0.2) = ln 4; temperature 0.5 doubles R
    advice = Advise(consistency=0.8, temperature=0.5).episode_weights(trust, 3)
    assert (advice.form, advice.w_r) == (ADVISE, 2.0)
    assert advice.w_h == pytest.approx(math.log(4.0))
    assert Coach().episode_weights(trust, 3) == ENVIRONMENT_WEIGHTS


def test_the_papers_baseline_halves_in_about_34_episodes() -> None:
    # 0.98^34 = exp(34 ln 0.98) = 0.503
    assert Annealed().episode_weights(0.0, 34).w_h == pytest.approx(0.503, abs=5e-4)


def test_every_scheme_is_registered_under_its_tag_and_survives_a_recordings_header() -> None:
    for name, kind in SCHEMES.items():
        scheme = kind()
        text = msgspec.json.encode(scheme)
        assert msgspec.json.decode(text)["type"] == name
        assert msgspec.json.decode(text, type=Scheme) == scheme


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"type":"annealed","decay":1.5}', "decay is a factor"),
        ('{"type":"control-sharing","beta_0":-1}', "beta_0 is finite"),
        ('{"type":"linear","scale":"ranked"}', "scale"),
        ('{"type":"reward-shaping","decay":0}', "decay is a factor"),
        ('{"type":"advise","consistency":1}', "consistency is a chance"),
        ('{"type":"advise","temperature":0}', "temperature"),
        ('{"type":"coach","step_size":0}', "step_size"),
        ('{"type":"democratic"}', "democratic"),
    ],
)
def test_a_wrong_scheme_is_refused_with_the_reason(text: str, reason: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=reason):
        msgspec.json.decode(text, type=Scheme)


def test_wrong_episode_weights_are_refused() -> None:
    with pytest.raises(ValueError, match="form"):
        EpisodeWeights(7, 1.0, 0.0)
    with pytest.raises(ValueError, match="w_r"):
        EpisodeWeights(LINEAR, -1.0, 0.0)
    with pytest.raises(ValueError, match="w_h"):
        EpisodeWeights(LINEAR, 1.0, math.nan)
    with pytest.raises(ValueError, match="handover"):
        EpisodeWeights(LINEAR, 1.0, 0.0, 1.01)
    with pytest.raises(ValueError, match="shaping"):
        EpisodeWeights(LINEAR, 1.0, 0.0, shaping=math.inf)
    with pytest.raises(ValueError, match="episode"):
        Annealed().episode_weights(0.0, -1)


@pytest.mark.statistical
@pytest.mark.parametrize("handover", [0.1, 0.5, 0.98])
def test_control_is_shared_in_the_stated_proportion(handover: float) -> None:
    n = 20_000
    taken = [takes_control(seed, decision, handover) for seed in range(20) for decision in range(n // 20)]
    # standard error sqrt(p (1 - p) / n); allow 4 of them
    assert np.mean(taken) == pytest.approx(handover, abs=4 * math.sqrt(handover * (1 - handover) / n))


def test_control_is_never_shared_at_0_and_always_at_1() -> None:
    assert not any(takes_control(3, decision, 0.0) for decision in range(500))
    assert all(takes_control(3, decision, 1.0) for decision in range(500))


def test_shared_decisions_depend_on_seed_and_decision() -> None:
    def pattern(seed: int) -> list[bool]:
        return [bool(takes_control(seed, decision, 0.5)) for decision in range(64)]

    assert pattern(1) == pattern(1)
    assert pattern(1) != pattern(2)
    assert pattern(1)[:-1] != pattern(1)[1:]


def test_compiled_and_plain_draws_are_the_same() -> None:
    plain = getattr(takes_control, "py_func", takes_control)
    for seed in (0, 1, (1 << 62) - 1):
        for decision in (0, 1, 10**9):
            for handover in (0.2, 0.5, 0.8):
                assert takes_control(seed, decision, handover) == plain(seed, decision, handover)


def test_settings_are_read_without_compiled_code() -> None:
    """The screen's process reads protocols; compiled code and scipy would cost it half a second."""
    program = (
        "import sys; import core.combination.config, core.feedback.trainers, core.feedback.source; "
        "from core.feedback.credit import parse_delay; parse_delay('gamma:2.5,0.3'); "
        "print(sorted({'numba', 'scipy'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
