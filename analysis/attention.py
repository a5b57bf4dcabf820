"""How an operator's attention went round a fleet: measures of supervisory control.

What each is, and whose it is, stands in `docs/explanation/attention-measures.md`. All times are
in timesteps. A measure that a fleet run does not give (nothing was stuck, nobody switched) is
missing, never 0.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

from study.events.codes import ActionSource, ChoiceFlag, Outcome

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

SETTLING = 8
"""Timesteps after a takeover in which a switch may still cost something."""
STUCK_SECONDS = 5.0
STUCK_METRES = 1.0
"""A robot that stays within it for so long is stuck: what participants' tiles say too."""

_NOBODY = -1


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FleetLog:
    """One fleet run of T timesteps and n robots.

    Attributes:
        operated: int64 [T], the robot operated; -1 if none.
        flags: int64 [T], codes.ChoiceFlag.
        sources: int64 [T, n], codes.ActionSource.
        running: bool [T, n], whether the robot's episode went on.
        outcomes: int64 [T, n], codes.Outcome after the timestep.
        rewards: float64 [T, n], points.
        places: float64 [T, n, 2], metres, before the timestep; None where a task has none.
        stuck_timesteps: how long `STUCK_SECONDS` is; None if the recording does not say.
        presses: keys and buttons pressed; None if the recording holds none at all.
    """

    operated: Ints
    flags: Ints
    sources: Ints
    running: Mask
    outcomes: Ints
    rewards: Floats
    places: Floats | None
    stuck_timesteps: int | None
    presses: int | None


def attended(log: FleetLog) -> Ints:
    """Return whom the operator attends to at each timestep, int64 [T]; -1 if nobody.

    A robot that is passed on the way to another, or operated before the first selection, is not
    attended to.
    """
    passed = np.isin(log.flags, (ChoiceFlag.CYCLING, ChoiceFlag.BEFORE_FIRST_SELECTION))
    return np.where(passed, _NOBODY, log.operated)


def stuck(log: FleetLog) -> Mask | None:
    """Return which robots are stuck before each timestep, bool [T, n]; None if it cannot be told.

    Stuck: for `STUCK_SECONDS`, in one episode, it has stayed within `STUCK_METRES`, in x and in
    y, of where it was at their beginning.
    """
    span = log.stuck_timesteps
    if log.places is None or span is None:
        return None
    found = np.zeros(log.running.shape, np.bool_)
    if len(found) <= span:
        return found
    anchor = log.places[:-span]
    held = log.running[:-span].copy()
    for ago in range(span + 1):
        later = slice(ago, len(found) - span + ago)
        near = np.abs(log.places[later] - anchor).max(axis=2) <= STUCK_METRES
        held &= near & log.running[later]
    found[span:] = held
    return found


def stretches(values: Ints) -> tuple[Ints, Ints, Ints]:
    """Return start, length and value of each run of equal values, in order."""
    if not len(values):
        return (np.zeros(0, np.int64),) * 3
    starts = np.flatnonzero(np.r_[True, values[1:] != values[:-1]])
    lengths = np.diff(np.r_[starts, len(values)])
    return starts, lengths, values[starts]


def measures(log: FleetLog) -> dict[str, float]:
    """Return every measure of one fleet run by its name; missing ones are nan."""
    eye = attended(log)
    starts, lengths, robots = stretches(eye)
    visited = robots != _NOBODY
    starts, lengths, robots = starts[visited], lengths[visited], robots[visited]
    held = int(lengths.sum())
    dwell = _ratio(held, len(starts))
    driven = _driven(log, eye)
    unattended = log.running & (np.arange(log.running.shape[1]) != eye[:, None])
    actions = int((log.sources == ActionSource.OPERATOR).sum())
    reward = float(np.sort(log.rewards, axis=None).sum())
    return {
        "attended": _ratio(held, len(eye)),
        "takeovers": float(len(starts)),
        "dwell": dwell,
        "switch_lag": _switch_lag(starts, lengths, driven),
        "switch_cost": _switch_cost(log, starts, lengths, robots),
        "neglect_time": _mean_spell(unattended),
        **_neglect(log, unattended, stuck(log), dwell),
        "actions": float(actions),
        "reward_per_action": _ratio(reward, actions),
        "presses": math.nan if log.presses is None else float(log.presses),
        "reward_per_press": _ratio(reward, log.presses or 0),
    }


def _driven(log: FleetLog, eye: Ints) -> Mask:
    """Return at which timesteps the operator acted on the robot attended to, bool [T]."""
    rows = np.arange(len(eye))
    acted = log.sources[rows, np.maximum(eye, 0)] == ActionSource.OPERATOR
    driven: Mask = acted & (eye != _NOBODY)
    return driven


def _switch_lag(starts: Ints, lengths: Ints, driven: Mask) -> float:
    """Return the mean time from leaving a robot to the first action on the next."""
    lags = []
    for place in range(1, len(starts)):
        left = starts[place - 1] + lengths[place - 1]
        end = starts[place] + lengths[place]
        acts = np.flatnonzero(driven[starts[place] : end])
        first = starts[place] + acts[0] if len(acts) else end
        lags.append(int(first - left))
    return _ratio(sum(lags), len(lags))


def _switch_cost(log: FleetLog, starts: Ints, lengths: Ints, robots: Ints) -> float:
    """Return the points that a takeover costs: below the settled pace, in its first timesteps."""
    if not len(starts):
        return math.nan
    rows = np.concatenate([np.arange(s, s + k) for s, k in zip(starts, lengths, strict=True)])
    age = np.concatenate([np.arange(k) for k in lengths])
    earned = log.rewards[rows, np.repeat(robots, lengths)]
    settled = age >= SETTLING
    if not settled.any():
        return math.nan
    pace = float(earned[settled].mean())
    return float((pace - earned[~settled]).sum()) / len(starts)


def _neglect(
    log: FleetLog, unattended: Mask, is_stuck: Mask | None, dwell: float
) -> dict[str, float]:
    names = (
        "stuck_spells",
        "stuck_helped",
        "stuck_wait",
        "stuck_share",
        "neglect_tolerance",
        "fan_out",
        "fan_out_with_wait",
    )
    if is_stuck is None:
        return dict.fromkeys(names, math.nan)
    alone = unattended & is_stuck
    spells, helped, waits = _stuck_spells(log, alone)
    fine = unattended & ~is_stuck
    # A robot's own trouble: it was fine and alone, and then it is stuck, or lost, and alone.
    began = int((fine[:-1] & alone[1:]).sum())
    lost = int((fine & (log.outcomes == Outcome.LOST)).sum())
    tolerance = _ratio(int(fine.sum()), began + lost)
    wait = _ratio(waits, helped)
    return {
        "stuck_spells": float(spells),
        "stuck_helped": _ratio(helped, spells),
        "stuck_wait": wait,
        "stuck_share": _ratio(int(alone.sum()), int(unattended.sum())),
        "neglect_tolerance": tolerance,
        "fan_out": tolerance / dwell + 1.0 if dwell > 0 else math.nan,
        "fan_out_with_wait": tolerance / (dwell + wait) + 1.0 if dwell > 0 else math.nan,
    }


def _stuck_spells(log: FleetLog, alone: Mask) -> tuple[int, int, int]:
    """Return spells of being stuck alone, those ended by a takeover, and the sum of their waits."""
    eye = attended(log)
    spells = helped = waits = 0
    for robot in range(alone.shape[1]):
        starts, lengths, values = stretches(alone[:, robot].astype(np.int64))
        for start, length in zip(starts[values == 1], lengths[values == 1], strict=True):
            spells += 1
            after = start + length
            if after < len(eye) and eye[after] == robot and log.running[after, robot]:
                helped += 1
                waits += int(length)
    return spells, helped, waits


def _mean_spell(alone: Mask) -> float:
    """Return the mean length of the stretches in which a robot goes on unattended."""
    before = np.zeros_like(alone)
    before[1:] = alone[:-1]
    return _ratio(int(alone.sum()), int((alone & ~before).sum()))


def _ratio(total: float, count: float) -> float:
    return total / count if count else math.nan
