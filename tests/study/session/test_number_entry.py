"""Robots chosen by number: keys, and digits typed where there are more robots than keys."""

from __future__ import annotations

import pytest

from study.session.number_entry import SECOND_DIGIT_NS, NumberEntry

KEYS = ("1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "=")


def test_each_key_is_a_robot_where_there_are_enough() -> None:
    """With twelve robots every key of the row chooses at once."""
    entry = NumberEntry(KEYS, 12)
    assert [entry.press(key, 0) for key in KEYS] == [(robot,) for robot in range(12)]
    assert entry.press("x", 0) == ()


@pytest.mark.parametrize(("keys", "robot"), [("5", 4), ("05", 4), ("12", 11), ("20", 19), ("9", 8)])
def test_typed_numbers(keys: str, robot: int) -> None:
    """Among twenty robots a number is chosen by its digits, at once if it cannot go on."""
    entry = NumberEntry(KEYS, 20)
    chosen = [robot for place, key in enumerate(keys) for robot in entry.press(key, place)]
    assert chosen == [robot]


def test_a_first_digit_waits_and_then_counts_alone() -> None:
    """1 could begin 12: it chooses robot 1 only when no digit follows in time."""
    entry = NumberEntry(KEYS, 20)
    assert entry.press("1", 0) == ()
    assert entry.due(SECOND_DIGIT_NS - 1) == ()
    assert entry.due(SECOND_DIGIT_NS) == (0,)
    assert entry.due(9 * SECOND_DIGIT_NS) == ()


def test_no_robot_beyond_the_fleet() -> None:
    """A number that no robot has chooses none."""
    entry = NumberEntry(KEYS, 20)
    assert (*entry.press("2", 0), *entry.press("9", 1)) == ()
    assert (*entry.press("0", 2), *entry.press("0", 3)) == ()
