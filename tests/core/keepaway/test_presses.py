"""Presses in compiled play: in order of time, and the same ones count as at the gate of a live session."""

from hypothesis import given, settings
from hypothesis import strategies as st

from core.feedback.keys import KeyConfig, PressGate
from core.keepaway.presses import LOST, WAITING, is_due, make, new_presses, plan, renew_budget

MS = 1_000_000
KEYS = KeyConfig(max_presses_per_episode=2)


@given(
    st.lists(st.tuples(st.integers(0, 3000), st.sampled_from([1.0, -1.0])), max_size=12), st.integers(0, 11)
)
@settings(max_examples=200, deadline=None)
def test_what_counts_is_what_the_gate_lets_through(plans, new_episode_after):
    presses, gate = new_presses(KEYS, 16), PressGate(KEYS)
    gate.episode_started()
    for number, (time_ms, value) in enumerate(plans):
        plan(presses, time_ms * MS, value, number, False)
    in_order = sorted(range(len(plans)), key=lambda k: (plans[k][0], k))
    for n_made, number in enumerate(in_order):
        if n_made == new_episode_after:
            renew_budget(presses)
            gate.episode_started()
        time_ms, value = plans[number]
        assert not is_due(presses, time_ms * MS - 1)
        assert is_due(presses, time_ms * MS)
        first = list(gate.judge("j" if value > 0 else "f", time_ms * MS))
        if len(first) > 1:
            return  # three presses within 160 ms: a held key, which the participants here never make
        assert make(presses) == (first[0].verdict == "accepted")
    assert presses.counts[WAITING] == 0


def test_a_press_without_room_is_noticed():
    presses = new_presses(KEYS, 2)
    for time_ns in (3, 1, 2):
        plan(presses, time_ns, 1.0, 0, False)
    assert presses.counts[LOST] == 1
    assert presses.due_ns.tolist() == [1, 3]
