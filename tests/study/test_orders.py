"""Orders of conditions are balanced."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.orders import balanced_latin_square, least_used_order, possible_orders

COUNTS = range(1, 9)
AB_BA = possible_orders(["manual", "assisted"], "ab_ba")


@pytest.mark.parametrize("count", COUNTS)
def test_each_condition_stands_in_each_place_equally_often(count: int) -> None:
    """Every column of the square holds every condition the same number of times."""
    rows = balanced_latin_square(count)
    assert all(sorted(row) == list(range(count)) for row in rows)
    assert len(set(rows)) == len(rows)
    for place in range(count):
        times = Counter(row[place] for row in rows)
        assert set(times) == set(range(count))
        assert len(set(times.values())) == 1


@pytest.mark.parametrize("count", COUNTS)
def test_each_condition_follows_each_other_equally_often(count: int) -> None:
    """Carry-over is balanced, as Williams's design promises."""
    follows = Counter(pair for row in balanced_latin_square(count) for pair in pairwise(row))
    assert len(follows) == count * (count - 1)
    assert len(set(follows.values())) <= 1


def test_ab_ba_is_both_orders_as_listed_first() -> None:
    """Two conditions run in the protocol's order and in its reverse."""
    assert AB_BA == [("manual", "assisted"), ("assisted", "manual")]


def test_fixed_is_the_order_listed() -> None:
    """A fixed design has one order."""
    assert possible_orders(["b", "a", "c"], "fixed") == [("b", "a", "c")]


@given(st.integers(0, 60), st.lists(st.sampled_from(AB_BA), max_size=1))
def test_least_used_order_balances_ab_and_ba(sessions: int, before: list[tuple[str, ...]]) -> None:
    """Given out one by one, AB and BA never differ by more than one."""
    used = list(before)
    for _ in range(sessions):
        used.append(least_used_order(AB_BA, used))
        counts = Counter(used)
        assert abs(counts[AB_BA[0]] - counts[AB_BA[1]]) <= 1


@given(st.lists(st.sampled_from([*AB_BA, ("other", "study")]), max_size=40))
def test_least_used_order_mends_any_imbalance(used: list[tuple[str, ...]]) -> None:
    """Whatever was given out before, the order used less often comes next; ties to the first."""
    first, second = (used.count(order) for order in AB_BA)
    assert least_used_order(AB_BA, used) == AB_BA[0 if first <= second else 1]
