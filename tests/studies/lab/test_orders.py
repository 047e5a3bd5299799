"""Orders of conditions: balanced, and the same for the same seed."""

from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.lab.orders import order_of, orders_per_cycle, williams_square
from tests.studies.lab.examples import study_of


def test_a_square_of_four_by_hand():
    # The zigzag 0, 1, n-1, 2 of Williams, and each row one further.
    assert williams_square(4) == ((0, 1, 3, 2), (1, 2, 0, 3), (2, 3, 1, 0), (3, 0, 2, 1))


@pytest.mark.parametrize("n", range(1, 10))
def test_every_condition_comes_equally_often_at_every_position_and_after_every_other(n):
    square = williams_square(n)
    for column in zip(*square, strict=True):
        assert set(Counter(column).values()) == {len(square) // n}
    following = Counter(pair for row in square for pair in pairwise(row))
    assert len(following) == n * (n - 1)
    assert len(set(following.values())) <= 1


def test_a_square_without_conditions_is_refused():
    with pytest.raises(ValueError, match="at least one condition, got 0"):
        williams_square(0)


@given(seed=st.integers(0, 2**63 - 1), n=st.integers(1, 5), cycles=st.integers(1, 3))
def test_places_of_whole_cycles_are_balanced(seed, n, cycles):
    study = study_of(conditions=n, assignment={"type": "latin-square"}, seed=seed)
    orders = [order_of(study, place) for place in range(cycles * orders_per_cycle(study))]
    for position in zip(*orders, strict=True):
        assert len(set(Counter(position).values())) == 1


@given(seed=st.integers(0, 2**63 - 1), n=st.integers(1, 5), each=st.integers(1, 4))
def test_permuted_blocks_hold_every_condition_equally_often(seed, n, each):
    study = study_of(conditions=n, assignment={"type": "permuted-blocks", "each": each}, seed=seed)
    size = orders_per_cycle(study)
    second = [order_of(study, place) for place in range(size, 2 * size)]
    assert Counter(second) == dict.fromkeys({(f"c{k}",) for k in range(n)}, each)


def test_another_seed_gives_other_orders_and_the_same_seed_the_same():
    def orders(seed):
        study = study_of(conditions=4, assignment={"type": "latin-square"}, seed=seed)
        return [order_of(study, place) for place in range(16)]

    assert orders(1) == orders(1)
    assert orders(1) != orders(2)


def test_listed_orders_begin_again_after_the_last():
    study = study_of(conditions=2, assignment={"type": "list", "orders": [["c0", "c1"], ["c1", "c0"]]})
    assert [order_of(study, place) for place in range(3)] == [("c0", "c1"), ("c1", "c0"), ("c0", "c1")]


def test_several_rounds_go_through_the_orders_of_the_square_and_stay_balanced():
    steps = [{"type": "consent", "text": "consent.md"}, *[{"type": "block"}] * 6]
    study = study_of(conditions=3, sittings=[{"name": "day 1", "steps": steps}])
    orders = [order_of(study, place) for place in range(orders_per_cycle(study))]
    assert all(sorted(order[:3]) == sorted(order[3:]) == ["c0", "c1", "c2"] for order in orders)
    assert all(order[:3] != order[3:] for order in orders)
    for position in zip(*orders, strict=True):
        assert set(Counter(position).values()) == {2}
