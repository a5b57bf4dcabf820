"""A layout compiled to arrays: where a robot can be, what is there, how far the goal is."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from study.layouts import Disc, Layout, Rectangle

DOOR_POINTS = 65
"""Points sampled along a door's passable gap: a distance errs by at most half their spacing
(15 mm in the three rooms), and by under 1 mm a metre away from a door."""

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Places = npt.NDArray[np.complex128]
"""Places as complex numbers x + iy: a distance is then one absolute value."""


class Terrain:
    """Vectorised questions about a layout; x and y are float64 arrays of one shape.

    Args:
        layout: the map.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._legal = _bounds(layout.legal_areas())
        self._rooms = _bounds(layout.rooms)
        self._hazards = _bounds(layout.hazards)
        self._packs = _discs(layout.packs)
        self._goal = _discs([layout.goal])
        self._exits, self._beyond = self._ways_out()

    def is_legal(self, x: Floats, y: Floats) -> Mask:
        """Say where a robot's centre can be."""
        legal: Mask = np.logical_or.reduce(_inside(self._legal, x, y), axis=-1)
        return legal

    def in_hazard(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is in a hazard."""
        inside: Mask = np.logical_or.reduce(_inside(self._hazards, x, y), axis=-1)
        return inside

    def at_pack(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is on a health pack."""
        within: Mask = np.logical_or.reduce(_within(self._packs, x, y), axis=-1)
        return within

    def at_goal(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is in the goal."""
        return _within(self._goal, x, y)[..., 0]

    def goal_distance(self, x: Floats, y: Floats) -> Floats:
        """Return the length of the shortest way to the goal's middle, metres.

        A way goes through doors where a robot passes and ignores hazards. Rooms are convex
        and form a tree, so a shortest way is straight within each room and its only
        freedom is where it crosses the doors: the minimum over sampled crossings.

        Args:
            x: float64 [n], in the rooms.
            y: float64 [n].

        Returns:
            float64 [n].
        """
        room = _inside(self._rooms, x, y).argmax(axis=-1)
        ways = np.abs(self._exits[room] - (x + 1j * y)[:, None])
        ways += self._beyond[room]
        shortest: Floats = ways.min(axis=1)
        return shortest

    def _ways_out(self) -> tuple[Places, Floats]:
        """Return for each room where a way to the goal leaves it, and how far it goes on.

        Returns:
            exits: complex128 [rooms, DOOR_POINTS], points on the door that leads to the goal;
                in the goal's room the goal itself.
            beyond: float64 [rooms, DOOR_POINTS], distance from there to the goal.
        """
        layout = self.layout
        exits = np.zeros((len(layout.rooms), DOOR_POINTS), np.complex128)
        beyond = np.zeros((len(layout.rooms), DOOR_POINTS))
        goal = layout.goal
        at_goal = Rectangle(goal.x, goal.y, goal.x, goal.y)
        known = [next(i for i, room in enumerate(layout.rooms) if room.encloses(at_goal))]
        exits[known[0]] = complex(goal.x, goal.y)
        for near in known:  # grows while it is walked: the tree, breadth first
            for door in layout.doors:
                if near not in door.rooms:
                    continue
                far = door.rooms[1 - door.rooms.index(near)]
                if far in known:
                    continue
                gap = np.linspace(
                    door.low + layout.robot_radius, door.high - layout.robot_radius, DOOR_POINTS
                )
                upright = door.wall == "vertical"
                exits[far] = door.position + 1j * gap if upright else gap + 1j * door.position
                onwards = np.abs(exits[far][:, None] - exits[near]) + beyond[near]
                beyond[far] = onwards.min(axis=1)
                known.append(far)
        return exits, beyond


def _bounds(rectangles: Iterable[Rectangle]) -> Floats:
    """Return [4, k]: left, bottom, minus right and minus top of k rectangles."""
    rows = [(area.left, area.bottom, -area.right, -area.top) for area in rectangles]
    return np.array(rows, np.float64).reshape(-1, 4).T.copy()


def _discs(discs: Iterable[Disc]) -> tuple[Places, Floats]:
    """Return the middles complex128 [k] and radii float64 [k] of k discs."""
    listed = list(discs)
    middles = np.array([complex(disc.x, disc.y) for disc in listed], np.complex128)
    return middles, np.array([disc.radius for disc in listed], np.float64)


def _inside(bounds: Floats, x: Floats, y: Floats) -> Mask:
    """Return bool [..., k]: in which of the rectangles each place is."""
    sides = np.array([x, y, -x, -y])[..., None]
    bounds = bounds.reshape(4, *(1,) * x.ndim, bounds.shape[1])
    inside: Mask = np.logical_and.reduce(sides >= bounds, axis=0)
    return inside


def _within(discs: tuple[Places, Floats], x: Floats, y: Floats) -> Mask:
    """Return bool [..., k]: in which of the discs each place is."""
    middles, radii = discs
    within: Mask = np.abs((x + 1j * y)[..., None] - middles) <= radii
    return within
