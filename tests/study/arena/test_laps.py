"""Laps cannot be cheated."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lap_driver import on_ellipse
from study.arena.course import TWO_BUCKETS
from study.arena.laps import LONGEST_MOVE, Progress, advance

START = -math.pi / 4
QUARTER = math.pi / 2

turns = st.lists(st.floats(-0.3, 0.3), min_size=1, max_size=300)
places = st.lists(
    st.tuples(st.floats(0.0, TWO_BUCKETS.width), st.floats(0.0, TWO_BUCKETS.height)),
    min_size=2,
    max_size=30,
)


def walk(waypoints: list[tuple[float, float]]) -> Progress:
    """Count laps along straight lines, in steps shorter than a robot is."""
    progress, here = Progress(), waypoints[0]
    for there in waypoints[1:]:
        steps = math.ceil(math.dist(here, there) / 0.05) or 1
        for number in range(1, steps + 1):
            place = tuple(a + (b - a) * number / steps for a, b in zip(here, there, strict=True))
            before = tuple(
                a + (b - a) * (number - 1) / steps for a, b in zip(here, there, strict=True)
            )
            progress = advance(TWO_BUCKETS, progress, (before[0], before[1]), (place[0], place[1]))
        here = there
    return progress


@given(turns)
def test_round_the_ring_the_count_is_that_of_the_angle(steps: list[float]) -> None:
    """Gates passed and laps follow from the unwrapped angle alone, however it wanders."""
    angle, progress = START, Progress()
    # The quarter in which the present lap began, counted on over whole turns.
    began, laps = math.floor(START / QUARTER), 0
    for step in steps:
        # Exactly on a gate's line, rounding decides the side.
        if abs(math.remainder(angle + step, QUARTER)) < 1e-6:
            continue
        progress = advance(TWO_BUCKETS, progress, on_ellipse(angle), on_ellipse(angle + step))
        angle += step
        quarter = math.floor(angle / QUARTER)
        if quarter <= began - 4:
            began -= 4
        elif quarter == began + 4:
            began, laps = quarter, laps + 1
        assert progress == Progress(max(0, quarter - began), laps)


@given(turns)
def test_a_lap_costs_a_whole_turn(steps: list[float]) -> None:
    """Going back and forth earns no more laps than the way forward has turns."""
    angle, progress, forward = START, Progress(), 0.0
    for step in steps:
        progress = advance(TWO_BUCKETS, progress, on_ellipse(angle), on_ellipse(angle + step))
        angle += step
        forward += max(0.0, step)
    assert progress.laps * 2 * math.pi <= forward + START % QUARTER + 1e-9


@pytest.mark.parametrize("left_out", range(4))
@given(waypoints=places)
def test_who_leaves_out_a_gate_earns_nothing(
    left_out: int, waypoints: list[tuple[float, float]]
) -> None:
    """Whatever way is driven in the part of the arena that one gate does not reach: no lap."""
    gate = TWO_BUCKETS.gates[left_out]
    low_x, high_x = sorted((gate.inner_x, gate.outer_x))
    low_y, high_y = sorted((gate.inner_y, gate.outer_y))

    def kept_off(place: tuple[float, float]) -> tuple[float, float]:
        """Press a place into the half that the gate is not in, a centimetre off its inner end."""
        x, y = place
        if low_y == high_y:
            part = x / TWO_BUCKETS.width
            left, right = (0.0, low_x - 0.01) if low_x > 2 else (high_x + 0.01, 4.0)
            return left + part * (right - left), y
        part = y / TWO_BUCKETS.height
        bottom, top = (0.0, low_y - 0.01) if low_y > 1 else (high_y + 0.01, 3.0)
        return x, bottom + part * (top - bottom)

    assert walk([kept_off(place) for place in waypoints]).laps == 0


def test_through_the_middle_of_a_bucket() -> None:
    """Where no robot can be, a gate's very end belongs to the gate."""
    through = [(3.325, 1.0), (1.3, 3.0), (1.3, 0.0), (2.65, 0.0)]
    assert walk(through).laps == 1


def test_a_way_round_one_bucket_is_no_lap() -> None:
    """Between the buckets leads no lap, either way round; round both does."""
    right = [(2.5, 0.6), (3.4, 0.6), (3.4, 2.4), (1.9, 2.4), (1.9, 0.6), (2.5, 0.6)]
    assert walk(right * 5).laps == 0
    assert walk(right[::-1] * 5).laps == 0
    both = [(2.5, 0.6), (3.4, 0.6), (3.4, 2.4), (0.6, 2.4), (0.6, 0.6), (2.5, 0.6)]
    assert walk(both * 5) == Progress(0, 5)
    assert walk(both[::-1] * 5).laps == 0


def test_over_the_finish_line_and_back() -> None:
    """The finish line earns one lap a lap, not one a crossing."""
    both = [(2.5, 0.6), (3.4, 0.6), (3.4, 2.4), (0.6, 2.4), (0.6, 0.6), (2.1, 0.6)]
    assert walk(both + [(1.9, 0.6), (2.1, 0.6)] * 10).laps == 1


def test_a_robot_that_is_carried_passes_no_gate() -> None:
    """A jump longer than a robot can drive counts nothing."""
    low, high = (3.5, 1.5 - LONGEST_MOVE), (3.5, 1.5 + LONGEST_MOVE)
    assert advance(TWO_BUCKETS, Progress(), low, high) == Progress()
    assert advance(TWO_BUCKETS, Progress(), (3.5, 1.4), (3.5, 1.6)) == Progress(passed=1)
