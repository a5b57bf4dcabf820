"""What is recorded of a fleet run's punctuality."""

from __future__ import annotations

import gc
import math
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.shell.punctuality import COARSE_NS, FINE_NS, RESOLUTION_NS, Punctuality

MS = 1_000_000
PERIOD = 16_666_667
A_MINUTE = 60 * 250


def test_late_pictures_are_those_over_a_fifth_too_long() -> None:
    """20.0 ms is within 1.2 periods of 60 Hz, 20.1 ms is not."""
    own = Punctuality(PERIOD)
    for interval in (PERIOD, PERIOD, 20 * MS, 20_100_000, 50 * MS):
        own.frame(interval)
    made = own.summary(7, 3)
    assert (made.t_ns, made.trial_id, made.frames, made.late_frames) == (7, 3, 5, 2)
    assert made.period == pytest.approx(1 / 60, abs=1e-9)
    assert made.frame_max == 0.05
    assert made.frame_mean == pytest.approx((2 * PERIOD / 1e9 + 0.02 + 0.0201 + 0.05) / 5)


def test_a_pause_is_no_interval_between_timesteps() -> None:
    """After standing still the next interval begins with the next timestep."""
    own = Punctuality(PERIOD)
    own.timestep(0)
    own.timestep(125 * MS)
    own.stood_still()
    own.timestep(90_000 * MS)
    own.timestep(90_127 * MS)
    made = own.summary(0, 0)
    assert made.timesteps == 2
    assert made.timestep_mean == pytest.approx(0.126)
    assert made.timestep_max == pytest.approx(0.127)
    assert made.timestep_sd == pytest.approx(0.002 / math.sqrt(2))


def test_poll_gap_is_the_longest_time_without_looking_at_the_keys() -> None:
    """Four readings make three gaps; the longest bounds the error of a reaction time."""
    own = Punctuality(PERIOD)
    for t in (0, 8, 16, 46):
        own.poll(t * MS)
    made = own.summary(0, 0)
    assert made.polls == 3
    assert made.poll_gap_median == pytest.approx(0.008)
    assert made.poll_gap_max == pytest.approx(0.03)


def test_a_run_without_anything_states_that_nothing_is_known() -> None:
    """Without intervals there is no number, rather than a zero."""
    made = Punctuality(PERIOD).summary(0, 0)
    assert (made.frames, made.late_frames, made.timesteps, made.polls) == (0, 0, 0, 0)
    for name in ("frame_mean", "frame_p99", "timestep_sd", "poll_gap_max"):
        assert math.isnan(getattr(made, name))


@given(
    st.sampled_from([240 * MS, 260 * MS, 30_000 * MS]).flatmap(
        lambda longest: st.lists(st.integers(0, longest), min_size=2, max_size=300)
    )
)
def test_numbers_are_those_of_all_intervals(intervals: list[int]) -> None:
    """As reckoned from every single one: exactly, or to within the steps that are counted in."""
    own = Punctuality(PERIOD)
    for interval in intervals:
        own.frame(interval)
    made, seconds = own.summary(0, 0), np.array(intervals) / 1e9
    within = (RESOLUTION_NS if max(intervals) < FINE_NS else COARSE_NS) / 1e9
    assert made.frames == len(intervals)
    assert made.late_frames == np.count_nonzero(np.array(intervals) > 1.2 * PERIOD)
    assert made.frame_mean == pytest.approx(seconds.mean(), abs=1e-12)
    assert made.frame_max == seconds.max()
    assert made.frame_p99 == pytest.approx(np.quantile(seconds, 0.99), abs=within)
    assert made.frame_sd == pytest.approx(seconds.std(ddof=1), abs=within)


@pytest.mark.parametrize("longest", [17, 400])
def test_an_hour_takes_no_more_memory_than_a_minute(longest: int) -> None:
    """The keys are looked at 250 times a second; what was counted before costs nothing more.

    On a computer that is as busy as can be all intervals may be long.
    """
    own, random = Punctuality(PERIOD), np.random.default_rng(1)
    t, sizes = 0, []
    for minute in range(61):
        for gap in random.integers(0, longest * MS, A_MINUTE).tolist():
            t += gap
            own.poll(t)
        if minute in (1, 60):
            gc.collect()
            sizes.append(sys.getallocatedblocks())
    assert own.summary(0, 0).polls == 61 * A_MINUTE - 1
    assert sizes[1] - sizes[0] < 2000
