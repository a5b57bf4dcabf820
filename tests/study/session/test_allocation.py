"""Which robot a scorer chooses, for any scores and any fleet."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from study.session.allocation import AssistedAllocation, best_robot
from study.session.controls import Controls

fleets = st.integers(1, 12).flatmap(
    lambda n: st.tuples(
        st.lists(
            st.sampled_from([np.nan, np.inf, -np.inf, -1.0, 0.0, -0.0, 1.0, 2.5]),
            min_size=n,
            max_size=n,
        ),
        st.lists(st.booleans(), min_size=n, max_size=n),
    )
)


@given(fleets)
def test_best_robot(fleet: tuple[list[float], list[bool]]) -> None:
    """It is available; no available number beats it; of equals it is the first; never NaN."""
    scores, available = np.array(fleet[0]), np.array(fleet[1])
    best = best_robot(scores, available)
    if not available.any():
        assert best == -1
        return
    assert available[best]
    numbers = [robot for robot in np.flatnonzero(available) if not np.isnan(scores[robot])]
    if numbers:
        assert best == min(robot for robot in numbers if scores[robot] == max(scores[numbers]))
    else:
        assert best == int(np.flatnonzero(available)[0])


@given(st.lists(st.booleans(), min_size=1, max_size=12))
def test_without_scores_all_tie(available: list[bool]) -> None:
    """Where no scorer is in force, the first available robot is chosen."""
    expected = available.index(True) if any(available) else -1
    assert best_robot(np.empty(0), np.array(available)) == expected


def test_without_scores_no_switch_is_promised() -> None:
    """Where the scorer could not be fitted, no ring counts down to a switch that will not come."""
    allocation = AssistedAllocation(15)
    assert allocation.rechoose(np.empty(0), np.ones(3, bool)) == "start"
    assert allocation.dwell_left() == -1.0
    allocation.rechoose(np.zeros(3), np.ones(3, bool))
    assert allocation.dwell_left() == 1.0


@settings(max_examples=30)
@given(dwell=st.integers(1, 20), data=st.data())
def test_assisted_never_switches_early_nor_late(dwell: int, data: st.DataObject) -> None:
    """Between switches lie ``dwell`` timesteps unless the operated robot ended."""
    allocation = AssistedAllocation(dwell)
    since, operated = 0, -1
    for _ in range(60):
        available = np.array(data.draw(st.lists(st.booleans(), min_size=3, max_size=3)))
        scores = np.array(data.draw(st.lists(st.floats(), min_size=3, max_size=3)))
        cause = allocation.rechoose(scores, available)
        due = operated < 0 or not available[operated] or since >= dwell
        if due and available.any():
            assert allocation.operated == best_robot(scores, available)
            assert (cause == "") == (allocation.operated == operated)
            since, operated = 0, allocation.operated
        else:
            assert cause == ""
            assert allocation.operated == operated
        assert 0.0 <= allocation.dwell_left() <= 1.0
        allocation.timestep_done(driven=False)
        since += 1


@given(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from(["down", "up", "step", "lost"]))))
def test_newest_key_held_or_tapped(moves: list[tuple[str, str]]) -> None:
    """The acting key is the one pressed last among those held or tapped since the last step."""
    controls = Controls()
    presses: list[str] = []
    held: set[str] = set()
    tapped: set[str] = set()
    for key, move in moves:
        if move == "down":
            controls.press(key)
            presses.append(key)
            held.add(key)
            tapped.add(key)
        elif move == "up":
            controls.release(key)
            held.discard(key)
        elif move == "step":
            controls.timestep_done()
            tapped.clear()
        else:
            controls.release_all()
            held.clear()
            tapped.clear()
        acting = held | tapped
        newest = next((key for key in reversed(presses) if key in acting), None)
        assert controls.newest() == newest
