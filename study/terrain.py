"""A layout compiled to arrays: where a robot can be, what is there, how far the goal is."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from study.layouts import Disc, Layout, Rectangle

DOOR_POINTS = 65
"""Points sampled along a door's passable gap: a distance errs by at most half their spacing
(15 mm in the three rooms), and by under 1 mm a metre away from a door."""

_TOO_CLOSE = 1e-9
"""Metres: far above the rounding of a square root, far below what tells crossings apart."""

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
        self._one_exit = [bool((exits == exits[0]).all()) for exits in self._exits]
        self._upright = [bool((exits.real == exits.real[0]).all()) for exits in self._exits]

    def is_legal(self, x: Floats, y: Floats) -> Mask:
        """Say where a robot's centre can be."""
        legal: Mask = np.logical_or.reduce(_inside(self._legal, x, y), axis=0)
        return legal

    def in_hazard(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is in a hazard."""
        inside: Mask = np.logical_or.reduce(_inside(self._hazards, x, y), axis=0)
        return inside

    def at_pack(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is on a health pack."""
        within: Mask = np.logical_or.reduce(_within(self._packs, x, y), axis=0)
        return within

    def at_goal(self, x: Floats, y: Floats) -> Mask:
        """Say whether a robot's centre is in the goal."""
        within: Mask = _within(self._goal, x, y)[0]
        return within

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
        room = _inside(self._rooms, x, y).argmax(axis=0)
        places = x + 1j * y
        shortest = np.empty(len(x))
        for number in range(len(self._exits)):
            rows = (room == number).nonzero()[0]
            if len(rows):
                shortest[rows] = self._way_from(number, places[rows])
        return shortest

    def _way_from(self, room: int, places: Places) -> Floats:
        """Return the shortest way to the goal, float64 [n], of places in one room.

        `np.abs` of complex numbers decides, as it always has: recordings hold its last bit. It
        is slow, so a square root finds the crossing first. That errs by less than
        `_TOO_CLOSE`: where the second best crossing is further off, it is the right one.
        """
        exits, beyond = self._exits[room], self._beyond[room]
        if self._one_exit[room]:
            direct: Floats = np.abs(exits[0] - places) + beyond[0]
            return direct
        # A door lies along one axis: across it all its crossings are equally far.
        along, across = (
            (exits.imag, exits.real) if self._upright[room] else (exits.real, exits.imag)
        )
        x, y = places.real, places.imag
        ahead, aside = (y, x) if self._upright[room] else (x, y)
        about = along - ahead[:, None]
        about *= about
        about += ((across[0] - aside) ** 2)[:, None]
        np.sqrt(about, out=about)
        about += beyond
        best = about.argmin(axis=1)
        rows = np.arange(len(places))
        shortest: Floats = np.abs(exits[best] - places) + beyond[best]
        least = about[rows, best]
        about[rows, best] = np.inf
        tied = (about.min(axis=1) - least < _TOO_CLOSE).nonzero()[0]
        if len(tied):
            ways = np.abs(exits - places[tied, None]) + beyond
            shortest[tied] = ways.min(axis=1)
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
    """Return [4, k]: left, bottom, right and top of k rectangles."""
    rows = [(area.left, area.bottom, area.right, area.top) for area in rectangles]
    return np.array(rows, np.float64).reshape(-1, 4).T.copy()


def _discs(discs: Iterable[Disc]) -> tuple[Places, Floats]:
    """Return the middles complex128 [k] and radii float64 [k] of k discs."""
    listed = list(discs)
    middles = np.array([complex(disc.x, disc.y) for disc in listed], np.complex128)
    return middles, np.array([disc.radius for disc in listed], np.float64)


def _inside(bounds: Floats, x: Floats, y: Floats) -> Mask:
    """Return bool [k, ...]: in which of the rectangles each place is.

    Places come last: long inner loops are what NumPy is fast at.
    """
    left, bottom, right, top = bounds.reshape(4, -1, *(1,) * x.ndim)
    inside: Mask = x >= left
    inside &= x <= right
    inside &= y >= bottom
    inside &= y <= top
    return inside


def _within(discs: tuple[Places, Floats], x: Floats, y: Floats) -> Mask:
    """Return bool [k, ...]: in which of the discs each place is.

    Only where the square of the distance leaves a doubt is the distance itself compared.
    """
    middles, radii = (given.reshape(-1, *(1,) * x.ndim) for given in discs)
    aside, above = x - middles.real, y - middles.imag
    margin = aside * aside + above * above - radii * radii
    within: Mask = margin < 0
    doubtful = np.abs(margin) < _TOO_CLOSE
    if doubtful.any():
        within[doubtful] = (np.abs((x + 1j * y) - middles) <= radii)[doubtful]
    return within
