"""Graded feedback: five keys, labels by value, and a density of the delay for each value."""

import itertools

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.configuration.reading import ConfigurationError
from core.feedback.assigner import CreditAssigner
from core.feedback.config import CreditConfig
from core.feedback.delays import (
    GammaDelay,
    PerValueDelay,
    PreviousStep,
    UniformDelay,
    ValueDelay,
    describe,
    one_density,
    parse_delay,
    rule_for,
)
from core.feedback.keys import KeyConfig, PressGate
from core.feedback.trainers import graded_judgement
from core.numerics.clock import NS_PER_S
from core.session.protocol_reading import protocol_from

GRADED = KeyConfig(graded=("d", "f", "g", "h", "j"))
BY_VALUE = PerValueDelay(
    (ValueDelay(2.0, UniformDelay(0.0, 1.0)), ValueDelay(0.0, UniformDelay(1.0, 2.0))), UniformDelay(2.0, 3.0)
)


def ns(seconds: float) -> int:
    return round(seconds * NS_PER_S)


def test_five_keys_say_minus_2_to_2_from_left_to_right():
    assert [GRADED.value(key) for key in "dfghjk"] == [-2.0, -1.0, 0.0, 1.0, 2.0, None]
    assert [GRADED.key_of(value) for value in (-2.0, -1.0, 0.0, 1.0, 2.0)] == list("dfghj")
    assert GRADED.letters == ("d", "f", "g", "h", "j", "u")


def test_a_press_of_0_counts():
    gate = PressGate(GRADED)
    gate.episode_started()
    (record,) = gate.judge("g", 0)
    assert (record.value, record.verdict, gate.presses_left) == (0.0, "accepted", 4)


@pytest.mark.parametrize(
    "graded", [["d"], ["d", "f", "g", "h"], ["d", "f", "g", "h", "h"], ["d", "f", "g", "h", "u"]]
)
def test_any_other_keys_are_refused(graded):
    with pytest.raises(ConfigurationError, match=r"graded"):
        protocol_from({"keys": {"graded": graded}}, to_run=True)


def test_good_and_bad_have_no_effect_beside_grades():
    with pytest.raises(ConfigurationError, match="good"):
        protocol_from({"keys": {"graded": list("dfghj"), "good": "k"}}, to_run=True)


def test_a_grade_is_no_answer_to_a_question():
    asking = {"per_episode": 1, "keys": ["1", "2", "g"]}
    with pytest.raises(ConfigurationError, match=r"is one of keys\.graded"):
        protocol_from({"keys": {"graded": list("dfghj")}, "agent": {"asking": asking}}, to_run=True)
    asking["keys"] = ["1", "2", "f"]
    with pytest.raises(ConfigurationError, match=r"is keys\.bad"):
        protocol_from({"agent": {"asking": asking}}, to_run=True)


def assigner(delay, **changes) -> CreditAssigner:
    """Four steps of a second each, from 0 s."""
    found = CreditAssigner(CreditConfig(delay=delay, **changes))
    for step in range(4):
        found.step_shown(step, ns(step), np.array([float(step)]))
    return found


def test_credit_goes_by_the_density_of_the_value_and_the_label_by_the_value():
    """At 3.0 s: 2 speaks of the last second (step 2), 0 of the one before (step 1), -1 of step 0."""
    credit = assigner(BY_VALUE)
    assert credit.add_press(0, ns(3.0), 2.0).steps == (2,)
    assert credit.add_press(1, ns(3.0), 0.0).steps == (1,)
    assert credit.add_press(2, ns(3.0), -1.0).steps == (0,)
    assert [(sample.step, sample.label, sample.weight) for sample in credit.samples] == [
        (2, 2.0, pytest.approx(1.0)),
        (1, 0.0, pytest.approx(1.0)),
        (0, -1.0, pytest.approx(1.0)),
    ]


def test_aggregate_credit_waits_for_the_slowest_value():
    """A step's sample is given out when no press of any value can reach it: after 3 s, not after 1 s."""
    credit = assigner(BY_VALUE, scheme="aggregate")
    credit.step_shown(4, ns(4.0), np.array([4.0]))
    given_late = credit.add_press(0, ns(4.0), -1.0)  # of what was shown from 1.0 to 2.0 s
    assert (given_late.steps, given_late.too_late) == ((1,), 0.0)


@given(
    st.lists(st.sampled_from([-2.0, -1.0, 0.0, 1.0, 2.0]), max_size=5),
    st.floats(3.0, 3.9),
)
def test_one_density_for_every_value_is_the_same_as_one_for_all(values, at_s):
    one = GammaDelay(2.2, 0.4)
    same = PerValueDelay(tuple(ValueDelay(value, one) for value in (-2.0, 0.0, 2.0)), one)
    found = []
    for delay in (one, same):
        credit = assigner(delay)
        found.append([credit.add_press(n, ns(at_s), value) for n, value in enumerate(values)])
    assert found[0] == found[1]


def test_the_defaults_have_the_medians_that_were_measured():
    delay = PerValueDelay()
    for value, median_s in ((2.0, 0.75), (-2.0, 0.75), (1.0, 1.15), (-1.0, 1.15), (0.0, 1.53)):
        assert float(delay.for_value(value).cdf(median_s)) == pytest.approx(0.5, abs=0.002)
    assert delay.horizon_s == max(density.horizon_s for density in delay.densities)
    assert rule_for(delay, 3.0) == delay.other
    assert rule_for(PreviousStep(), 2.0) == PreviousStep()


@pytest.mark.parametrize(
    "delay", [PerValueDelay(), BY_VALUE, PerValueDelay((), GammaDelay(2.0, 0.5, 0.1))], ids=str
)
def test_the_text_of_a_rule_reads_back_as_the_rule(delay):
    assert parse_delay(describe(delay)) == delay


def test_per_value_alone_is_the_measured_table():
    assert parse_delay("per-value") == PerValueDelay()


@pytest.mark.parametrize(
    "text", ["per-value:2", "per-value:2=previous", "per-value:two=gamma", "per-value:2=gamma;2=uniform"]
)
def test_a_text_that_is_no_table_is_refused(text):
    with pytest.raises(ValueError, match="per-value"):
        parse_delay(text)


def test_a_protocol_says_densities_by_value():
    plain = {
        "agent": {
            "credit": {
                "delay": {
                    "type": "per-value",
                    "values": [{"value": 2, "delay": {"type": "gamma", "scale_s": 0.2}}],
                }
            }
        }
    }
    found = protocol_from(plain, to_run=True)
    assert found.agent.credit.delay == PerValueDelay((ValueDelay(2.0, GammaDelay(2.5, 0.2)),), GammaDelay())
    assert protocol_from(msgspec.to_builtins(found)) == found
    plain["agent"]["credit"]["delay"]["values"][0]["delay"] = {"type": "gamma", "scale_s": 7.5}
    with pytest.raises(ConfigurationError, match="milliseconds"):
        protocol_from(plain, to_run=True)


def test_experiments_have_one_density_for_all():
    assert one_density(GammaDelay()) == GammaDelay()
    with pytest.raises(ValueError, match="one density"):
        one_density(PerValueDelay())


def test_a_simulated_participant_is_sure_of_the_best_and_of_the_worst():
    """Of eight actions the best two are good (a quarter); one of them very good; the worst three very bad."""
    values = np.arange(8.0)[::-1]
    grades = [graded_judgement(values, action, good_share=0.25) for action in range(8)]
    assert grades == [2.0, 1.0, -1.0, -1.0, -1.0, -2.0, -2.0, -2.0]
    near = [graded_judgement(values, action, good_share=0.25, skip_margin=0.2) for action in range(8)]
    assert near == [2.0, 0.0, 0.0, 0.0, -1.0, -2.0, -2.0, -2.0]
    assert all(a >= b for a, b in itertools.pairwise(grades))
