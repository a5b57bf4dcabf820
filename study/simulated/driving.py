"""Steering one robot, and watching one that drives itself."""

from __future__ import annotations

import math

import numpy as np

from study.screens import Tile
from study.simulated.backing import Backing
from study.simulated.parameters import OperatorParameters
from study.simulated.planner import Plan, difference
from study.simulated.ways import Way

_STALLED_TIMESTEPS = 4
_REVERSING_TIMESTEPS = 3
_VAIN_TIMESTEPS = 5
_PACK_GAIN = 25.0
_PACK_FULL = 95.0


def effort_to_go(
    way: Way, tile: Tile, parameters: OperatorParameters, near: float | None = None
) -> float:
    """Return how far a robot is from its goal, metres, turning included.

    A turn step costs the time of a forward step, so it counts as that many metres. The
    value falls by about one forward step a timestep while a robot is on track.

    Args:
        way: where it is to go.
        tile: the robot as shown.
        parameters: the steps that one has learned.
        near: the effort seen before. Where the way goes round and round, effort goes on
            falling from lap to lap: of all the values that mean the same, the nearest is it.
    """
    left, turn = way.to_go(tile.x, tile.y, tile.heading)
    turns = turn * 180.0 / math.pi
    effort = left + turns / parameters.turn_step_deg * parameters.forward_step_m
    if near is not None and way.period > 0.0:
        return near + math.remainder(effort - near, way.period)
    return effort


class Driver:
    """Drives the operated robot to its goal, by way of a health pack where that helps."""

    def __init__(self, parameters: OperatorParameters, random: np.random.Generator) -> None:
        self._parameters = parameters
        self._random = random
        self._tolerance = math.radians(parameters.turn_step_deg * parameters.heading_tolerance)
        self._back_out = math.radians(parameters.back_out_deg)
        self._backing = Backing(parameters.forward_step_m, _STALLED_TIMESTEPS, _REVERSING_TIMESTEPS)
        self.begin()

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        self._key = ""
        self._backing.begin()
        self._fetching = False
        self._packs_help = True
        self._vain = 0
        self._health = 0.0

    def key(self, plan: Plan, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none.

        Args:
            plan: the map's plan.
            tile: the operated robot as shown.
        """
        wanted = self._wanted(plan, tile)
        if self._key and self._random.random() < self._parameters.steering_lapse:
            wanted = self._key
        self._key = wanted
        self._backing.note(wanted, tile)
        self._health = tile.health
        return wanted

    def _wanted(self, plan: Plan, tile: Tile) -> str:
        if self._backing.is_due(tile):
            return "down"
        cell = plan.cell(tile.x, tile.y)
        self._fetching = self._wants_pack(plan, tile, cell)
        at_pack = False
        route = plan.goal
        if self._fetching and plan.packs is not None:
            at_pack = plan.packs.cost[cell] <= 0.0
            if not at_pack:
                route = plan.packs
        aim = math.atan2(route.aim_y[cell] - tile.y, route.aim_x[cell] - tile.x)
        turn = difference(aim, tile.heading)
        if abs(turn) > self._back_out and self._near_hazard(plan, tile):
            return "down"
        if turn > self._tolerance:
            return "left"
        if turn < -self._tolerance:
            return "right"
        return "" if at_pack else "up"

    def _wants_pack(self, plan: Plan, tile: Tile, cell: int) -> bool:
        """Return whether to go for, or stay at, a health pack."""
        if plan.packs is None or not self._packs_help:
            return False
        away = plan.packs.cost[cell]
        if not self._fetching:
            self._vain = 0
            return (
                tile.health < self._parameters.pack_health
                and away < self._parameters.pack_distance_m
            )
        if away <= 0.0:
            self._vain = 0 if tile.health > self._health else self._vain + 1
            self._packs_help = self._vain < _VAIN_TIMESTEPS
        enough = min(_PACK_FULL, self._parameters.pack_health + _PACK_GAIN)
        return (
            self._packs_help
            and tile.health < enough
            and away < 2.0 * self._parameters.pack_distance_m
        )

    def _near_hazard(self, plan: Plan, tile: Tile) -> bool:
        reach = self._parameters.forward_step_m
        return plan.in_hazard(tile.x, tile.y) or plan.hazard_ahead(
            tile.x, tile.y, tile.heading, reach
        )


class CorrectionMonitor:
    """Decides when to override a robot that drives itself, and when to let go.

    Missed progress is added up as in a cumulative-sum chart (Page, 1954): each timestep
    adds half a forward step less the progress made, and never falls below zero.
    """

    def __init__(self, parameters: OperatorParameters) -> None:
        self._parameters = parameters
        self.begin(0)

    def begin(self, now_ns: int) -> None:
        """Start to watch a robot."""
        self.in_control = False
        self._since_ns = now_ns
        self._evidence = 0.0
        self._effort: float | None = None

    def update(self, plan: Way, tile: Tile, now_ns: int) -> bool:
        """Take in the next state and return whether the operator drives.

        Args:
            plan: where robots are to go.
            tile: the robot as shown.
            now_ns: session time.
        """
        parameters = self._parameters
        effort = effort_to_go(plan, tile, parameters, self._effort)
        before = effort if self._effort is None else self._effort
        self._effort = effort
        progress = (before - effort) / parameters.forward_step_m
        self._evidence = max(0.0, self._evidence + 0.5 - progress)
        danger = plan.in_hazard(tile.x, tile.y) or plan.hazard_ahead(
            tile.x, tile.y, tile.heading, 2.0 * parameters.forward_step_m
        )
        if not self.in_control:
            if danger or self._evidence >= parameters.correction_threshold:
                self.in_control = True
                self._since_ns = now_ns
        elif (
            not danger
            and self._evidence <= 0.0
            and now_ns - self._since_ns >= parameters.correction_hold_s * 1e9
        ):
            self.in_control = False
        return self.in_control
