"""Checks that a session's events agree with each other, whatever the inputs were."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Outcome
from study.events.events import (
    EpisodeEnded,
    Event,
    Paused,
    Resumed,
    SessionEnded,
    SessionStarted,
    StageEntered,
    Switched,
    Timestep,
    TimestepSkipped,
    TrialEnded,
    TrialStarted,
)


def same_number(left: float, right: float) -> bool:
    """Whether two numbers are equal but for rounding; NaN equals NaN."""
    return bool(np.isclose(left, right, rtol=1e-9, atol=1e-9, equal_nan=True))


def total(numbers: Sequence[float]) -> float:
    """Sum exactly; infinities of both signs, or a NaN, give NaN."""
    if all(map(math.isfinite, numbers)):
        return math.fsum(numbers)
    return float(np.sum(np.array([n for n in numbers if not math.isfinite(n)])))


class _OpenTrial:
    """The books of one trial, kept a second time from its rows alone."""

    def __init__(self, started: TrialStarted, idle: int) -> None:
        self.started = started
        self.idle = idle
        self.rewards: list[float] = []
        self.rows = 0
        self.episode_rewards: list[list[float]] = [[] for _ in range(started.robots)]
        self.episodes = [1] * started.robots
        self.due_to_end: list[int] = []

    def row(self, row: Timestep) -> None:
        assert not self.due_to_end, "an episode ended without an event"
        assert row.robots == self.started.robots
        assert row.timestep == self.rows
        assert row.due_ns <= row.t_ns
        self.rows += 1
        self._check_sources(row)
        for robot in range(row.robots):
            if row.action_sources[robot] == ActionSource.INACTIVE:
                assert row.actions[robot] == self.idle
                continue
            self.rewards.append(float(row.rewards[robot]))
            self.episode_rewards[robot].append(float(row.rewards[robot]))
            if row.outcomes[robot] != Outcome.RUNNING:
                self.due_to_end.append(robot)

    def _check_sources(self, row: Timestep) -> None:
        inactive = row.action_sources == ActionSource.INACTIVE
        offers = self.started.allocation == "correction_round"
        if offers and row.choice_source == ChoiceSource.OPERATOR:
            # Who is not offered drives on, and cannot be chosen.
            assert not row.available[inactive].any()
        else:
            assert (inactive == (row.available == 0)).all()
        mine = np.isin(row.action_sources, [ActionSource.OPERATOR, ActionSource.OPERATOR_IDLE])
        assert set(np.flatnonzero(mine)) <= {row.operated}
        if row.operated >= 0 and row.action_sources[row.operated] == ActionSource.OPERATOR:
            assert row.actions[row.operated] != self.idle
        expected = {"manual": ChoiceSource.OPERATOR, "assisted": ChoiceSource.SCORER}
        source = expected.get(self.started.allocation, ChoiceSource.NONE)
        one = self.started.robots == 1
        if offers:
            assert row.choice_source in (ChoiceSource.OPERATOR, ChoiceSource.SCORER)
        else:
            assert row.choice_source == (ChoiceSource.NONE if one else source)
        if self.started.allocation == "manual" and not one:
            assert (row.operated < 0) == (row.choice_flag == ChoiceFlag.BEFORE_FIRST_SELECTION)
        if self.started.allocation == "none":
            assert row.operated == -1

    def episode(self, ended: EpisodeEnded) -> None:
        assert ended.robot in self.due_to_end
        self.due_to_end.remove(ended.robot)
        rewards = self.episode_rewards[ended.robot]
        assert ended.timestep == self.rows - 1
        assert ended.length == len(rewards)
        assert same_number(ended.episode_reward, total(rewards))
        assert ended.episode == self.episodes[ended.robot]
        self.episodes[ended.robot] += 1
        self.episode_rewards[ended.robot] = []

    def end(self, ended: TrialEnded) -> None:
        assert not self.due_to_end
        assert ended.timesteps == self.rows
        assert same_number(ended.team_reward, total(self.rewards))
        if ended.complete and self.started.phase != 1:
            assert ended.timesteps <= self.started.timesteps


def check_books(events: Sequence[Event], idle: int, *, lawful: bool = True) -> None:
    """Assert that the events of a session, whole or in progress, agree with each other.

    Args:
        events: in order.
        idle: the task's idle action.
        lawful: whether the task kept to its contract; if not, episodes are not counted.
    """
    assert isinstance(events[0], SessionStarted)
    assert [e.t_ns for e in events] == sorted(e.t_ns for e in events)
    ends = [place for place, event in enumerate(events) if isinstance(event, SessionEnded)]
    assert ends in ([], [len(events) - 1])
    stages = [event.stage for event in events if isinstance(event, StageEntered)]
    assert stages == list(range(len(stages)))
    open_trial: _OpenTrial | None = None
    seen_trials: list[int] = []
    paused = False
    for event in events:
        if isinstance(event, TrialStarted):
            assert open_trial is None
            seen_trials.append(event.trial_id)
            open_trial = _OpenTrial(event, idle)
        elif isinstance(event, Timestep | TimestepSkipped | Switched | EpisodeEnded | TrialEnded):
            # What is due while a fleet starts belongs to a trial that has not started yet.
            assert open_trial is not None, event
            assert event.trial_id == open_trial.started.trial_id
            if isinstance(event, Switched):
                assert event.from_robot != event.to_robot
                lowest = -1 if event.cause == "offer" else 0
                assert lowest <= event.to_robot < open_trial.started.robots
            elif lawful and isinstance(event, Timestep):
                open_trial.row(event)
            elif lawful and isinstance(event, EpisodeEnded):
                open_trial.episode(event)
            elif isinstance(event, TrialEnded):
                if lawful:
                    open_trial.end(event)
                open_trial = None
        elif isinstance(event, Paused):
            assert not paused
            paused = True
        elif isinstance(event, Resumed):
            assert paused
            paused = False
    assert seen_trials == sorted(set(seen_trials))
    last = events[-1]
    if isinstance(last, SessionEnded):
        assert open_trial is None, "the session ended within a trial"
        started = events[0]
        assert last.complete == (len(stages) == started.stages and last.reason == "complete")
