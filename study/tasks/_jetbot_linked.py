"""The task jetbot with robots that are somewhere else: simulated or real, over the robot link."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from study.arena.course import TWO_BUCKETS
from study.arena.laps import Progress, advance
from study.errors import StudyError
from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.robots.client import Action
from study.robots.poses import Pose
from study.robots.robots_file import borrow_fleet, give_back_fleet
from study.tasks._jetbot_parameters import IDLE, Parameters
from study.tasks.base import FleetStep, Floats, Ints, Mask, RobotReport, Seeds

STEP_SHARE = 0.8
"""Part of a timestep after which its poses are read: the answer is there before the next is due."""

_HALF_TURN = float(np.nextafter(np.float32(np.pi), np.float32(0)))


class LinkedJetbotTask:
    """A fleet behind the robot link; a `study.tasks.base.ReportingTask`.

    Time is real: a step takes most of a timestep. Nothing can be put to a start, so an episode
    begins where its robot stands, and a lap that was begun goes on. Seeds are not used.

    Args:
        robots: number of robots, n: the first n of the file.
        parameters: with the name of the robots' file.
        description: the task's.

    Raises:
        StudyError: the file lists too few robots, or not every one of them is live.
    """

    def __init__(self, robots: int, parameters: Parameters, description: TaskDescription) -> None:
        self.description = description
        self.robots = robots
        self._parameters = parameters
        self._path = Path(parameters.link)
        self._fleet = borrow_fleet(self._path)
        self._open = True
        if robots > len(self._fleet.clients):
            listed = len(self._fleet.clients)
            self.close()
            raise StudyError(
                f"{robots} robots are to drive, {parameters.link} lists {listed}",
                "List more, or make the protocol's fleets smaller.",
            )
        self._states = np.zeros((robots, 4), np.float32)
        # A robot that was never reset counts as ended.
        self._outcomes = np.full(robots, Outcome.TIME_UP, np.int32)
        self._timesteps = np.zeros(robots, np.int32)
        self._progress = [Progress()] * robots
        self._places: dict[int, Pose] = {}
        self._look(np.ones(robots, np.bool_))

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Begin new episodes for the robots in ``mask`` [n], where they stand.

        Returns:
            States of all robots, float32 [n, 4].
        """
        del seeds
        self._outcomes[mask] = Outcome.RUNNING
        self._timesteps[mask] = 0
        self._look(mask)
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Drive the robots in ``active`` [n] for most of a timestep; the others stand."""
        stepped = active & (self._outcomes == Outcome.RUNNING)
        self._fleet.send_action(
            {
                robot: Action(
                    *self._parameters.velocity(int(actions[robot]) if stepped[robot] else IDLE)
                )
                for robot in range(self.robots)
            }
        )
        time.sleep(STEP_SHARE / self._parameters.timesteps_per_second)
        laps = self._look(stepped)
        self._timesteps += stepped
        late = stepped & (self._timesteps >= self.description.horizon)
        self._outcomes[late] = Outcome.TIME_UP
        rewards = (laps * self._parameters.lap).astype(np.float32)
        return FleetStep(self._states.copy(), rewards, self._outcomes.copy())

    def _look(self, mask: Mask) -> npt.NDArray[np.int32]:
        """Take in where robots are; return the laps they have finished, int32 [n]."""
        laps = np.zeros(self.robots, np.int32)
        course = TWO_BUCKETS
        for robot, pose in self._fleet.poses().items():
            if robot >= self.robots or not mask[robot]:
                continue
            before = self._places.get(robot, pose)
            now = advance(course, self._progress[robot], (before.x, before.y), (pose.x, pose.y))
            laps[robot] = now.laps - self._progress[robot].laps
            self._progress[robot], self._places[robot] = now, pose
            heading = math.remainder(pose.heading, 2 * math.pi)
            self._states[robot] = (
                min(max(pose.x, 0.0), course.width),
                min(max(pose.y, 0.0), course.height),
                min(max(heading, -_HALF_TURN), _HALF_TURN),
                now.passed,
            )
        return laps

    def take_reports(self) -> tuple[RobotReport, ...]:
        """Return which robots were stopped, or may drive again, since the last call."""
        now = time.monotonic()
        return tuple(
            RobotReport(
                robot=change.robot,
                stopped=change.began,
                reason=change.reason.name.lower(),
                text=change.text(),
                age_s=now - change.at,
            )
            for change in self._fleet.take_changes()
        )

    def close(self) -> None:
        """Let the robots go; they stand. Calling it twice is harmless."""
        if self._open:
            self._open = False
            give_back_fleet(self._path)


class PicturedLinkedJetbotTask(LinkedJetbotTask):
    """The same fleet with its front cameras; a `study.tasks.base.PicturedTask`, too."""

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return each robot's newest camera frame, uint8 [n, height, width, 3]."""
        # A study begins when every camera is live: there is a frame of each.
        frames = [seen.frame for seen in self._fleet.get_observation()[: self.robots]]
        return np.stack(
            [
                np.frombuffer(frame.pixels, np.uint8).reshape(frame.height, frame.width, 3)
                for frame in frames
                if frame is not None
            ]
        )
