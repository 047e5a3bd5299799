"""Which key presses count as feedback."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.events import KeyPressed, PressRetracted
from core.feedback.keys import KeyConfig, PressGate
from core.numerics.clock import NS_PER_MS, NS_PER_S


def playing(**settings) -> PressGate:
    gate = PressGate(KeyConfig(**settings))
    gate.episode_started()
    gate.frame, gate.step = 3, 2
    return gate


def verdicts(gate: PressGate, *presses: tuple[str, int]) -> list[str]:
    """Press each (key, time in ms) and return what became of it, retractions included."""
    return [
        record.verdict if isinstance(record, KeyPressed) else f"retracted {record.press}: {record.reason}"
        for key, time_ms in presses
        for record in gate.judge(key, time_ms * NS_PER_MS)
    ]


def test_a_good_and_a_bad_key_count_with_their_value_and_the_frame_on_screen():
    gate = playing()
    [good] = gate.judge("j", NS_PER_S)
    [bad] = gate.judge("f", 2 * NS_PER_S)
    assert (good.value, bad.value) == (1.0, -1.0)
    assert (good.verdict, good.frame, good.step, good.time_ns) == ("accepted", 3, 2, NS_PER_S)


def test_any_other_key_is_recorded_and_does_not_count():
    assert verdicts(playing(), ("x", 0), ("left_shift", 500)) == ["other", "other"]


def test_presses_beyond_the_budget_are_refused_until_the_next_episode():
    gate = playing(max_presses_per_episode=2)
    assert verdicts(gate, ("j", 0), ("f", 1000), ("j", 2000)) == ["accepted", "accepted", "no-presses-left"]
    gate.episode_started()
    assert gate.presses_left == 2
    assert verdicts(gate, ("j", 3000)) == ["accepted"]


def test_nothing_counts_before_the_first_episode_or_behind_a_pause():
    gate = PressGate(KeyConfig())
    assert verdicts(gate, ("j", 0)) == ["not-playing"]
    gate.episode_started()
    gate.covered = True
    assert verdicts(gate, ("j", 1000), ("u", 2000)) == ["covered", "other"]


def test_the_retract_key_takes_the_last_accepted_press_back_and_its_budget():
    gate = playing(max_presses_per_episode=2)
    assert verdicts(gate, ("j", 0), ("f", 1000), ("u", 2000)) == [
        "accepted",
        "accepted",
        "other",
        "retracted 1: participant",
    ]
    assert gate.presses_left == 1
    assert verdicts(gate, ("u", 3000), ("u", 4000)) == ["other", "retracted 0: participant", "other"]


def test_a_double_hit_within_the_refractory_time_is_a_repeat():
    assert verdicts(playing(), ("j", 0), ("j", 60), ("j", 400)) == ["accepted", "repeat", "accepted"]


def test_two_different_keys_in_a_row_are_two_presses():
    assert verdicts(playing(), ("j", 0), ("f", 60)) == ["accepted", "accepted"]


def test_a_held_key_counts_once():
    # Press at 0, the terminal's first repeat after 400 ms, then one every 33 ms.
    gate = playing()
    seen = verdicts(gate, ("j", 0), ("j", 400), ("j", 433), ("j", 466), ("j", 499))
    assert seen == ["accepted", "accepted", "repeat", "repeat", "retracted 1: auto-repeat", "repeat"]
    assert gate.presses_left == gate.config.max_presses_per_episode - 1


def test_two_deliberate_presses_are_not_taken_for_a_held_key():
    assert verdicts(playing(), ("j", 0), ("j", 400), ("j", 700)) == ["accepted"] * 3


def test_a_press_that_was_asked_for_wrongly_says_so_once():
    gate = playing()
    gate.wrong_asked = True
    [other] = gate.judge("x", 0)
    [wrong] = gate.judge("f", NS_PER_S)
    [next_press] = gate.judge("j", 2 * NS_PER_S)
    assert (other.asked_wrong, wrong.asked_wrong, next_press.asked_wrong) == (False, True, False)


@given(
    st.lists(
        st.tuples(st.sampled_from("jfux"), st.integers(min_value=1, max_value=1200)), min_size=1, max_size=40
    )
)
def test_the_budget_is_never_exceeded_and_every_press_is_recorded(presses):
    gate = playing(max_presses_per_episode=3)
    time_ns, standing, recorded = 0, set(), 0
    for key, gap_ms in presses:
        time_ns += gap_ms * NS_PER_MS
        for record in gate.judge(key, time_ns):
            if isinstance(record, PressRetracted):
                standing.remove(record.press)
            else:
                assert record.press == recorded
                recorded += 1
                if record.verdict == "accepted":
                    standing.add(record.press)
        assert len(standing) == 3 - gate.presses_left <= 3
    assert recorded == len(presses)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"good": "escape"}, "one lower-case letter"),
        ({"good": "1"}, "one lower-case letter"),
        ({"good": "J"}, "one lower-case letter"),
        ({"good": "f"}, "three different keys"),
        ({"wrong_press_rate": 1.5}, "fraction in"),
        ({"max_presses_per_episode": -1}, ">= 0"),
    ],
)
def test_unusable_settings_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        KeyConfig(**settings)
