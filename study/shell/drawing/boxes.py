"""Rectangles with smooth round corners."""

from __future__ import annotations

import pygame

from study.shell.drawing.palette import Colour
from study.shell.drawing.sprites import Sprites

SMALL = 8192
"""Pixels up to which a whole box is kept as one picture; of larger ones only the corners are."""


def paint(
    surface: pygame.Surface,
    sprites: Sprites,
    place: pygame.Rect,
    radius: float,
    fill: Colour,
    edge: Colour | None,
    edge_width: float,
) -> None:
    """Paint a rectangle.

    Args:
        surface: to paint on.
        sprites: where smooth shapes are kept.
        place: outer edge.
        radius: of the corners, pixels.
        fill: colour inside.
        edge: colour of the edge, or None.
        edge_width: pixels, inside ``place``.
    """
    r = max(1, min(round(radius), place.width // 2, place.height // 2))
    line = max(1, round(edge_width)) if edge is not None else 0

    def smooth(surface: pygame.Surface, k: float) -> None:
        outer = surface.get_rect()
        pygame.draw.rect(surface, edge or fill, outer, border_radius=round(r * k))
        if line:
            inner = outer.inflate(-2 * line * k, -2 * line * k)
            pygame.draw.rect(surface, fill, inner, border_radius=max(0, round((r - line) * k)))

    blend = pygame.BLEND_PREMULTIPLIED
    if 0 < place.width * place.height <= SMALL:
        whole = sprites.get(("box", place.size, r, line, fill, edge), *place.size, smooth)
        surface.blit(whole, place, special_flags=blend)
        return
    corners = sprites.get(("box", r, line, fill, edge), 2 * r, 2 * r, smooth)
    surface.fill(fill, place.inflate(-2 * r, 0))
    surface.fill(fill, place.inflate(0, -2 * r))
    right, bottom = place.right - r, place.bottom - r
    surface.blit(corners, place.topleft, (0, 0, r, r), blend)
    surface.blit(corners, (right, place.top), (r, 0, r, r), blend)
    surface.blit(corners, (place.left, bottom), (0, r, r, r), blend)
    surface.blit(corners, (right, bottom), (r, r, r, r), blend)
    if line and edge is not None:
        across, down = place.width - 2 * r, place.height - 2 * r
        for x, y, width, height in (
            (place.left + r, place.top, across, line),
            (place.left + r, place.bottom - line, across, line),
            (place.left, place.top + r, line, down),
            (place.right - line, place.top + r, line, down),
        ):
            surface.fill(edge, (x, y, max(0, width), max(0, height)))
