"""What an operator knows of the way that robots are to go, and how it drives them along it."""

from __future__ import annotations

from typing import Protocol

from study.screens import FleetScreen, Tile


class Way(Protocol):
    """A map as an operator thinks of it: read off the screen, never told."""

    @property
    def longest(self) -> float:
        """The farthest that a robot can have to go, metres; 0 where the way never ends."""
        ...

    @property
    def period(self) -> float:
        """Metres after which the way is the same again; 0 where it leads to a goal."""
        ...

    def to_go(self, x: float, y: float, heading: float) -> tuple[float, float]:
        """Return the way left from (x, y), metres, and the turn to face it, radians, no sign."""
        ...

    def in_hazard(self, x: float, y: float) -> bool:
        """Return whether (x, y) metres lies in a hazard."""
        ...

    def hazard_ahead(self, x: float, y: float, heading: float, reach: float) -> bool:
        """Return whether a hazard lies straight ahead within ``reach`` metres."""
        ...


class Skill(Protocol):
    """How an operator reads maps of one kind, and drives there."""

    def begin(self) -> None:
        """Start on another robot, or on the same one's new episode."""
        ...

    def read(self, screen: FleetScreen) -> Way:
        """Look at the map, and at who is about; return the way."""
        ...

    def key(self, tile: Tile) -> str:
        """Return the driving key for the next timestep, "" for none; after `read`."""
        ...
