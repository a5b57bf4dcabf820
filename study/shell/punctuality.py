"""How punctual one fleet run was: pictures, timesteps, and how often the keys were looked at."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import numpy.typing as npt

from study.events.shell import TrialTiming

SECOND = 1_000_000_000
LATE_PERIODS = 1.2
"""A picture later than this many periods of the display after the one before is late."""
RESOLUTION_NS = 10_000
"""Intervals are counted in steps of so much: a fleet run of hours takes no more memory than a short
one, though the keys are looked at hundreds of times a second."""


class Punctuality:
    """Collects times of one fleet run, all in ns of the session.

    Args:
        period_ns: between two pictures of the display.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._frames = _Intervals()
        self._timesteps = _Intervals()
        self._polls = _Intervals()
        self._late_frames = 0
        self._last_timestep_ns = -1
        self._last_poll_ns = -1

    def frame(self, interval_ns: int) -> None:
        """A picture was shown so long after the one before."""
        self._frames.add(interval_ns)
        self._late_frames += interval_ns > LATE_PERIODS * self._period_ns

    def timestep(self, t_ns: int) -> None:
        """A timestep was due, and was begun."""
        if self._last_timestep_ns >= 0:
            self._timesteps.add(t_ns - self._last_timestep_ns)
        self._last_timestep_ns = t_ns

    def stood_still(self) -> None:
        """The run is paused: the interval to the next timestep says nothing."""
        self._last_timestep_ns = -1

    def poll(self, t_ns: int) -> None:
        """The queue of keys was read."""
        if self._last_poll_ns >= 0:
            self._polls.add(t_ns - self._last_poll_ns)
        self._last_poll_ns = t_ns

    def summary(self, t_ns: int, trial_id: int) -> TrialTiming:
        """Return what is recorded of the run, at its end.

        Numbers, means and the longest are exact; the rest is to within `RESOLUTION_NS`.
        """
        frames, timesteps, polls = (
            each.rounded() for each in (self._frames, self._timesteps, self._polls)
        )
        return TrialTiming(
            t_ns=t_ns,
            trial_id=trial_id,
            period=self._period_ns / SECOND,
            frames=self._frames.number,
            late_frames=self._late_frames,
            frame_mean=self._frames.mean,
            frame_sd=_sd(frames),
            frame_p99=_quantile(frames, 0.99),
            frame_max=self._frames.longest,
            timesteps=self._timesteps.number,
            timestep_mean=self._timesteps.mean,
            timestep_sd=_sd(timesteps),
            timestep_p99=_quantile(timesteps, 0.99),
            timestep_max=self._timesteps.longest,
            polls=self._polls.number,
            poll_gap_median=_quantile(polls, 0.5),
            poll_gap_p99=_quantile(polls, 0.99),
            poll_gap_max=self._polls.longest,
        )


class _Intervals:
    """Intervals of one kind, counted by how long they were.

    Attributes:
        number: of them.
    """

    def __init__(self) -> None:
        self.number = 0
        self._total_ns = self._longest_ns = 0
        self._counts: Counter[int] = Counter()

    def add(self, interval_ns: int) -> None:
        """Count one more."""
        self.number += 1
        self._total_ns += interval_ns
        self._longest_ns = max(self._longest_ns, interval_ns)
        self._counts[round(interval_ns / RESOLUTION_NS)] += 1

    @property
    def mean(self) -> float:
        """Their mean, s; NaN if there are none."""
        return self._total_ns / self.number / SECOND if self.number else math.nan

    @property
    def longest(self) -> float:
        """The longest, s; NaN if there are none."""
        return self._longest_ns / SECOND if self.number else math.nan

    def rounded(self) -> npt.NDArray[np.float64]:
        """Return all of them, s, shortest first, rounded to `RESOLUTION_NS`."""
        steps = sorted(self._counts)
        times = np.array([self._counts[step] for step in steps], dtype=np.int64)
        return np.repeat(np.array(steps, dtype=np.float64), times) * (RESOLUTION_NS / SECOND)


def _sd(values: npt.NDArray[np.float64]) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else math.nan


def _quantile(values: npt.NDArray[np.float64], level: float) -> float:
    return float(np.quantile(values, level)) if values.size else math.nan
