"""Compiled play with a person: the same as a loop in Python over the parts of a session; what it must never
do."""

import msgspec
import numpy as np
import pytest

from core.combination.agreement import Agreement
from core.combination.config import (
    AgentConfig,
    Annealed,
    BootstrapConfig,
    Constant,
    ControlSharing,
    EnvironmentOnly,
    Equation4,
    Equation5,
    Exponential,
    FixedWeight,
    HumanOnly,
    Linear,
    RewardShaping,
    SideBySide,
    Signed,
    Tried,
)
from core.feedback.config import CreditConfig, TrainerConfig
from core.feedback.delays import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from core.feedback.keys import KeyConfig
from core.keepaway.arl_autoplay import KEEPAWAY_AGENT, ArlAutoplay, ArlKeepawayConfig
from core.keepaway.autoplay import Autoplay, keepaway_tiles
from core.keepaway.participant_config import KeepawayPersonConfig
from core.keepaway.pitch import KeepawayConfig
from core.learners.human_config import RidgeModel, TileModel
from core.learners.human_sets import consistency
from core.learners.sarsa import SarsaConfig, new_sarsa
from tests.naive.keepaway_arl import ArlKeepaway

TALKER = TrainerConfig(press_probability=0.5, max_presses=2, mistake_rate=0.1)


def agent(scheme=None, trust=None, delay=None, shared=False):
    return AgentConfig(
        scheme=scheme or Linear(),
        bootstrap=BootstrapConfig(trust=trust or Equation4()),
        credit=CreditConfig(delay=delay or GammaDelay()),
        human_model=TileModel(step_size=0.3, shared=shared),
    )


def setting(agent_config=None, trainer=TALKER, sees="keeper", **changes):
    person = KeepawayPersonConfig(trainer=trainer, holds_noticed_per_s=0.5, sees=sees)
    settings = {"task": KeepawayConfig(exact_state=True), "n_tilings": 4} | changes
    return ArlKeepawayConfig(agent=agent_config or agent(), person=person, **settings)


ODD_PERSON = TrainerConfig(
    press_probability=0.6,
    max_presses=3,
    mean_presses=2.0,
    mistake_rate=0.2,
    deliberate_rate=0.1,
    anticipation_rate=0.3,
    burst_rate=0.5,
    delay=UniformDelay(0.1, 4.0),
    fatigue_half_life_episodes=30.0,
)
LAY = msgspec.structs.replace(TALKER, knowledge="lay", equal_margin=0.2)
SETTINGS = {
    "linear, Eq. 4, gamma": setting(),
    "exponential, Eq. 5, on screen": setting(agent(Exponential(), Equation5(), CurrentStep())),
    "linear, signed, previous, shared": setting(
        agent(Linear(), Signed(minimum_episodes=3), PreviousStep(), shared=True)
    ),
    "annealed, uniform, exact knowledge, beliefs": setting(
        agent(Annealed(), Equation4("signed"), UniformDelay()), sees="everything", task=KeepawayConfig()
    ),
    "control sharing, lay": setting(agent(ControlSharing(0.5)), LAY),
    "bursts, fatigue, anticipation, no pause": setting(
        # Not 1: where R knows one option and H speaks against it, w_h = 1 makes a tie that rounding decides,
        # and the shares of a press are the same only to rounding.
        agent(Constant(0.8), FixedWeight()),
        ODD_PERSON,
        pause_s=0.0,
        keys=KeyConfig(max_presses_per_episode=4),
    ),
    "tried": setting(agent(trust=Tried(consistent_above=0.0, minimum_episodes=2, better_by=0.5))),
    # Not weight 1, as above.
    "side by side": setting(agent(trust=SideBySide(weight=0.8, warm_up_episodes=2, episodes=2, margin=0.0))),
    "human only, 4 against 3": setting(
        agent(HumanOnly()), task=KeepawayConfig(4, 3, 25.0, 25.0, exact_state=True)
    ),
}


@pytest.mark.jit
@pytest.mark.parametrize("name", SETTINGS)
def test_compiled_play_is_the_play_of_a_session_in_python(name):
    fast, slow = ArlAutoplay(SETTINGS[name], 8, name), ArlKeepaway(SETTINGS[name], 8, name)
    for _ in range(15):
        ours, theirs = fast.play_episode(), slow.play_episode()
        assert (ours.cycles, ours.trust) == (theirs.cycles, theirs.w_h)
        assert ours.agreement == (Agreement(*theirs.agreement) if theirs.agreement[0] else None)
        made = [(p.time_ns, p.value, p.deliberate, p.accepted) for p in ours.presses]
        assert made == theirs.presses
    if len(slow.learners) == 1:
        np.testing.assert_array_equal(fast.sarsa.weights, slow.sarsa.weights)
    else:  # those who look on are written out there
        theirs = np.concatenate([learner.weights for learner in slow.learners])
        np.testing.assert_allclose(fast.sarsa.weights, theirs, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(fast.human.weights.ravel(), slow.human.weights, rtol=1e-9, atol=1e-15)
    assert fast.human.weights.any()
    assert consistency(fast.human) == pytest.approx(slow.consistency.score, rel=1e-9)
    assert fast.account.presses == slow.assigner.account.presses > 5
    for part in ("credited", "before_first", "in_gaps"):
        assert getattr(fast.account, part) == pytest.approx(getattr(slow.assigner.account, part), abs=1e-9)


@pytest.mark.jit
def test_with_nobody_watching_play_is_that_of_sarsa_alone():
    config = ArlKeepawayConfig(person=None)
    game = ArlAutoplay(config, 3, "alone")
    alone = Autoplay(config.task, 3, "alone")
    sarsa = new_sarsa(SarsaConfig(), keepaway_tiles(config.task), 3, 3)
    cycles = [game.play_episode().cycles for _ in range(30)]
    assert cycles == alone.learn(sarsa, 30).cycles.tolist()
    np.testing.assert_array_equal(game.sarsa.weights, sarsa.weights)
    assert game.trust == 0.0
    assert not game.human.weights.any()


@pytest.mark.jit
def test_a_person_who_is_not_listened_to_changes_nothing_but_the_human_model():
    deaf = ArlAutoplay(setting(agent(EnvironmentOnly())), 3, "deaf")
    alone = ArlAutoplay(_alone(), 3, "deaf")
    for _ in range(20):
        assert deaf.play_episode().cycles == alone.play_episode().cycles
    np.testing.assert_array_equal(deaf.sarsa.weights, alone.sarsa.weights)
    assert deaf.human.weights.any()


@pytest.mark.jit
def test_with_nobody_watching_learners_side_by_side_play_as_one_and_all_learn():
    beside = msgspec.structs.replace(_alone(), agent=agent(trust=SideBySide()))
    game, alone = ArlAutoplay(beside, 3, "beside"), ArlAutoplay(_alone(), 3, "beside")
    for _ in range(20):
        assert game.play_episode().cycles == alone.play_episode().cycles
    np.testing.assert_array_equal(game.sarsa.weights[:3], alone.sarsa.weights)
    # Those who look on learn about the best option, not about the one that was tried out.
    np.testing.assert_array_equal(game.sarsa.weights[3:6], game.sarsa.weights[6:])
    assert game.sarsa.weights[3:6].any()
    assert (game.sarsa.weights[3:6] != game.sarsa.weights[:3]).any()


@pytest.mark.jit
def test_of_learners_side_by_side_each_plays_and_all_learn_from_every_episode():
    game, played = ArlAutoplay(setting(agent(trust=SideBySide())), 4, "turns"), set()
    for _ in range(40):
        attitude, before = game.bootstrap.w_h, game.sarsa.weights.copy()  # weight 1
        episode = game.play_episode()
        if episode.agreement:
            assert episode.trust == attitude
            played.add(attitude)
        changed = (game.sarsa.weights != before).any(axis=(1, 2)).reshape(3, 3)
        assert (changed == changed[0]).all(), "keepers that decided learned in every set"
        assert changed.any()
    assert played == {0.0, 1.0, -1.0}


def _alone():
    return msgspec.structs.replace(setting(), person=None)


@pytest.mark.jit
def test_every_condition_meets_the_same_kick_offs():
    kick_offs = []
    for config in (setting(), _alone(), setting(agent(Exponential()))):
        game, places = ArlAutoplay(config, 5, "trial"), []
        for _ in range(5):
            places.append(_first_places(game))
            game.play_episode()
        kick_offs.append(places)
    np.testing.assert_array_equal(kick_offs[0], kick_offs[1])
    np.testing.assert_array_equal(kick_offs[0], kick_offs[2])


def _first_places(game):
    """Where everybody will stand at the next kick-off: what the placement stream gives from here."""
    state = game.streams.placement.bit_generator.state
    places = game.streams.placement.random(11)
    game.streams.placement.bit_generator.state = state
    return places


@pytest.mark.jit
def test_the_same_seed_gives_the_same_session_and_another_one_another():
    def digest(seed):
        game = ArlAutoplay(setting(), seed, "again")
        for _ in range(10):
            game.play_episode()
        return game.digest()

    assert digest(1) == digest(1) != digest(2)


@pytest.mark.parametrize("what", ["weights", "samples", "foreseen"])
def test_the_digest_tells_of_everything_that_is_known_of_the_person(what):
    # The same play, and yet not the same knowledge: trust by trial goes by `foreseen`, everything else by
    # `samples`.
    game, other = (ArlAutoplay(setting(), 1, "told apart") for _ in range(2))
    assert game.digest() == other.digest()
    getattr(other.human, what).flat[-1] += 1
    assert game.digest() != other.digest()


def test_the_digest_tells_what_the_environment_taught_from_what_the_person_did():
    game, other = (ArlAutoplay(setting(), 1, "told apart") for _ in range(2))
    game.sarsa.weights.flat[-1] = 1.0
    other.human.weights.flat[-1] = 1.0
    assert game.digest() != other.digest()


@pytest.mark.jit
def test_at_most_two_presses_of_an_episode_count_and_their_mass_is_accounted_for():
    eager = TrainerConfig(press_probability=1.0, max_presses=20, burst_rate=0.5)
    game = ArlAutoplay(setting(trainer=eager), 11, "budget")
    episodes = [game.play_episode() for _ in range(60)]
    assert max(e.accepted for e in episodes) == 2
    assert any(len(e.presses) > 2 for e in episodes)
    account = game.account
    assert account.presses == sum(e.accepted for e in episodes)
    assert account.credited + account.before_first + account.in_gaps == pytest.approx(account.presses)


@pytest.mark.jit
@pytest.mark.statistical
def test_about_one_press_in_ten_is_wrong_and_holds_are_judged_seldom():
    trainer = TrainerConfig(press_probability=0.3, max_presses=2, mistake_rate=0.1, deliberate_rate=0.0)
    config = msgspec.structs.replace(setting(agent(EnvironmentOnly()), trainer), n_tilings=32)
    right = ArlAutoplay(_with_mistakes(config, 0.0), 2, "right")
    wrong = ArlAutoplay(config, 2, "right")
    judgements = differ = 0
    for _ in range(300):
        # Same play, same draws: only mistakes differ.
        pairs = zip(right.play_episode().presses, wrong.play_episode().presses, strict=True)
        for ours, theirs in pairs:
            judgements += 1
            differ += ours.value != theirs.value
    # 4 standard errors of a fraction of 0.1.
    assert abs(differ / judgements - 0.1) < 4 * (0.09 / judgements) ** 0.5


def _with_mistakes(config, rate):
    trainer = msgspec.structs.replace(config.person.trainer, mistake_rate=rate)
    return msgspec.structs.replace(config, person=msgspec.structs.replace(config.person, trainer=trainer))


def test_settings_that_compiled_play_cannot_follow_are_refused():
    with pytest.raises(TypeError, match="TileModel"):
        ArlKeepawayConfig(agent=msgspec.structs.replace(KEEPAWAY_AGENT, human_model=RidgeModel()))
    aggregate = CreditConfig(delay=GammaDelay(), scheme="aggregate")
    with pytest.raises(ValueError, match="individual"):
        ArlKeepawayConfig(agent=msgspec.structs.replace(KEEPAWAY_AGENT, credit=aggregate))
    for rule in (Equation4(measured="window"), Equation4("chance-corrected")):
        with pytest.raises(ValueError, match="window"):
            ArlKeepawayConfig(agent=agent(trust=rule))
    with pytest.raises(TypeError, match="goes by trust"):
        ArlKeepawayConfig(agent=agent(Constant(), trust=SideBySide()))
    for sarsa in (SarsaConfig(trace_decay=0.5), SarsaConfig(shared_weights=True)):
        with pytest.raises(ValueError, match="side by side"):
            ArlKeepawayConfig(agent=agent(trust=SideBySide()), sarsa=sarsa)
    with pytest.raises(ValueError, match="burst"):
        setting(trainer=TrainerConfig(burst_rate=0.1, burst_interval_s=0.05))
    with pytest.raises(ValueError, match="learning"):
        ArlKeepawayConfig(agent=agent(RewardShaping()))
    with pytest.raises(ValueError, match="myopic"):
        setting(trainer=TrainerConfig(knowledge="myopic"))
    with pytest.raises(ValueError, match="pause_s"):
        setting(pause_s=-1.0)
