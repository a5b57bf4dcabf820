"""What is recorded of a fleet run's punctuality."""

from __future__ import annotations

import math

import pytest

from study.shell.punctuality import Punctuality

MS = 1_000_000
PERIOD = 16_666_667


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
