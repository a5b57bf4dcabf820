"""Heat-map grids: every score stands where its state is."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.map_grid import grid_states, score_grid
from study.tasks import erratic, navigation


class _Digits:
    """A scorer whose score tells its state."""

    def scores(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
        x, y, heading, health = states.astype(np.float64).T
        scores: npt.NDArray[np.float64] = x + 100 * y + 1e4 * heading + 1e6 * health
        return scores


def test_scores_stand_where_their_states_are() -> None:
    """Axis by axis the grid is healths, headings, rows and columns."""
    description = navigation.describe({})
    grid = description.map_grid
    assert grid is not None
    scores = score_grid(_Digits(), description)
    assert scores.shape == (4, 4, 30, 40)
    assert scores.dtype == np.float64
    expected = grid.xs[7] + 100 * grid.ys[11] + 1e4 * float(np.float32(grid.headings[1]))
    assert scores[2, 1, 11, 7] == expected + 1e6 * grid.healths[2]


def test_a_task_without_a_grid_has_no_scores() -> None:
    """Without a grid there is nothing to evaluate."""
    description = erratic.describe({})
    assert grid_states(description).size == 0
    assert score_grid(_Digits(), description).size == 0
