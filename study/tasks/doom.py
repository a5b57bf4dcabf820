"""Driving through the rooms of `navigation` in DOOM, seen through the robot's eyes.

The map is written from the same layout, and states, actions, starts and points are those of the
task `navigation`; the engine moves the robots and draws what they see. It needs the extra
`doom`; the engine's licence forbids commercial use.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import sys
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.layouts import named_layout
from study.tasks._doom.arena import ArenaPlace
from study.tasks._doom.coding import to_commands, to_poses, to_states
from study.tasks._doom.conventions import TICS
from study.tasks._doom.crew import Change, Crew, Incident
from study.tasks._doom.parameters import Parameters
from study.tasks._doom.plane import on_grid
from study.tasks._doom.wad import Motion, write_wad
from study.tasks._navigation_description import described
from study.tasks._navigation_dynamics import ACTIONS, IDLE, TURN_LEFT, TURN_RIGHT, Dynamics, wrapped
from study.tasks._navigation_parameters import FULL_HEALTH
from study.tasks.base import FleetStep, Floats, Ints, Mask, RobotReport, Seeds

__all__ = [
    "ACTIONS",
    "IDLE",
    "OUT_OF_PROCESS",
    "DoomTask",
    "Parameters",
    "create",
    "describe",
    "missing_extra",
]

OUT_OF_PROCESS = True
"""Engines take milliseconds, and seconds when one must be replaced."""

INSTRUCTION = (
    "You see what each robot sees. Drive through the doors to the lamp. "
    "Red floor costs health; the kits on blue floor give some back."
)
ENGINE_LOST = "engine_lost"
"""Why a robot stands still whose engine is being replaced."""

_SLACK = 1e-5
"""Metres by which rounding to the engine's grid may bring a robot nearer to a wall."""


def describe(parameters: Mapping[str, object] | Parameters) -> TaskDescription:
    """Return the task's description.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
    """
    settings = Parameters.model_validate(parameters)
    rooms = described("doom", 1, settings)
    return dataclasses.replace(
        rooms,
        scene=dataclasses.replace(rooms.scene, camera=True, inset=settings.map == "small"),
        instruction=INSTRUCTION,
    )


def create(robots: int, parameters: Mapping[str, object] | Parameters) -> DoomTask:
    """Make a fleet; its engines start with the first reset.

    Raises:
        pydantic.ValidationError: a parameter is unknown or has no allowed value.
        StudyError: the engine is not installed, or does not run on this system.
    """
    if missing := missing_extra():
        raise StudyError("the task doom cannot run here", missing)
    return DoomTask(robots, Parameters.model_validate(parameters))


def missing_extra(parameters: Mapping[str, object] | Parameters | None = None) -> str:  # noqa: ARG001
    """Return what keeps the engine from running here, and what to do; empty if nothing does."""
    if sys.platform != "linux":
        return "It runs on Linux only. Use the task navigation, which is the same map."
    if importlib.util.find_spec("vizdoom") is None:
        return (
            "The package vizdoom is not installed here; in a clone `make doom` installs it, "
            "elsewhere pip install 'scaled-autonomy[doom]'. The licence of its engine (ViZDoom, "
            "ZDoom) forbids commercial use."
        )
    return ""


def spread_states(
    parameters: Mapping[str, object] | Parameters, random: np.random.Generator, count: int
) -> Floats:
    """Draw states that a running robot can be in, float32 [count, 4]; see `navigation`."""
    return Dynamics(Parameters.model_validate(parameters)).spread_states(random, count)


class DoomTask:
    """A fleet of robots in DOOM.

    A `SnapshotTask`, a `PlaceableTask`, a `PicturedTask` and a `TellingTask`.

    States are as in `study.tasks._navigation_dynamics.Dynamics`; places and healths are rounded
    to the engine's (some 12 micrometres, 1/65536 points), so that with exact motion a state is
    all that its robot's future and its picture depend on.

    Args:
        robots: number of robots, n.
        parameters: dynamics, rewards and what is the engine's.
    """

    def __init__(self, robots: int, parameters: Parameters) -> None:
        self.description = describe(parameters)
        self.robots = robots
        self.parameters = parameters
        self.dynamics = Dynamics(parameters)
        self._crew: Crew | None = None
        self._reports: list[RobotReport] = []
        self._teller: Callable[[tuple[RobotReport, ...]], None] | None = None
        turn = np.zeros(len(ACTIONS))
        turn[[TURN_LEFT, TURN_RIGHT]] = np.radians([parameters.turn, -parameters.turn])
        self._turn = turn
        self._states = np.zeros((robots, 4), np.float32)
        self._poses = to_poses(self._states)
        # A robot that was never reset counts as ended.
        self._outcomes = np.full(robots, Outcome.TIME_UP, np.int32)
        self._timesteps = np.zeros(robots, np.int32)
        self._distances = np.zeros(robots)

    def reset(self, mask: Mask, seeds: Seeds) -> Floats:
        """Start new episodes for the robots in ``mask`` [n]; ``seeds`` uint64 [n].

        Starts are drawn as in `navigation`: equal seeds start equally.

        Returns:
            States of all robots, float32 [n, 4].

        Raises:
            StudyError: the engines do not start.
        """
        states = self._states.copy()
        for robot in np.flatnonzero(mask):
            random = np.random.Generator(np.random.PCG64(np.random.SeedSequence(int(seeds[robot]))))
            states[robot] = self.dynamics.start_state(random)
        self._outcomes[mask] = Outcome.RUNNING
        self._timesteps[mask] = 0
        self._put(mask, states)
        return self._states.copy()

    def place(self, mask: Mask, states: Floats) -> Floats:
        """Put the robots in ``mask`` [n] that have not ended into ``states`` float32 [n, 4].

        With stock motion they stand still there.

        Returns:
            States of all robots, float32 [n, 4].

        Raises:
            ValueError: a state is off the floor, its heading out of range, or its health not
                in (0, 100].
            StudyError: the engines do not start.
        """
        x, y, heading, health = states[mask].astype(np.float64).T
        near = np.array([(a, b) for a in (-_SLACK, 0, _SLACK) for b in (-_SLACK, 0, _SLACK)]).T
        legal = self.dynamics.terrain.is_legal(x + near[0][:, None], y + near[1][:, None])
        fit = legal.any(axis=0) & (np.abs(heading) < np.pi)
        if not (fit & (health > 0) & (health <= FULL_HEALTH)).all():
            raise ValueError("a robot can only be put where one could be running")
        self._put(mask & (self._outcomes == Outcome.RUNNING), states)
        return self._states.copy()

    def step(self, actions: Ints, active: Mask) -> FleetStep:
        """Step the robots in ``active`` [n] that have not ended by ``actions`` int32 [n].

        The outcome is decided last: lost before goal before time up. If engines fail, this
        takes as long as it takes to replace them, and returns what they would have returned.

        Raises:
            ValueError: an active robot's action is none of the task's.
            StudyError: engines fail again and again.
        """
        stepped = active & (self._outcomes == Outcome.RUNNING)
        actions = np.where(stepped, actions, IDLE)
        if (actions.astype(np.uint32) >= len(ACTIONS)).any():
            raise ValueError(f"actions must be 0 to {len(ACTIONS) - 1}: {actions.tolist()}")
        heading = self._states[:, 2].astype(np.float64)
        turned = wrapped(heading + self._turn[actions])
        poses = self._engines().step(stepped, to_commands(actions, heading, turned))
        after = np.where(stepped[:, None], to_states(poses, turned), self._states)
        now = self.dynamics.judged(self._states, after, self._distances)

        outcomes = (self._timesteps + 1 >= self.parameters.horizon) * int(Outcome.TIME_UP)
        outcomes[now.at_goal] = Outcome.GOAL
        outcomes[now.lost] = Outcome.LOST
        np.copyto(self._states, after)
        np.copyto(self._poses, poses)
        np.copyto(self._outcomes, outcomes, where=stepped, casting="same_kind")
        np.copyto(self._distances, now.distances, where=stepped)
        self._timesteps += stepped
        return FleetStep(
            states=self._states.copy(),
            rewards=np.where(stepped, now.rewards, 0.0).astype(np.float32),
            outcomes=self._outcomes.copy(),
        )

    def frames(self, tic: int = -1) -> npt.NDArray[np.uint8]:
        """Return what the robots saw after a tic (0 to 3) of the last timestep.

        Returns:
            uint8 [n, height, width, 3], red, green, blue; painted over two timesteps later.

        Raises:
            StudyError: the engines do not start.
        """
        return self._engines().arena.shown(tic)

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return what the robots saw: after each tic of the last timestep, or as it is now.

        Returns:
            uint8 [n, 4, height, width, 3]; where only the last tic is drawn, uint8
            [n, height, width, 3].

        Raises:
            StudyError: the engines do not start.
        """
        arena = self._engines().arena
        if self.parameters.frames == "last":
            return arena.shown().copy()
        return np.stack([arena.shown(tic) for tic in range(TICS)], axis=1)

    def tell(self, teller: Callable[[tuple[RobotReport, ...]], None]) -> None:
        """Hand reports to ``teller`` as they come, in the midst of a step; none are kept then."""
        self._teller = teller

    def take_reports(self) -> tuple[RobotReport, ...]:
        """Return whose engines failed or were replaced since the last call."""
        taken, self._reports = tuple(self._reports), []
        return taken

    def arena_place(self) -> ArenaPlace:
        """Return where another process finds the frames, and which robots wait for an engine."""
        return self._engines().arena.place

    def incidents(self) -> list[Incident]:
        """Return what engines failed since the last call, oldest first."""
        found = self._crew.incidents[:] if self._crew else []
        if self._crew:
            self._crew.incidents.clear()
        return found

    def worker_pids(self) -> list[int]:
        """Return the ids of the processes that hold the engines."""
        return self._crew.pids() if self._crew else []

    def snapshot(self) -> dict[str, npt.NDArray[Any]]:
        """Return copies of all arrays that determine the future."""
        return {name: array.copy() for name, array in self._memory().items()}

    def restore(self, snapshot: Mapping[str, npt.NDArray[Any]]) -> None:
        """Put back what `snapshot` returned."""
        for name, array in self._memory().items():
            array[...] = snapshot[name]
        # Who never had a place has none on the floor.
        self._engines().place(self._poses[:, 0] > 0, self._poses)

    def close(self) -> None:
        """End the engines."""
        if self._crew is not None:
            self._crew.close()
            self._crew = None

    def _put(self, mask: Mask, states: Floats) -> None:
        """Put the robots in ``mask`` at rest into ``states``, rounded to the engine's grid."""
        self._poses[mask] = to_poses(states)[mask]
        rounded = to_states(self._poses, states[:, 2].astype(np.float64))
        self._states[mask] = rounded[mask]
        self._engines().place(mask, self._poses)
        x, y = self._states.astype(np.float64).T[:2]
        np.copyto(self._distances, self.dynamics.terrain.goal_distance(x, y), where=mask)

    def _engines(self) -> Crew:
        if self._crew is None:
            set_to = self.parameters
            layout = named_layout(set_to.layout)
            stock = set_to.motion == "stock"
            motion = Motion(
                set_to.forward, set_to.back, stock, set_to.hazard_damage, set_to.pack_heal
            )
            start = layout.start_mark
            self._crew = Crew(
                self.robots,
                write_wad(layout, motion),
                (on_grid(start.x), on_grid(start.y)),
                set_to.frame_shape,
                every_tic=set_to.frames == "every_tic",
                workers=set_to.workers,
                patience=set_to.patience,
                on_change=self._note,
            )
        return self._crew

    def _note(self, change: Change) -> None:
        """Report robots whose engines have failed, or are replaced."""
        reports = tuple(
            RobotReport(
                robot,
                stopped=change.lost,
                reason=ENGINE_LOST,
                text=f"robot {robot + 1} stopped: its DOOM engine failed ({change.reason})"
                if change.lost
                else f"robot {robot + 1} goes on with another DOOM engine",
                age_s=change.seconds,
            )
            for robot in change.robots
        )
        if self._teller is not None:
            self._teller(reports)
        else:
            self._reports += reports

    def _memory(self) -> dict[str, npt.NDArray[Any]]:
        return {
            "states": self._states,
            "poses": self._poses,
            "outcomes": self._outcomes,
            "timesteps": self._timesteps,
            "distances": self._distances,
        }
