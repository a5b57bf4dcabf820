"""Pictures that a task takes of its robots, and how a tile shows one in place of a map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pygame

from study.messages import noted
from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas

Picture = npt.NDArray[np.uint8]
_SEVERAL = 4
"""Dimensions of several pictures of one robot."""
NO_PICTURE = noted("No picture of this robot here")


class Shot(NamedTuple):
    """A picture of one robot.

    Attributes:
        number: another one for every other picture.
        pixels: uint8 [height, width, 3]; None where there is none to show.
    """

    number: int
    pixels: Picture | None


class Pictures:
    """The newest pictures of each robot. One that is the same again keeps its number."""

    def __init__(self) -> None:
        self._shots: list[list[Shot]] = []
        self._next = 1

    def take(self, pictures: npt.NDArray[np.uint8] | list[Picture | None]) -> None:
        """Take the pictures of a fleet.

        Args:
            pictures: a picture a robot, or several on the way of a timestep, uint8
                [k, height, width, 3]; None where there is none.
        """
        before = self._shots
        self._shots = [
            self._taken(before[robot][-1] if robot < len(before) else None, pixels)
            for robot, pixels in enumerate(pictures)
        ]

    def of(self, robot: int, share: float = 1.0) -> Shot:
        """Return the picture of a robot (from 0) when a share of a timestep has passed."""
        if robot >= len(self._shots):
            return Shot(0, None)
        shots = self._shots[robot]
        return shots[min(len(shots) - 1, max(0, int(share * len(shots))))]

    def _taken(self, before: Shot | None, pixels: Picture | None) -> list[Shot]:
        if pixels is None:
            return [Shot(0, None)]
        shots: list[Shot] = []
        for picture in pixels if pixels.ndim == _SEVERAL else pixels[None]:
            before = self._shot(before, picture)
            shots.append(before)
        return shots

    def _shot(self, before: Shot | None, pixels: Picture) -> Shot:
        if (
            before is not None
            and before.pixels is not None
            and np.array_equal(before.pixels, pixels)
        ):
            return before
        self._next += 1
        return Shot(self._next, pixels)


def draw_picture(canvas: Canvas, shot: Shot | None, place: pygame.Rect) -> None:
    """Draw a picture as large as a place allows; words where there is none to show.

    Args:
        canvas: to draw on.
        shot: the picture; None leaves the place empty, as in an illustration.
        place: where, pixels; all of it is painted.
    """
    if not canvas.surface.get_clip().colliderect(place):
        # Enlarging it would take a millisecond all the same.
        return
    if shot is None or shot.pixels is None:
        canvas.surface.fill(palette.FLOOR, place)
    if shot is None:
        return
    if shot.pixels is None:
        size = canvas.u(18)
        words = canvas.say(NO_PICTURE)
        room = place.inflate(-canvas.u(16), 0)
        room.height = canvas.paragraph_height(words, room.width, size)
        room.centery = place.centery
        canvas.paragraph(words, room, size, colour=palette.SECONDARY, align="centre")
        return
    height, width = shot.pixels.shape[:2]
    scale = min(place.width / width, place.height / height)
    drawn = pygame.Rect(0, 0, max(1, round(width * scale)), max(1, round(height * scale)))
    drawn.center = place.center
    if drawn.size != place.size:
        canvas.surface.fill(palette.FLOOR, place)
    picture = pygame.image.frombuffer(shot.pixels.tobytes(), (width, height), "RGB")
    # In the screen's own format it is enlarged six times as fast, and right where it is to be.
    picture = picture.convert(canvas.surface)
    if drawn.size == (width, height):
        canvas.surface.blit(picture, drawn)
    elif canvas.surface.get_rect().contains(drawn):
        pygame.transform.smoothscale(picture, drawn.size, canvas.surface.subsurface(drawn))
    else:
        canvas.surface.blit(pygame.transform.smoothscale(picture, drawn.size), drawn)
