"""What the screens draw on: a surface, a scale, text that reports when it does not fit."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager

import pygame

from study.messages import SOURCE, Messages, messages_for
from study.shell.drawing import boxes, palette
from study.shell.drawing.drawn import Boxed, Watcher, Written, is_crowded
from study.shell.drawing.faces import CAP_HEIGHT, Weight
from study.shell.drawing.kept import Kept
from study.shell.drawing.lettering import (
    Align,
    fitting_size,
    forget_lines,
    line_ascent,
    line_surface,
    text_width,
    wrap,
)
from study.shell.drawing.palette import Colour
from study.shell.drawing.parts import Part, Parts
from study.shell.drawing.scaling import ui_scale
from study.shell.drawing.sprites import Paint, Sprites

SHRINK = 0.72
"""Text that does not fit may shrink to this share of its size before it counts as clipped."""
LEADING = 1.42
BACKGROUND_ROOM = 64 << 20
"""Bytes of all backgrounds together: four that fill the largest window, or many small ones."""


class Canvas:
    """A surface with the means to draw on it.

    Args:
        size: of the surface, pixels.
        factor: the user's wish for larger (> 1) or smaller text.
        messages: the texts of the participant's language; English if None.

    Attributes:
        surface: what is drawn on.
        size: of the surface, pixels.
        scale: pixels to one design pixel.
        overflows: texts that did not fit their place since the list was last cleared.
        written: lines written since the list was last cleared, those of kept parts included.
        boxed: boxes drawn since the list was last cleared where nothing moves, likewise.
        watcher: for tests: told of all that is drawn.
        sprites: smooth shapes.
        parts: what is repeated while it looks the same.
    """

    def __init__(
        self, size: tuple[int, int], factor: float = 1.0, messages: Messages | None = None
    ) -> None:
        self.size = size
        self.scale = ui_scale(size, factor)
        self.messages = messages or messages_for(SOURCE)
        self.say = self.messages.say
        self.count = self.messages.count
        self.surface = pygame.Surface(size)
        self.overflows: list[str] = []
        self.written: list[Written] = []
        self.boxed: list[pygame.Rect] = []
        self.watcher: Watcher | None = None
        self._aside = False
        self._moving = False
        self.sprites = Sprites()
        self._backgrounds = Kept(BACKGROUND_ROOM)
        self.parts = Parts()

    def rescale(self, scale: float) -> None:
        """Draw at another number of pixels to one design pixel from now on."""
        if scale != self.scale:
            self.scale = scale
            self.parts.clear()

    def forget(self) -> None:
        """Keep nothing of what was drawn: what follows looks otherwise.

        What is kept of a view that is gone would take room until as much is drawn of the next.
        """
        self.parts.clear()
        self.sprites.clear()
        self._backgrounds.clear()
        forget_lines()

    @contextmanager
    def at(self, scale: float) -> Iterator[None]:
        """Draw at another scale meanwhile: a strip whose texts are long is drawn smaller."""
        before, self.scale = self.scale, scale
        try:
            yield
        finally:
            self.scale = before

    def begin(self) -> None:
        """Begin a picture: nothing is written yet."""
        self.overflows.clear()
        self.written.clear()
        self.boxed.clear()

    @property
    def crowded(self) -> bool:
        """Whether anything still is clipped, lies on a text, or reaches over a box's edge."""
        return bool(self.overflows) or is_crowded(self.size, self.written, self.boxed)

    def no_room(self, what: str) -> None:
        """Report that something could not be drawn at this scale."""
        self.overflows.append(what)

    @contextmanager
    def moving(self) -> Iterator[None]:
        """Mark what is drawn meanwhile as belonging to a map and what moves on it."""
        before, self._moving = self._moving, True
        try:
            yield
        finally:
            self._moving = before

    @contextmanager
    def aside(self, surface: pygame.Surface) -> Iterator[None]:
        """Draw on another surface meanwhile: what is drawn there is no part of the screen."""
        before = self.surface, self._aside
        self.surface, self._aside = surface, True
        try:
            yield
        finally:
            self.surface, self._aside = before

    def u(self, design: float) -> int:
        """Return design pixels as pixels of the surface."""
        return round(design * self.scale)

    def sprite(self, key: Hashable, width: float, height: float, paint: Paint) -> pygame.Surface:
        """Return a smooth shape (see `Sprites.get`)."""
        return self.sprites.get(key, width, height, paint)

    def background(
        self, key: Hashable, size: tuple[int, int], paint: Callable[[], None]
    ) -> pygame.Surface:
        """Return an opaque picture that is painted once.

        Args:
            key: all that the picture depends on.
            size: pixels.
            paint: draws on this canvas, whose surface is the picture meanwhile.
        """
        found = self._backgrounds.get(key)
        if found is None:
            found = pygame.Surface(size)
            with self.aside(found):
                paint()
            self._backgrounds.keep(key, found)
        return found

    def remember(
        self,
        name: Hashable,
        key: object,
        place: pygame.Rect,
        paint: Callable[[], None],
        alike: Hashable = None,
    ) -> None:
        """Paint a part of the screen, or repeat it as it was if its key is the same.

        Args:
            name: of the part.
            key: all that its look depends on; compared with the one before.
            place: all that it covers, pixels.
            paint: paints the place in full, on this canvas.
            alike: its look but for the place, if others look the same: painted once for all.
        """
        if self._aside:
            # What is remembered is how the screen looks.
            paint()
            return
        place = place.clip(self.surface.get_rect())
        found = self.parts.find_at(name, key, place, alike if self.watcher is None else None)
        if found is not None:
            self.surface.blit(found.picture, found.place)
            self.written += found.written
            self.boxed += found.boxed
            return
        written, boxed = len(self.written), len(self.boxed)
        paint()
        picture = self.surface.subsurface(place).copy()
        texts, edges = tuple(self.written[written:]), tuple(self.boxed[boxed:])
        self.parts.keep(name, Part(place, key, picture, texts, edges), alike)

    def repeat(self, name: Hashable, key: object, within: pygame.Rect) -> bool:
        """Repeat what is remembered of a part in some rectangle of it; tell whether it could be."""
        found = self.parts.find(name, key)
        if found is None:
            return False
        area = within.clip(found.place)
        self.surface.blit(found.picture, area, area.move(-found.place.left, -found.place.top))
        return True

    def put(self, sprite: pygame.Surface, x: float, y: float, alpha: float = 1.0) -> None:
        """Draw a sprite with its middle at (x, y), whole pixels, at an opacity of 0 to 1."""
        left = round(x - sprite.get_width() / 2)
        top = round(y - sprite.get_height() / 2)
        if alpha < 1.0:
            # Premultiplied colours fade with their alpha: all four channels are scaled.
            sprite = sprite.copy()
            level = round(255 * max(0.0, alpha))
            sprite.fill((level, level, level, level), special_flags=pygame.BLEND_RGBA_MULT)
        self.surface.blit(sprite, (left, top), special_flags=pygame.BLEND_PREMULTIPLIED)

    def write(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        *,
        weight: Weight = "medium",
        colour: Colour = palette.INK,
        align: Align = "left",
        width: float | None = None,
        tabular: bool = False,
    ) -> pygame.Rect:
        """Write a line whose capitals' middle lies at y.

        Args:
            text: the line.
            x: left edge, middle or right edge, after ``align``.
            y: middle of the capitals.
            size: of the font, pixels.
            weight: of the font.
            colour: of the text.
            align: what x means.
            width: room in pixels: the text shrinks a little to fit, then counts as clipped.
            tabular: digits equally wide.

        Returns:
            The rectangle of the line: its width, and the height of its capitals.
        """
        pixels = max(1, round(size))
        if width is not None:
            pixels = fitting_size(text, weight, pixels, int(width), round(size * SHRINK))
        line = line_surface(text, weight, pixels, colour, tabular=tabular)
        length = line.get_width()
        left = x if align == "left" else x - length if align == "right" else x - length / 2
        top = y + CAP_HEIGHT * pixels / 2 - line_ascent(text, weight, pixels)
        place = pygame.Rect(
            round(left), round(y - CAP_HEIGHT * pixels / 2), length, round(CAP_HEIGHT * pixels)
        )
        outside = not self.surface.get_rect().contains(place)
        if text and (outside or (width is not None and length > width + 1)):
            self.overflows.append(text)
        if text and not self._aside:
            written = Written(text, place, colour, self._moving)
            self.written.append(written)
            if self.watcher is not None:
                self.watcher(self.surface, written)
        self.surface.blit(line, (round(left), round(top)))
        return place

    def text_width(
        self, text: str, size: float, weight: Weight = "medium", *, tabular: bool = False
    ) -> int:
        """Return the width of a line in pixels."""
        return text_width(text, weight, max(1, round(size)), tabular=tabular)

    def fits(self, text: str, size: float, width: float, weight: Weight = "medium") -> bool:
        """Return whether a line fits a width in pixels if it may shrink a little."""
        smallest = max(1, round(size * SHRINK))
        return text_width(text, weight, smallest) <= width + 1

    def paragraph_height(
        self, text: str, width: float, size: float, weight: Weight = "medium"
    ) -> int:
        """Return the height of a wrapped text in pixels."""
        pixels = max(1, round(size))
        return round(len(wrap(text, weight, pixels, int(width))) * pixels * LEADING)

    def paragraph(
        self,
        text: str,
        place: pygame.Rect,
        size: float,
        *,
        weight: Weight = "medium",
        colour: Colour = palette.INK,
        align: Align = "left",
    ) -> int:
        """Write a text wrapped into a place, from its top, shrunk a little if need be.

        Returns:
            The height used in pixels.
        """
        pixels = max(1, round(size))
        smallest = round(size * SHRINK)
        while True:
            lines = wrap(text, weight, pixels, place.width)
            leading = pixels * LEADING
            if len(lines) * leading <= place.height + 1 or pixels <= smallest:
                break
            pixels -= 1
        if len(lines) * leading > place.height + leading * 0.5:
            self.overflows.append(text)
        x = {"left": place.left, "centre": place.centerx, "right": place.right}[align]
        for number, line in enumerate(lines):
            self.write(
                line,
                x,
                place.top + (number + 0.5) * leading,
                pixels,
                weight=weight,
                colour=colour,
                align=align,
                width=place.width,
            )
        return round(len(lines) * leading)

    def box(
        self,
        place: pygame.Rect,
        radius: float,
        fill: Colour,
        edge: Colour | None = None,
        edge_width: float = 0,
    ) -> None:
        """Draw a rectangle with smooth round corners.

        Args:
            place: outer edge.
            radius: of the corners, pixels.
            fill: colour inside.
            edge: colour of the edge, or None.
            edge_width: pixels, inside ``place``.
        """
        if not self._aside and not self._moving:
            self.boxed.append(place.copy())
        if self.watcher is not None and not self._aside:
            self.watcher(self.surface, Boxed(place.copy(), fill, edge, self._moving))
        boxes.paint(self.surface, self.sprites, place, radius, fill, edge, edge_width)
