"""Whose hands are on the keys: a crude person's plan, or the synthetic user's policy."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from study.events.scene import Scene
from study.screens import FleetScreen, Tile
from study.simulated.driving import Driver
from study.simulated.parameters import OperatorParameters
from study.simulated.planner import Plan, plan_for
from study.simulated.trained_user import TrainedUser


class Driving(Protocol):
    """Whoever drives the operated robot."""

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        ...

    def key(self, plan: Plan, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none."""
        ...


class TrainedDriver:
    """Drives by the synthetic user's policy, from what the tile shows of the robot.

    Args:
        user: the policy.
        random: the operator's stream; one number is drawn a timestep.
    """

    def __init__(self, user: TrainedUser, random: np.random.Generator) -> None:
        self._user = user
        self._random = random

    def begin(self) -> None:
        """Do nothing: the policy remembers nothing."""

    def key(self, plan: Plan, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none.

        Args:
            plan: left alone: the policy knows the map.
            tile: the operated robot as shown.
        """
        del plan
        shown = {"x": tile.x, "y": tile.y, "heading": tile.heading, "health": tile.health}
        state = [[shown[name] for name in self._user.state_names]]
        (action,) = self._user.actions(np.array(state, np.float32), self._random)
        return self._user.keys[int(action)]


def driver_for(
    parameters: OperatorParameters, random: np.random.Generator, user: TrainedUser | None
) -> Driving:
    """Return the driver that an operator's parameters name.

    Raises:
        ValueError: they name a trained user, and there is none.
    """
    if parameters.driver == "planner":
        return Driver(parameters, random)
    if user is None:
        raise ValueError("the operator's driver is a trained user, and none was given")
    return TrainedDriver(user, random)


class MapSkill:
    """Reads a map with a goal, and drives there: a `study.simulated.ways.Skill`.

    Args:
        parameters: of the operator.
        random: its stream.
        user: the synthetic user, who drives if the parameters say so.
    """

    def __init__(
        self,
        parameters: OperatorParameters,
        random: np.random.Generator,
        user: TrainedUser | None = None,
    ) -> None:
        self._parameters = parameters
        self._driver = driver_for(parameters, random, user)
        self._scene: Scene | None = None
        self._plan: Plan | None = None

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        self._driver.begin()

    def read(self, screen: FleetScreen) -> Plan:
        """Return the plan of the map shown; looking it up by value costs too much a timestep."""
        if self._plan is None or screen.scene is not self._scene:
            parameters = self._parameters
            self._scene = screen.scene
            self._plan = plan_for(
                screen.scene,
                parameters.hazard_cost,
                parameters.clearance_m,
                parameters.look_ahead_m,
            )
        return self._plan

    def key(self, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none; after `read`."""
        return self._driver.key(self._plan, tile) if self._plan is not None else ""
