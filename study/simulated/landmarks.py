"""The input of the user's networks: a robot's state, and how near it is to what the map shows.

A small network on plain coordinates is slow to learn what is small on the map: a health pack a
metre wide counts for nothing until its edge is found. A person sees it at once. So beside the
state come the nearness of each pack and of the goal, and the distance from each hazard's edge.
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
MAX_LANDMARKS = 256


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """What turns states into features.

    Attributes:
        fields: the state's d fields.
        place: which two fields are x and y, metres; empty for a task without a map.
        discs: float64 [m, 3], packs and goal: x, y and radius, metres.
        hazards: float64 [h, 4], left, bottom, right and top, metres.
    """

    fields: tuple[StateField, ...]
    place: tuple[int, ...]
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
            np.array(discs, np.float64).reshape(-1, 3),
            np.array(hazards, np.float64).reshape(-1, 4),
        )

    def to_json(self) -> dict[str, Any]:
        """Return all of it as JSON would hold it."""
        return {
            "fields": [dataclasses.asdict(field) for field in self.fields],
            "place": list(self.place),
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
        discs = np.array(given["discs"], np.float64).reshape(-1, 3)
        hazards = np.array(given["hazards"], np.float64).reshape(-1, 4)
        if not fields or len(place) not in {0, 2} or not set(place) <= set(range(len(fields))):
            raise ValueError("the state has no fields, or x and y are none of them")
        if len(discs) + len(hazards) > MAX_LANDMARKS or len(fields) > MAX_LANDMARKS:
            raise ValueError(f"there are more than {MAX_LANDMARKS} landmarks or fields")
        if not (np.isfinite(discs).all() and np.isfinite(hazards).all()):
            raise ValueError("a landmark holds a number that is not finite")
        return cls(fields, place, discs, hazards)

    @property
    def size(self) -> int:
        """Return k, the number of features."""
        circular = sum(field.circular for field in self.fields)
        return len(self.fields) + circular + len(self.discs) + len(self.hazards)

    def features(self, states: npt.NDArray[np.float32]) -> Floats:
        """Return the features of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n, k]: the fields, in -1 to 1 over their range and circular ones as sine
            and cosine; 1 in each disc and falling with the distance from it; and for each
            hazard from -1 well within to 1 well away.
        """
        plain = encode(states, self.fields, standard=range_standardisation(self.fields))
        if not self.place:
            return plain
        x, y = (states[:, at, None].astype(np.float64) for at in self.place)
        off = np.hypot(x - self.discs[:, 0], y - self.discs[:, 1]) - self.discs[:, 2]
        left, bottom, right, top = self.hazards.T
        aside, above = np.maximum(left - x, x - right), np.maximum(bottom - y, y - top)
        within = np.minimum(np.maximum(aside, above), 0.0)
        edge = np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0)) + within
        near = np.exp(-np.maximum(off, 0.0) / _REACH_M)
        return np.concatenate([plain, near, np.tanh(edge / _REACH_M)], axis=1)
