"""A scorer evaluated over a task's map: what heat maps show."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.task_description import TaskDescription
from study.scorers.base import Scorer


def grid_states(description: TaskDescription) -> npt.NDArray[np.float32]:
    """Return the states of the description's heat-map grid.

    Returns:
        float32 [healths, headings, rows, columns, d], rows upwards; state fields other than
        place, heading and health are in the middle of their range. Size 0 if the task has
        no grid.
    """
    fields, grid = description.state_fields, description.map_grid
    if grid is None:
        return np.zeros((0, 0, 0, 0, len(fields)), np.float32)
    shape = (len(grid.healths), len(grid.headings), len(grid.ys), len(grid.xs))
    middle = [(field.low + field.high) / 2 for field in fields]
    states = np.broadcast_to(np.array(middle, np.float32), (*shape, len(fields))).copy()
    places = (
        description.health_field,
        description.heading_field,
        description.y_field,
        description.x_field,
    )
    axes = np.meshgrid(grid.healths, grid.headings, grid.ys, grid.xs, indexing="ij")
    for place, values in zip(places, axes, strict=True):
        if place >= 0:
            states[..., place] = values
    return states


def score_grid(scorer: Scorer, description: TaskDescription) -> npt.NDArray[np.float64]:
    """Evaluate a scorer over the task's heat-map grid, cells that are not free included.

    Returns:
        float64 [healths, headings, rows, columns], rows upwards; size 0 without a grid.
    """
    states = grid_states(description)
    if not states.size:
        return np.zeros(states.shape[:-1])
    return scorer.scores(states.reshape(-1, states.shape[-1])).reshape(states.shape[:-1])
