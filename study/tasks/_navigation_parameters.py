"""What a protocol can set of the navigation task."""

from __future__ import annotations

import math
from collections.abc import Iterator

from pydantic import Field

from study.errors import UnknownNameError
from study.layouts import named_layout
from study.rules import Part

FULL_HEALTH = 100.0
NOISE_LIMIT = 3.0
"""Noise is cut off at this many standard deviations, so that no robot jumps a wall."""


class Rewards(Part):
    """Points, added up over robots and timesteps."""

    progress: float = Field(1.0, description="points per metre of driving distance to the goal")
    health: float = Field(0.1, description="points per health point gained or lost")
    goal: float = Field(10.0, description="points when a robot reaches the goal")
    lost: float = Field(-10.0, description="points when a robot's health reaches 0")
    timestep: float = Field(-0.05, description="points for each timestep of each running robot")


class Parameters(Part):
    """What a protocol can set of the task."""

    layout: str = Field("three_rooms", description="name of the map")
    horizon: int = Field(200, ge=1, le=100_000, description="longest episode, timesteps")
    forward: float = Field(0.5, gt=0, description="way of one step forward, metres")
    back: float = Field(0.3, gt=0, description="way of one step backward, metres")
    turn: float = Field(15.0, gt=0, lt=180, description="angle of one turn, degrees")
    noise: float = Field(
        0.03,
        ge=0,
        description="standard deviation of a step's error: metres in x and in y when driving, "
        "radians in heading when driving or turning; cut off at 3 standard deviations",
    )
    hazard_damage: float = Field(5.0, ge=0, description="health lost per timestep in a hazard")
    pack_heal: float = Field(10.0, ge=0, description="health gained per timestep on a pack")
    start_health: tuple[float, float] = Field(
        (60.0, 100.0), description="range of the health at the start, points"
    )
    rewards: Rewards = Field(Rewards(), description="points")

    def _health_rises(self) -> Iterator[str]:
        low, high = self.start_health
        if not 0 < low <= high <= FULL_HEALTH:
            yield f"start_health is {[low, high]}; it must rise within 0 to 100"

    def _layout_there(self) -> Iterator[str]:
        try:
            named_layout(self.layout)
        except UnknownNameError as error:
            yield f"layout: {error.sentence}"

    def _no_wall_jumped(self) -> Iterator[str]:
        if any(self._layout_there()):
            # How thick its walls are is not known yet.
            return
        longest = max(self.forward, self.back) + math.sqrt(2) * NOISE_LIMIT * self.noise
        wall = 2 * named_layout(self.layout).robot_radius
        if longest >= wall:
            yield (
                f"a step of up to {longest:.2f} m (forward or back with noise) could jump a wall; "
                f"it must stay under {wall:.2f} m"
            )

    rules = (_health_rises, _layout_there, _no_wall_jumped)
