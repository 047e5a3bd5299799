"""Counting agreement: the one kernel against plain Python, and a session's count of several participants."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.combination.agreement import Agreement
from core.combination.sides import Decision
from core.combination.tally import EpisodeTally, agreement_of, compare_choices, count_decision, new_tally

VALUES = st.lists(st.integers(-2, 2), min_size=1, max_size=6)


def test_a_decision_by_hand():
    tally = new_tally()
    assert agreement_of(tally) is None
    count_decision(tally, 2, 2, 0)  # the best
    count_decision(tally, 2, 1, 2)  # the worst
    count_decision(tally, 2, 1, 0)  # neither
    count_decision(tally, 0, 0, 0)  # the only action: best and worst
    assert agreement_of(tally) == Agreement(4, 2, 2)


@given(st.lists(st.tuples(VALUES, VALUES, st.integers(0, 63)), min_size=1, max_size=8))
def test_choices_are_compared_as_in_plain_python(decisions: list[tuple[list[int], list[int], int]]):
    tally, expected = new_tally(), [0, 0, 0]
    for r, h, mask in decisions:
        n = min(len(r), len(h))
        open_actions = [a for a in range(n) if not mask >> a & 1] or [0]
        ruled_out = np.array([bool(mask >> a & 1) for a in range(n)])
        own = max(open_actions, key=lambda a: r[a])
        best = max(open_actions, key=lambda a: h[a])
        worst = min(open_actions, key=lambda a: h[a])
        expected = [expected[0] + 1, expected[1] + (own == best), expected[2] + (own == worst)]
        found = compare_choices(np.array(r, float), np.array(h, float), ruled_out, n, tally)
        assert found == best
    assert tally.tolist() == expected


def test_a_session_counts_each_participant_from_their_first_press_on():
    tally = EpisodeTally()
    assert (tally.agreement, tally.with_each) == (None, ())
    tally.add(Decision(0, 0, -1, -1))  # there is no human policy yet
    tally.add(Decision(0, 0, 0, 1, ((0, 1), (-1, -1))))
    tally.add(Decision(1, 1, 0, 1, ((0, 1), (1, 0))))
    assert tally.agreement == Agreement(2, 1, 1)
    assert tally.with_each == (Agreement(2, 1, 1), Agreement(1, 1, 0))


@pytest.mark.parametrize("counts", [(0, 0, 0), (3, 4, 0), (3, 0, 4), (3, -1, 0)])
def test_agreement_that_cannot_be_is_refused(counts: tuple[int, int, int]):
    with pytest.raises(ValueError, match="decision"):
        Agreement(*counts)
