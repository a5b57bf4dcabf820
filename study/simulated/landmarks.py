"""The input of the user's networks: a robot's state, and where it is among what the map shows.

A small network on plain coordinates is slow to learn what is small on the map: a health pack a
metre wide counts for nothing until its edge is found, and a door until the wall beside it is. A
person sees both at once. So beside the state come waves over the map, from as long as it is wide
to an eighth of that, which let the network tell neighbouring places apart; the nearness of each
pack and of the goal, and whether it lies ahead or aside; and the distance from each hazard's edge.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.task_description import StateField, TaskDescription
from study.features import encode, range_standardisation

Floats = npt.NDArray[np.float64]

_REACH_M = 1.0
"""Metres over which nearness falls to 1/e; about two steps, as wide as a pack."""
_WAVES = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0])
"""Half waves over the map's width and height."""
_TURNS = (2.0, 3.0)
"""Multiples of the heading whose sine and cosine stand beside its own."""
MAX_LANDMARKS = 256


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """What turns states into features.

    Attributes:
        fields: the state's d fields.
        place: which two fields are x and y, metres; empty for a task without a map.
        heading: which field is the heading, radians; -1 where there is none.
        discs: float64 [m, 3], packs and goal: x, y and radius, metres.
        hazards: float64 [h, 4], left, bottom, right and top, metres.
    """

    fields: tuple[StateField, ...]
    place: tuple[int, ...]
    heading: int
    discs: Floats
    hazards: Floats

    @classmethod
    def of(cls, description: TaskDescription) -> Landmarks:
        """Return the landmarks that a task's map shows."""
        scene = description.scene
        place: tuple[int, ...] = (description.x_field, description.y_field)
        discs = [
            (disc.x, disc.y, disc.radius)
            for disc in scene.discs
            if disc.role in {"health_pack", "goal"}
        ]
        hazards = [
            (mark.x, mark.y, mark.x + mark.width, mark.y + mark.height)
            for mark in scene.rectangles
            if mark.role == "hazard"
        ]
        if min(place) < 0:
            place, discs, hazards = (), [], []
        return cls(
            description.state_fields,
            place,
            description.heading_field if place else -1,
            np.array(discs, np.float64).reshape(-1, 3),
            np.array(hazards, np.float64).reshape(-1, 4),
        )

    def to_json(self) -> dict[str, Any]:
        """Return all of it as JSON would hold it."""
        return {
            "fields": [dataclasses.asdict(field) for field in self.fields],
            "place": list(self.place),
            "heading": self.heading,
            "discs": self.discs.tolist(),
            "hazards": self.hazards.tolist(),
        }

    @classmethod
    def from_json(cls, given: Mapping[str, Any]) -> Landmarks:
        """Read what `to_json` wrote.

        Raises:
            KeyError, TypeError, ValueError: it is not that.
        """
        fields = tuple(StateField(**field) for field in given["fields"])
        place = tuple(int(at) for at in given["place"])
        heading = int(given["heading"])
        discs = np.array(given["discs"], np.float64).reshape(-1, 3)
        hazards = np.array(given["hazards"], np.float64).reshape(-1, 4)
        if not fields or len(place) not in {0, 2} or not set(place) <= set(range(len(fields))):
            raise ValueError("the state has no fields, or x and y are none of them")
        if not -1 <= heading < len(fields):
            raise ValueError("the heading is none of the state's fields")
        if any(not fields[at].high > fields[at].low for at in place):
            raise ValueError("the map has no extent")
        if len(discs) + len(hazards) > MAX_LANDMARKS or len(fields) > MAX_LANDMARKS:
            raise ValueError(f"there are more than {MAX_LANDMARKS} landmarks or fields")
        if not (np.isfinite(discs).all() and np.isfinite(hazards).all()):
            raise ValueError("a landmark holds a number that is not finite")
        return cls(fields, place, heading, discs, hazards)

    @property
    def size(self) -> int:
        """Return k, the number of features."""
        circular = sum(field.circular for field in self.fields)
        plain = len(self.fields) + circular
        if not self.place:
            return plain
        turned = 2 * (len(_TURNS) + len(self.discs)) if self.heading >= 0 else 0
        return plain + 4 * len(_WAVES) + len(self.discs) + len(self.hazards) + turned

    def features(self, states: npt.NDArray[np.float32]) -> Floats:
        """Return the features of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n, k]: the fields, in -1 to 1 over their range and circular ones as sine
            and cosine; sine and cosine of the waves over x and y; 1 in each disc and falling
            with the distance from it; for each hazard from -1 well within to 1 well away; and
            sine and cosine of the heading's multiples and of each disc's bearing.
        """
        plain = encode(states, self.fields, standard=range_standardisation(self.fields))
        if not self.place:
            return plain
        x, y = (states[:, at, None].astype(np.float64) for at in self.place)
        east, north = self.discs[:, 0] - x, self.discs[:, 1] - y
        off = np.hypot(east, north) - self.discs[:, 2]
        left, bottom, right, top = self.hazards.T
        aside, above = np.maximum(left - x, x - right), np.maximum(bottom - y, y - top)
        within = np.minimum(np.maximum(aside, above), 0.0)
        edge = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0)) + within
        near = np.exp(-np.maximum(off, 0.0) / _REACH_M)
        angles = [self._phases(x, self.place[0]), self._phases(y, self.place[1])]
        if self.heading >= 0:
            heading = states[:, self.heading, None].astype(np.float64)
            angles += [heading * np.array(_TURNS), np.arctan2(north, east) - heading]
        circled = np.concatenate(angles, axis=1)
        away = np.tanh(edge / _REACH_M)
        return np.concatenate([plain, np.sin(circled), np.cos(circled), near, away], axis=1)

    def _phases(self, along: Floats, field: int) -> Floats:
        """Return the phases [n, waves] of the waves over one coordinate [n, 1], radians."""
        low, high = self.fields[field].low, self.fields[field].high
        phases: Floats = np.pi * (along - low) / (high - low) * _WAVES
        return phases
