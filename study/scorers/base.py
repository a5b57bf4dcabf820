"""The scorer contract: a state to the value of taking control there (phi in the paper).

A member's module has ``Parameters`` (a pydantic model), ``fit`` and ``load`` as in
`study.policies.base.FitModule`; torch is imported inside ``fit`` only, so that a live
session scores without it.

A scorer that can go on from an earlier fit (``WARM_STARTS = True``) takes that fit's preparation
as ``start``, and returns one.

A control scorer (``IS_CONTROL = True`` in its module) learns nothing from the operator: its
``fit`` measures nothing, and no heat map is made of it. A scorer may have ``begin(robots, seed)``,
called when a fleet run starts; then it may keep what it saw, being asked once a timestep for the
whole fleet.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt


class Scorer(Protocol):
    """Maps states to the value of taking control."""

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        """Return a score for each of n states.

        Args:
            states: float32 [n, d].

        Returns:
            float64 [n]; larger means sooner. Identified up to a constant.
        """
        ...
