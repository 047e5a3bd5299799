"""From a session's events to samples: schemes, silence, bursts, pauses, retraction."""

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from core.feedback.assigner import CreditAssigner, CreditConfig, FeedbackSample
from core.feedback.credit import CurrentStep, GammaDelay, PreviousStep, UniformDelay
from core.numerics.clock import NS_PER_S


def features(step: int) -> NDArray[np.float64]:
    return np.array([float(step), 1.0])


def ns(time_s: float) -> int:
    return round(time_s * NS_PER_S)


def told(
    samples: "list[FeedbackSample] | tuple[FeedbackSample, ...]",
) -> list[tuple[int, float, float, tuple[int, ...]]]:
    return [(sample.step, sample.label, sample.weight, sample.presses) for sample in samples]


def session(config: CreditConfig, *, steps: int = 4, step_s: float = 1.0) -> CreditAssigner:
    """Steps 0, 1, ... of one second each, the last still on screen."""
    assigner = CreditAssigner(config)
    for step in range(steps):
        assigner.step_shown(step, ns(step * step_s), features(step))
    return assigner


def test_individual_scheme_gives_one_sample_per_press_and_step_with_the_share_as_weight() -> None:
    assigner = session(CreditConfig(delay=UniformDelay(0.2, 0.8)))
    # Press at 3.4: window [2.6, 3.2]; step 2 has 0.4/0.6, step 3 0.2/0.6.
    given = assigner.add_press(0, ns(3.4), -1.0)
    assert given.steps == (2, 3)
    assert given.shares == pytest.approx((2 / 3, 1 / 3))
    [(step_a, label_a, weight_a, by_a), (step_b, label_b, weight_b, by_b)] = told(list(assigner.samples))
    assert (step_a, label_a, by_a) == (2, -1.0, (0,))
    assert (step_b, label_b, by_b) == (3, -1.0, (0,))
    assert (weight_a, weight_b) == pytest.approx((2 / 3, 1 / 3))
    assert assigner.samples[0].features.tolist() == [2.0, 1.0]


def test_aggregate_scheme_gives_one_sample_per_step_with_the_summed_label() -> None:
    assigner = session(CreditConfig(delay=UniformDelay(0.2, 0.8), scheme="aggregate"))
    assigner.add_press(0, ns(3.4), -1.0)  # 2/3 to step 2, 1/3 to step 3
    assigner.add_press(1, ns(3.6), 1.0)  # window [2.8, 3.4]: 1/3 to step 2, 2/3 to step 3
    assert not assigner.samples
    assigner.finish(ns(4))
    # step 2: -2/3 + 1/3, step 3: -1/3 + 2/3; steps 0 and 1 stay silent
    assert [(sample.step, sample.weight, sample.presses) for sample in assigner.samples] == [
        (2, 1.0, (0, 1)),
        (3, 1.0, (0, 1)),
    ]
    assert [sample.label for sample in assigner.samples] == pytest.approx([-1 / 3, 1 / 3])


def test_ten_presses_add_up_in_the_aggregate_scheme() -> None:
    assigner = session(CreditConfig(scheme="aggregate"))
    for press in range(10):
        assigner.add_press(press, ns(3.1) + press, 1.0)
    assigner.finish(ns(4))
    assert [(sample.step, sample.label) for sample in assigner.samples] == [(2, 10.0)]


def test_silence_is_a_zero_label_where_that_is_asked_for() -> None:
    assigner = session(CreditConfig(scheme="aggregate", silence="zero-label"))
    assigner.add_press(0, ns(2.5), 1.0)  # previous step: 1
    assigner.finish(ns(9))
    assert told(list(assigner.samples)) == [
        (0, 0.0, 1.0, ()),
        (1, 1.0, 1.0, (0,)),
        (2, 0.0, 1.0, ()),
        (3, 0.0, 1.0, ()),
    ]


@pytest.mark.parametrize(
    ("delay", "at_s", "given_out"),
    [
        # A step is given out once no press can reach it: previous step, when two steps have followed.
        (PreviousStep(), 3.1, 1),
        (PreviousStep(), 3.3, 2),
        (CurrentStep(), 3.1, 2),
        (CurrentStep(), 3.3, 3),
        # Uniform up to 0.8 s: step 2 ended at 3.0.
        (UniformDelay(), 3.9, 2),
        (UniformDelay(), 4.1, 3),
    ],
)
def test_aggregate_samples_are_given_out_when_no_press_can_reach_them(
    delay: PreviousStep | CurrentStep | UniformDelay, at_s: float, given_out: int
) -> None:
    assigner = session(CreditConfig(delay=delay, scheme="aggregate", silence="zero-label"))
    assigner.step_hidden(3, ns(at_s))
    assert len(assigner.samples) == given_out


def test_a_press_between_episodes_goes_back_to_the_step_that_was_on_screen() -> None:
    for delay in (UniformDelay(), PreviousStep()):
        assigner = session(CreditConfig(delay=delay))
        assigner.step_hidden(3, ns(4))
        given = assigner.add_press(0, ns(4.3), 1.0)
        assert given.steps == (3,)
    # Uniform: window [3.5, 4.1], of which [4.0, 4.1] showed nothing.
    assigner = session(CreditConfig(delay=UniformDelay()))
    assigner.step_hidden(3, ns(4))
    assert assigner.add_press(0, ns(4.3), 1.0).in_gaps == pytest.approx(0.1 / 0.6)


def test_a_covered_step_gets_nothing_for_the_time_it_was_covered() -> None:
    assigner = session(CreditConfig(delay=UniformDelay(0.0, 1.0)))
    assigner.step_hidden(3, ns(3.5))
    assigner.step_shown(3, ns(3.7), features(3))
    given = assigner.add_press(0, ns(4), 1.0)
    assert given.steps == (3,)
    assert given.shares == pytest.approx((0.8,))
    assert given.in_gaps == pytest.approx(0.2)
    assert len(assigner.samples) == 1


def test_the_account_holds_every_press() -> None:
    assigner = session(CreditConfig(delay=UniformDelay()))
    assigner.add_press(0, ns(0.5), 1.0)  # window [-0.3, 0.3]: half before the first step
    assigner.step_hidden(3, ns(4))
    assigner.add_press(1, ns(4.5), 1.0)  # window [3.7, 4.3]: half after the last step
    account = assigner.account
    assert account.presses == 2
    assert account.before_first == pytest.approx(0.5)
    assert account.in_gaps == pytest.approx(0.5)
    assert account.credited == pytest.approx(1.0)


def test_a_press_reported_far_too_late_is_accounted_for_and_changes_no_sample_given_out() -> None:
    assigner = session(CreditConfig(scheme="aggregate", silence="zero-label"))
    assigner.step_shown(4, ns(9), features(4))
    assert [sample.step for sample in assigner.samples] == [0, 1]
    late = assigner.add_press(0, ns(2.5), 1.0)  # speaks of step 1
    assert late.too_late == 1.0
    assert assigner.account.too_late == 1.0
    assert [sample.label for sample in assigner.samples] == [0.0, 0.0]


def test_a_burst_counts_as_its_first_press() -> None:
    assigner = session(CreditConfig(merge_within_s=0.3))
    assert assigner.add_press(0, ns(3.0), 1.0).merged_into is None
    assert assigner.add_press(1, ns(3.2), 1.0).merged_into == 0
    assert assigner.add_press(2, ns(3.45), 1.0).merged_into == 0  # 0.25 s after the press before
    assert assigner.add_press(3, ns(3.5), -1.0).merged_into is None  # another value
    assert assigner.add_press(4, ns(3.6), 1.0).merged_into is None  # the press before said something else
    assert [sample.presses for sample in assigner.samples] == [(0,), (3,), (4,)]
    assert (assigner.account.presses, assigner.account.merged) == (3, 2)


def test_every_press_counts_by_default() -> None:
    assigner = session(CreditConfig())
    for press in range(3):
        assigner.add_press(press, ns(3.0) + press, 1.0)
    assert len(assigner.samples) == 3


def test_retracting_the_first_press_of_a_burst_makes_the_second_one_count() -> None:
    assigner = session(CreditConfig(merge_within_s=0.3))
    assigner.add_press(0, ns(3.0), 1.0)
    assigner.add_press(1, ns(3.2), 1.0)
    assigner.retract(0)
    assert [sample.presses for sample in assigner.samples] == [(1,)]


def test_take_gives_each_sample_once() -> None:
    assigner = session(CreditConfig())
    assigner.add_press(0, ns(3.1), 1.0)
    assert [sample.presses for sample in assigner.take()] == [(0,)]
    assert not assigner.take()
    assigner.add_press(1, ns(3.2), 1.0)
    assert [sample.presses for sample in assigner.take()] == [(1,)]
    assigner.retract(0)
    assert not assigner.take()
    assert [sample.presses for sample in assigner.samples] == [(1,)]


def test_reports_of_the_screen_may_cross_by_a_little() -> None:
    assigner = session(CreditConfig(delay=UniformDelay()))
    assigner.step_hidden(3, ns(4))
    assigner.step_shown(4, ns(3.9), features(4))  # known to be hidden until 4.0: shown from there on
    given = assigner.add_press(0, ns(4.5), 1.0)  # window [3.7, 4.3]
    assert given.shares == pytest.approx((0.5, 0.5))
    assert given.in_gaps == pytest.approx(0.0, abs=1e-12)


def test_the_configuration_survives_a_recordings_header() -> None:
    config = CreditConfig(delay=GammaDelay(3.0, 0.2, 0.1), scheme="aggregate", silence="zero-label")
    assert msgspec.json.decode(msgspec.json.encode(config), type=CreditConfig) == config
    assert msgspec.toml.decode(b'[delay]\ntype = "uniform"\nlow_s = 0.1', type=CreditConfig) == CreditConfig(
        delay=UniformDelay(low_s=0.1)
    )


def test_what_cannot_be_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="needs scheme='aggregate'"):
        CreditConfig(silence="zero-label")
    with pytest.raises(ValueError, match="merge_within_s"):
        CreditConfig(merge_within_s=-1)
    assigner = session(CreditConfig())
    with pytest.raises(ValueError, match="must not go back"):
        assigner.step_shown(2, ns(5), features(2))
    with pytest.raises(ValueError, match="must not go back"):
        assigner.step_shown(4, ns(2), features(4))
    with pytest.raises(ValueError, match="never shown"):
        assigner.step_hidden(9, ns(5))
    with pytest.raises(ValueError, match="must not go back"):
        assigner.step_hidden(3, ns(2))
    with pytest.raises(ValueError, match="got nan"):
        assigner.add_press(0, ns(3), float("nan"))
    assigner.add_press(1, ns(3), 1.0)
    with pytest.raises(ValueError, match="given already"):
        assigner.add_press(1, ns(3), 1.0)
    with pytest.raises(ValueError, match="cannot be retracted"):
        assigner.retract(7)
    assigner.finish(ns(5))
    with pytest.raises(ValueError, match="was finished"):
        assigner.add_press(2, ns(6), 1.0)


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


EPISODE_S = 40.0


def play_episodes(assigner: CreditAssigner, n_episodes: int, *, begins: bool) -> list[object]:
    """Play episodes of steps of half a second; in each, a press is taken back, some in the next episode."""
    given: list[object] = []
    settled: list[FeedbackSample] = []
    held = -1
    for episode in range(n_episodes):
        began_s, first = episode * EPISODE_S, episode * 60
        if begins:
            settled.extend(assigner.episode_begins())
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
    return [*given, told([*settled, *assigner.samples]), assigner.account]


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
        assert len(assigner.samples) <= 2 * 2 * 9  # two episodes of nine presses, each for two steps at most
        assert len(assigner._known) <= 2 * 9


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
