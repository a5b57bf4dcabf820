"""How punctual one fleet run was: pictures, timesteps, and how often the keys were looked at."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from study.events.shell import TrialTiming

SECOND = 1_000_000_000
LATE_PERIODS = 1.2
"""A picture later than this many periods of the display after the one before is late."""


class Punctuality:
    """Collects times of one fleet run, all in ns of the session.

    Args:
        period_ns: between two pictures of the display.
    """

    def __init__(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._frames: list[int] = []
        self._timesteps: list[int] = []
        self._polls: list[int] = []
        self._last_timestep_ns = -1
        self._last_poll_ns = -1

    def frame(self, interval_ns: int) -> None:
        """A picture was shown so long after the one before."""
        self._frames.append(interval_ns)

    def timestep(self, t_ns: int) -> None:
        """A timestep was due, and was begun."""
        if self._last_timestep_ns >= 0:
            self._timesteps.append(t_ns - self._last_timestep_ns)
        self._last_timestep_ns = t_ns

    def stood_still(self) -> None:
        """The run is paused: the interval to the next timestep says nothing."""
        self._last_timestep_ns = -1

    def poll(self, t_ns: int) -> None:
        """The queue of keys was read."""
        if self._last_poll_ns >= 0:
            self._polls.append(t_ns - self._last_poll_ns)
        self._last_poll_ns = t_ns

    def summary(self, t_ns: int, trial_id: int) -> TrialTiming:
        """Return what is recorded of the run, at its end."""
        frames, timesteps = _seconds(self._frames), _seconds(self._timesteps)
        polls = _seconds(self._polls)
        period = self._period_ns / SECOND
        return TrialTiming(
            t_ns=t_ns,
            trial_id=trial_id,
            period=period,
            frames=int(frames.size),
            late_frames=int(np.count_nonzero(frames > LATE_PERIODS * period)),
            frame_mean=_mean(frames),
            frame_sd=_sd(frames),
            frame_p99=_quantile(frames, 0.99),
            frame_max=_quantile(frames, 1.0),
            timesteps=int(timesteps.size),
            timestep_mean=_mean(timesteps),
            timestep_sd=_sd(timesteps),
            timestep_p99=_quantile(timesteps, 0.99),
            timestep_max=_quantile(timesteps, 1.0),
            polls=int(polls.size),
            poll_gap_median=_quantile(polls, 0.5),
            poll_gap_p99=_quantile(polls, 0.99),
            poll_gap_max=_quantile(polls, 1.0),
        )


def _seconds(intervals: list[int]) -> npt.NDArray[np.float64]:
    return np.array(intervals, dtype=np.float64) / SECOND


def _mean(values: npt.NDArray[np.float64]) -> float:
    return float(values.mean()) if values.size else math.nan


def _sd(values: npt.NDArray[np.float64]) -> float:
    return float(values.std(ddof=1)) if values.size > 1 else math.nan


def _quantile(values: npt.NDArray[np.float64], level: float) -> float:
    return float(np.quantile(values, level)) if values.size else math.nan
