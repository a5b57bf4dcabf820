"""A replay as a picture: the participant's screen alone, or with what an analyst wants to see."""

from __future__ import annotations

from typing import Literal

import pygame

from study.messages import Messages
from study.screens import CountdownScreen, FleetScreen, Screen
from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.pictures import Pictures
from study.shell.drawing.renderer import Renderer
from study.shell.replay.camera import Camera
from study.shell.replay.marks import Marks
from study.shell.replay.score_bars import best, draw_chip
from study.shell.replay.strip import HEIGHT, Shown, Strip

View = Literal["participant", "analyst"]
MOST_SIZES = 8
"""Sizes of the participant's window of which what was drawn is kept."""


def size_for(view: View, marks: Marks, t_ns: int = 0) -> tuple[int, int]:
    """Return the size of a picture that shows the participant's screen pixel for pixel."""
    width, height = marks.size_at(t_ns)
    if view == "participant":
        return width, height
    return width, height + round(HEIGHT * max(0.8, min(width / 1280, 2.0)))


class Picture:
    """Draws a replay at one size.

    Args:
        size: of the pictures, pixels. The participant's screen is made smaller where it does not
            fit, never larger.
        marks: of the session.
        view: what is shown.
        messages: the texts that the participant read.
        ui_scale: that of the participant's window.
        camera: takes the pictures of tasks that show some; without one they are missing.

    Attributes:
        view: what is shown; it may change.
    """

    def __init__(
        self,
        size: tuple[int, int],
        marks: Marks,
        view: View,
        messages: Messages | None = None,
        ui_scale: float = 1.0,
        camera: Camera | None = None,
    ) -> None:
        self.size = size
        self._camera = camera
        self._pictures = Pictures()
        self.view = view
        self._marks = marks
        self._messages = messages
        self._ui_scale = ui_scale
        self._strip = Strip(size, marks)
        self._chips = Canvas(size)
        self._drawn: dict[tuple[int, int], tuple[Renderer, pygame.Surface]] = {}

    def draw(self, surface: pygame.Surface, shown: Shown) -> None:
        """Draw what is shown; all of the surface is painted anew."""
        surface.fill(palette.EDGE)
        screen = shown.head.screen
        if screen is not None:
            renderer, picture = self._renderer(self._marks.size_at(shown.t_ns))
            renderer.go_on_from(shown.head.motion)
            if self._camera is not None and _has_camera(screen):
                self._camera.show(shown.head.film, self._pictures)
            renderer.draw(picture, screen, shown.t_ns)
            place = self._place(picture)
            if place.size == picture.get_size():
                surface.blit(picture, place)
            else:
                surface.blit(pygame.transform.smoothscale(picture, place.size), place)
            if self.view == "analyst":
                self._draw_chips(surface, renderer, screen, place, shown)
        if self.view == "analyst":
            self._strip.draw(surface, shown)

    def time_at(self, x: float, y: float) -> int | None:
        """Return the session time that a place of the timeline means; None elsewhere."""
        return self._strip.time_at(x, y) if self.view == "analyst" else None

    def _renderer(self, size: tuple[int, int]) -> tuple[Renderer, pygame.Surface]:
        if size not in self._drawn:
            if len(self._drawn) >= MOST_SIZES:
                self._drawn.clear()
            renderer = Renderer(size, self._ui_scale, self._messages, self._pictures)
            self._drawn[size] = renderer, pygame.Surface(size)
        return self._drawn[size]

    def _place(self, picture: pygame.Surface) -> pygame.Rect:
        """Return where the participant's screen goes."""
        room = pygame.Rect((0, 0), self.size)
        if self.view == "analyst":
            room.height -= self._strip.place.height
        width, height = picture.get_size()
        scale = min(1.0, room.width / width, room.height / height)
        place = pygame.Rect(0, 0, max(1, round(width * scale)), max(1, round(height * scale)))
        place.center = room.center
        return place

    def _draw_chips(
        self,
        surface: pygame.Surface,
        renderer: Renderer,
        screen: Screen,
        place: pygame.Rect,
        shown: Shown,
    ) -> None:
        """Write scores over the tiles."""
        scores = shown.head.scores
        if not isinstance(screen, FleetScreen) or len(scores) != screen.robots:
            return
        canvas = self._chips
        canvas.begin()
        canvas.surface = surface
        scale = place.width / renderer.canvas.size[0]
        canvas.rescale(max(0.7, renderer.canvas.scale * scale))
        highest = best(scores)
        for target, body in renderer.targets(screen):
            robot = int(target.removeprefix("robot:"))
            tile = pygame.Rect(
                place.left + round(body.left * scale), place.top + round(body.top * scale),
                round(body.width * scale), round(body.height * scale),
            )  # fmt: skip
            draw_chip(canvas, tile, float(scores[robot]), highest=robot == highest)


def _has_camera(screen: Screen) -> bool:
    """Return whether a screen shows pictures that the task takes."""
    fleet = screen.fleet if isinstance(screen, CountdownScreen) else screen
    return isinstance(fleet, FleetScreen) and fleet.scene.camera
