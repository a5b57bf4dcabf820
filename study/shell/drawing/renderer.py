"""Draws any screen, and says what a place on it is.

A screen whose texts would be clipped or lie on one another at the scale wished for, as with a
large scale in a small window or a language of long words, is drawn at the largest scale that fits.
"""

from __future__ import annotations

import contextlib
from collections.abc import Hashable, Iterator

import pygame

from study.messages import Messages
from study.screens import (
    BreakScreen,
    ConsentScreen,
    CountdownScreen,
    EndScreen,
    FleetScreen,
    KeyTrialScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyScreen,
    WaitScreen,
)
from study.shell.drawing import (
    consenting,
    fleet,
    fleet_places,
    page,
    pausing,
    reveal,
    simple,
    survey,
    waiting,
)
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.lettering import no_more_lines
from study.shell.drawing.motion import Motion
from study.shell.drawing.pictures import Pictures

Targets = list[tuple[str, pygame.Rect]]
SMALLEST_FIT = 0.55
"""Pixels to a design pixel below which a screen is not reduced further: text of 11 px."""
REDUCTION = 0.9
REHEARSED_EVERY = 8
"""Pictures of a fleet run between two in which something is painted that may be seen later."""
STILL = (
    PageScreen, SurveyScreen, RevealScreen, BreakScreen, ConsentScreen, PauseScreen, EndScreen,
)  # fmt: skip
"""Screens that look the same until another is shown."""


def layout_kind(screen: Screen) -> Hashable:
    """Return what the scale of a screen depends on: it must not change while one looks at it."""
    if isinstance(screen, FleetScreen):
        return (
            FleetScreen, screen.view, screen.robots, screen.allocation, screen.heading,
            screen.trials, screen.keys, len(screen.tiles),
        )  # fmt: skip
    if isinstance(screen, CountdownScreen):
        return layout_kind(screen.fleet)
    title = getattr(screen, "title", "") or getattr(screen, "header_left", "")
    return type(screen), title


class Renderer:
    """Draws screens of one size.

    Args:
        size: of the surfaces drawn on, pixels.
        ui_factor: the user's wish for larger (> 1) or smaller text.
        messages: the texts of the participant's language; English if None.
        pictures: of the robots, where the task takes some; others may take in newer ones.
    """

    def __init__(
        self,
        size: tuple[int, int],
        ui_factor: float = 1.0,
        messages: Messages | None = None,
        pictures: Pictures | None = None,
    ) -> None:
        self.canvas = Canvas(size, ui_factor, messages)
        self._wanted = self.canvas.scale
        self._scales: dict[Hashable, float] = {}
        self._last: Screen | None = None
        self._fleet_kind: Hashable = None
        self._rehearsal: Iterator[None] = iter(())
        self._pictures = 0
        self._painter = fleet.FleetPainter(pictures)

    def go_on_from(self, motion: Motion) -> None:
        """Draw robots on their way from where they were before: for who takes note of screens."""
        self._painter.motion = motion

    @property
    def overflows(self) -> list[str]:
        """Texts that did not fit into the screen drawn last."""
        return self.canvas.overflows

    def draw(
        self, surface: pygame.Surface, screen: Screen, now_ns: int
    ) -> list[pygame.Rect] | None:
        """Draw a screen.

        Args:
            surface: of the renderer's size; what was drawn on it before is built upon.
            screen: what to show.
            now_ns: session time, for what moves.

        Returns:
            The places that changed since the last picture, pixels; None if all of it did.
        """
        canvas, last = self.canvas, self._last
        same_surface = canvas.surface is surface
        if screen is last and same_surface and isinstance(screen, STILL):
            return []
        kind = layout_kind(screen)
        known = kind in self._scales
        if isinstance(screen, FleetScreen | CountdownScreen) and kind != self._fleet_kind:
            self._fleet_kind = kind
            canvas.forget()
            fleet_screen = screen.fleet if isinstance(screen, CountdownScreen) else screen
            self._rehearsal = self._painter.rehearsal(canvas, fleet_screen)
        canvas.rescale(self._scales.get(kind, self._wanted))
        canvas.surface = surface
        self._last = screen
        if known and isinstance(screen, FleetScreen | CountdownScreen):
            self._rehearse()
        onto = same_surface and known and isinstance(last, FleetScreen)
        changed = self._paint(screen, now_ns, onto=onto)
        if known and isinstance(screen, FleetScreen | WaitScreen):
            return changed
        while canvas.crowded and canvas.scale > SMALLEST_FIT:
            canvas.rescale(max(SMALLEST_FIT, canvas.scale * REDUCTION))
            self._paint(screen, now_ns, onto=False)
        self._scales[kind] = canvas.scale
        return None

    def _rehearse(self) -> None:
        """Paint, now and then, a little of what may be seen later in this kind of fleet run."""
        self._pictures += 1
        if self._pictures % REHEARSED_EVERY == 0:
            next(self._rehearsal, None)

    def _paint(self, screen: Screen, now_ns: int, *, onto: bool) -> list[pygame.Rect] | None:
        with no_more_lines() if isinstance(screen, STILL) else contextlib.nullcontext():
            return self._paint_kind(screen, now_ns, onto=onto)

    def _paint_kind(self, screen: Screen, now_ns: int, *, onto: bool) -> list[pygame.Rect] | None:
        canvas = self.canvas
        canvas.begin()
        match screen:
            case FleetScreen():
                return self._painter.draw(canvas, screen, now_ns, onto=onto)
            case CountdownScreen():
                self._painter.draw(canvas, screen.fleet, now_ns, onto=False)
                side = waiting.disc_side(canvas)
                middle = fleet_places.clear_place(canvas, screen.fleet, side)
                waiting.draw_countdown(canvas, screen, middle)
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
            case KeyTrialScreen():
                simple.draw_key_trial(canvas, screen)
            case EndScreen():
                simple.draw_end(canvas, screen)
        return None

    def targets(self, screen: Screen) -> Targets:
        """Return all that can be clicked on a screen, the topmost last."""
        canvas = self.canvas
        kind = layout_kind(screen)
        if kind not in self._scales:
            # The scale that fits is known once it is drawn.
            self.draw(pygame.Surface(canvas.size), screen, 0)
        canvas.rescale(self._scales[kind])
        match screen:
            case FleetScreen():
                return fleet_places.targets(canvas, screen)
            case CountdownScreen():
                return fleet_places.targets(canvas, screen.fleet)
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
            "robot:3" (index from 0), "answer:q1:5", "focus:q1", "digit:age:5", "delete:age",
            "confirm", "back", "continue", "stop", "erase", "agree", "decline", or "" for nothing.
        """
        for target, place in reversed(self.targets(screen)):
            if place.collidepoint(x, y):
                return target
        return ""
