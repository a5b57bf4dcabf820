"""Draws any screen, and says what a place on it is."""

from __future__ import annotations

import pygame

from study.screens import (
    BreakScreen,
    ConsentScreen,
    CountdownScreen,
    EndScreen,
    FleetScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyScreen,
    WaitScreen,
)
from study.shell.drawing import consenting, fleet, page, pausing, reveal, simple, survey, waiting
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.motion import Motion

Targets = list[tuple[str, pygame.Rect]]


class Renderer:
    """Draws screens of one size.

    Args:
        size: of the surfaces drawn on, pixels.
        ui_factor: the user's wish for larger (> 1) or smaller text.
    """

    def __init__(self, size: tuple[int, int], ui_factor: float = 1.0) -> None:
        self.canvas = Canvas(size, ui_factor)
        self._motion = Motion()

    @property
    def overflows(self) -> list[str]:
        """Texts that did not fit into the screen drawn last."""
        return self.canvas.overflows

    def draw(self, surface: pygame.Surface, screen: Screen, now_ns: int) -> None:
        """Draw a screen.

        Args:
            surface: of the renderer's size.
            screen: what to show.
            now_ns: session time, for what moves.
        """
        canvas = self.canvas
        canvas.surface = surface
        canvas.overflows.clear()
        match screen:
            case FleetScreen():
                self._motion.observe(screen)
                fleet.draw(canvas, screen, self._motion, now_ns)
            case CountdownScreen():
                self._motion.observe(screen.fleet)
                fleet.draw(canvas, screen.fleet, self._motion, now_ns)
                waiting.draw_countdown(canvas, screen)
            case BreakScreen():
                waiting.draw_break(canvas, screen)
            case ConsentScreen():
                consenting.draw(canvas, screen)
            case PageScreen():
                page.draw(canvas, screen)
            case SurveyScreen():
                survey.draw(canvas, screen)
            case RevealScreen():
                reveal.draw(canvas, screen)
            case WaitScreen():
                simple.draw_wait(canvas, screen, now_ns)
            case PauseScreen():
                pausing.draw(canvas, screen)
            case EndScreen():
                simple.draw_end(canvas, screen)

    def targets(self, screen: Screen) -> Targets:
        """Return all that can be clicked on a screen, the topmost last."""
        canvas = self.canvas
        match screen:
            case FleetScreen():
                return fleet.targets(canvas, screen)
            case CountdownScreen():
                return fleet.targets(canvas, screen.fleet)
            case BreakScreen():
                return waiting.break_targets(canvas, screen)
            case ConsentScreen():
                return consenting.targets(canvas, screen)
            case PageScreen():
                return page.targets(canvas, screen)
            case SurveyScreen():
                return survey.targets(canvas, screen)
            case RevealScreen():
                return reveal.targets(canvas, screen)
            case PauseScreen():
                return pausing.targets(canvas, screen)
            case EndScreen():
                return simple.end_targets(canvas, screen)
            case _:
                return []

    def hit(self, screen: Screen, x: float, y: float) -> str:
        """Return what a click at (x, y), pixels, hits.

        Returns:
            "robot:3" (index from 0), "answer:q1:5", "focus:q1", "confirm", "back", "continue",
            "stop", "erase", "agree", "decline", or "" for nothing.
        """
        for target, place in reversed(self.targets(screen)):
            if place.collidepoint(x, y):
                return target
        return ""
