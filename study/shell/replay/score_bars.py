"""Every robot's score: bars in the strip, numbers on the tiles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pygame

from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas

Scores = npt.NDArray[np.float64]
MOST_NUMBERED = 24
"""More robots than this have bars without numbers."""


def number(score: float) -> str:
    """Return a score as it is written: two decimals, and a sign that is no hyphen."""
    return f"{score:.2f}".replace("-", "\u2212") if np.isfinite(score) else "none"


def best(scores: Scores) -> int:
    """Return the robot with the highest score, the lowest index of equals; -1 without scores."""
    finite = np.isfinite(scores)
    return int(np.argmax(np.where(finite, scores, -np.inf))) if finite.any() else -1


def draw_score_bars(canvas: Canvas, place: pygame.Rect, scores: Scores, operated: int) -> None:
    """Draw the scores as bars from the lowest to the highest, the operated robot's in blue."""
    highest = best(scores)
    size, line = canvas.u(14), canvas.u(16)
    if highest < 0:
        canvas.write("No scores here", place.left, place.top + line // 2, size,
                     colour=palette.SECONDARY)  # fmt: skip
        return
    words = f"Scores, highest: robot {highest + 1} with {number(scores[highest])}"
    canvas.write(words, place.left, place.top + line // 2, size, width=place.width)
    low, high = float(np.nanmin(scores)), float(np.nanmax(scores))
    room = place.height - 2 * line
    step = place.width / len(scores)
    numbered = len(scores) <= MOST_NUMBERED
    for robot, score in enumerate(scores.tolist()):
        left = place.left + robot * step
        share = (score - low) / (high - low) if high > low and np.isfinite(score) else 0.0
        height = canvas.u(2) + round(share * (room - canvas.u(2)))
        colour = palette.INK if robot == highest else palette.KEY_SHADE
        colour = palette.BLUE if robot == operated else colour
        bar = pygame.Rect(round(left), 0, max(1, round(step * 0.72)), height)
        bar.bottom = place.top + line + room
        canvas.surface.fill(colour, bar)
        if numbered:
            canvas.write(str(robot + 1), bar.centerx, place.bottom - line // 2, canvas.u(13),
                         colour=palette.SECONDARY, align="centre", width=step)  # fmt: skip


def draw_chip(canvas: Canvas, tile: pygame.Rect, score: float, *, highest: bool) -> None:
    """Write a robot's score over the lower edge of its tile, pixels; the highest in white."""
    size, height = canvas.u(15), canvas.u(22)
    text = number(score)
    box = pygame.Rect(0, 0, canvas.text_width(text, size, "semibold") + canvas.u(16), height)
    # A tile drawn large has no gap under it.
    large = tile.height > canvas.u(400)
    box.bottom = tile.bottom - canvas.u(12) if large else tile.bottom + height // 2
    box.right = tile.right - canvas.u(12 if large else 8)
    canvas.box(box, canvas.u(5), palette.INK if highest else palette.CARD, palette.INK, canvas.u(2))
    colour = palette.CARD if highest else palette.INK
    canvas.write(text, box.centerx, box.centery, size, weight="semibold", colour=colour,
                 align="centre")  # fmt: skip
