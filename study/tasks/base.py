"""The task contract: a fleet of robots, stepped as a batch."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from study.events.task_description import TaskDescription

Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]
Mask = npt.NDArray[np.bool_]
Seeds = npt.NDArray[np.uint64]


@dataclasses.dataclass(frozen=True, slots=True)
class FleetStep:
    """What a step returned.

    Attributes:
        states: float32 [n, d], after the step.
        rewards: float32 [n]; 0 for robots not stepped.
        outcomes: int32 [n], codes.Outcome; a robot not stepped keeps its last one.
    """

    states: Floats
    rewards: Floats
    outcomes: Ints


@runtime_checkable
class Task(Protocol):
    """A fleet of n robots that do not influence each other unless the task says so.

    A task is made for a fixed n: ``create(robots, parameters)`` in its module. It is
    deterministic given seeds and actions if its description says ``resimulable``.
    """

    description: TaskDescription
    robots: int

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` uint64 [n].

        Returns:
            States of all robots, float32 [n, d].
        """
        ...

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] by ``actions`` int32 [n]; leave the others alone."""
        ...

    def close(self) -> None:
        """Free what the task holds. Calling it twice is harmless."""
        ...


@runtime_checkable
class SnapshotTask(Task, Protocol):
    """A task whose whole state can be saved and put back."""

    def snapshot(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of all arrays that determine the future, random streams included."""
        ...

    def restore(self, snapshot: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put back what `snapshot` returned."""
        ...


@dataclasses.dataclass(frozen=True, slots=True)
class RobotReport:
    """A robot was stopped by what watches over it, or may drive again.

    Attributes:
        robot: its index.
        stopped: False if the reason is gone.
        reason: in one word, as "pose_lost".
        text: in a sentence, for the operator and the recording.
        age_s: how long ago, seconds.
    """

    robot: int
    stopped: bool
    reason: str
    text: str
    age_s: float


@runtime_checkable
class ReportingTask(Task, Protocol):
    """A task whose robots may be stopped for reasons of their own."""

    def take_reports(self) -> tuple[RobotReport, ...]:
        """Return what happened since the last call."""
        ...


@runtime_checkable
class TellingTask(ReportingTask, Protocol):
    """A task whose step may take so long that its reports should not wait for the answer."""

    def tell(self, teller: Callable[[tuple[RobotReport, ...]], None]) -> None:
        """Hand reports to ``teller`` as they come, in the midst of a step; none are kept then."""
        ...


@runtime_checkable
class PicturedTask(Task, Protocol):
    """A task that takes pictures of its robots, shown in place of a map.

    Its description's scene says ``camera``.
    """

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return what each robot shows.

        Returns:
            A picture as it is now, uint8 [n, height, width, 3]; or k pictures on the way of the
            last timestep, evenly spaced and ending now, uint8 [n, k, height, width, 3].
        """
        ...


@runtime_checkable
class PlaceableTask(Task, Protocol):
    """A task whose running robots can be put into any state: values are measured from there."""

    def place(self, mask: Mask, states: Floats) -> Floats:
        """Put the robots in ``mask`` [n] that have not ended into ``states`` float32 [n, d].

        Their episode goes on from there: noise and timestep are not touched.

        Returns:
            States of all robots, float32 [n, d].

        Raises:
            ValueError: a state is none that a running robot can be in.
        """
        ...
