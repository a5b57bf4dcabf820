"""Drives laps by looking at a pose: along an ellipse round both buckets."""

from __future__ import annotations

import math

FORWARD, BACKWARD, TURN_LEFT, TURN_RIGHT, IDLE = range(5)
CENTRE = (2.0, 1.5)
HALF_AXES = (1.4, 0.9)


def on_ellipse(angle: float) -> tuple[float, float]:
    """Return a place on the way round."""
    return CENTRE[0] + HALF_AXES[0] * math.cos(angle), CENTRE[1] + HALF_AXES[1] * math.sin(angle)


def heading_error(x: float, y: float, heading: float) -> float:
    """Return by how much to turn to the left to face a place ahead on the ellipse, radians."""
    angle = math.atan2((y - CENTRE[1]) / HALF_AXES[1], (x - CENTRE[0]) / HALF_AXES[0])
    ahead_x, ahead_y = on_ellipse(angle + 0.4)
    error = math.atan2(ahead_y - y, ahead_x - x) - heading
    return math.remainder(error, 2 * math.pi)


def lap_action(x: float, y: float, heading: float) -> int:
    """Return the key that a driver of laps would press."""
    error = heading_error(x, y, heading)
    if abs(error) < 0.25:
        return FORWARD
    return TURN_LEFT if error > 0 else TURN_RIGHT
