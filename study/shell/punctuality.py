"""How punctual one fleet run was: pictures, timesteps, and how often the keys were looked at."""

from __future__ import annotations

import math
from array import array
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
FINE_STEPS = 25_000
FINE_NS = FINE_STEPS * RESOLUTION_NS
"""What is longer, 250 ms, is counted in coarser steps: on a busy computer there are hundreds."""
COARSE_NS = 1_000_000
STEPS = FINE_STEPS + 10_000
"""Steps of which each has its count from the start, up to more than 10 s."""


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

        Numbers, means and the longest are exact; the rest is to within `RESOLUTION_NS`, and to
        within `COARSE_NS` where it is longer than 250 ms.
        """
        frames, timesteps, polls = self._frames, self._timesteps, self._polls
        return TrialTiming(
            t_ns=t_ns,
            trial_id=trial_id,
            period=self._period_ns / SECOND,
            frames=frames.number,
            late_frames=self._late_frames,
            frame_mean=frames.mean,
            frame_sd=frames.sd,
            frame_p99=frames.quantile(0.99),
            frame_max=frames.longest,
            timesteps=timesteps.number,
            timestep_mean=timesteps.mean,
            timestep_sd=timesteps.sd,
            timestep_p99=timesteps.quantile(0.99),
            timestep_max=timesteps.longest,
            polls=polls.number,
            poll_gap_median=polls.quantile(0.5),
            poll_gap_p99=polls.quantile(0.99),
            poll_gap_max=polls.longest,
        )


class _Intervals:
    """Intervals of one kind, counted by how long they were.

    Attributes:
        number: of them.
    """

    def __init__(self) -> None:
        self.number = 0
        self._total_ns = self._longest_ns = 0
        self._counts = array("I", bytes(STEPS * array("I").itemsize))
        self._longer: Counter[int] = Counter()

    def add(self, interval_ns: int) -> None:
        """Count one more."""
        self.number += 1
        self._total_ns += interval_ns
        self._longest_ns = max(self._longest_ns, interval_ns)
        step = _step(interval_ns)
        (self._counts if step < STEPS else self._longer)[step] += 1

    @property
    def mean(self) -> float:
        """Their mean, s; NaN if there are none."""
        return self._total_ns / self.number / SECOND if self.number else math.nan

    @property
    def longest(self) -> float:
        """The longest, s; NaN if there are none."""
        return self._longest_ns / SECOND if self.number else math.nan

    @property
    def sd(self) -> float:
        """Their standard deviation, s, to within a step; NaN if there are fewer than two.

        All of them laid out in a row would be a megabyte for a moment, at every run's end.
        """
        if self.number < 2:
            return math.nan
        lengths, times = self._counted()
        mean = float(lengths @ times) / self.number
        return math.sqrt(float((lengths - mean) ** 2 @ times) / (self.number - 1))

    def quantile(self, level: float) -> float:
        """Return a quantile of them, s, to within a step; NaN if there are none.

        Between two of them it is interpolated linearly, as by `numpy.quantile`.
        """
        if not self.number:
            return math.nan
        lengths, times = self._counted()
        position = level * (self.number - 1)
        lower = math.floor(position)
        ranks = [lower, min(lower + 1, self.number - 1)]
        low, high = lengths[np.searchsorted(times.cumsum(), ranks, side="right")]
        return float(low + (high - low) * (position - lower))

    def _counted(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """Return the rounded lengths that occur, s, shortest first, and how often each does."""
        counts = np.frombuffer(self._counts, dtype=np.dtype(self._counts.typecode))
        occurring = np.flatnonzero(counts)
        longer = sorted(self._longer)
        steps = np.concatenate([occurring, np.array(longer, dtype=np.int64)])
        times = np.concatenate(
            [counts[occurring], np.array([self._longer[step] for step in longer], dtype=np.int64)]
        )
        fine = np.minimum(steps, FINE_STEPS) * RESOLUTION_NS
        coarse = np.maximum(steps - FINE_STEPS, 0) * COARSE_NS
        return (fine + coarse) / SECOND, times.astype(np.int64)


def _step(interval_ns: int) -> int:
    """Return the step in which an interval is counted."""
    if interval_ns < FINE_NS:
        return round(interval_ns / RESOLUTION_NS)
    return FINE_STEPS + round((interval_ns - FINE_NS) / COARSE_NS)
