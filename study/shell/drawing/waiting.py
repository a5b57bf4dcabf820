"""Before a trial and between blocks: the countdown over the fleet, and the rest with its timer."""

from __future__ import annotations

import math

import pygame

from study.screens import BreakScreen, CountdownScreen
from study.shell.drawing import chrome, palette
from study.shell.drawing.canvas import Canvas

DISC = 96
LARGEST_DISC = 0.12
"""Radius of the countdown's disc, as a share of the window's height."""
WORDS_SIZE = 20
CHORD = 122
"""Design pixels across the disc where its words stand."""
REST_TOP, REST_BOTTOM = 230, 190
"""What the break's words and ring take above and below the middle, design pixels."""


def disc_side(canvas: Canvas) -> int:
    """Return how wide and high the countdown's disc is, pixels."""
    return round(2 * DISC * min(canvas.scale, _largest(canvas)))


def _largest(canvas: Canvas) -> float:
    # It lies over the tiles, whose texts it may cover, so it stays small at large scales.
    return LARGEST_DISC * canvas.size[1] / DISC


def draw_countdown(canvas: Canvas, screen: CountdownScreen, middle: tuple[int, int]) -> None:
    """Draw the seconds left over the fleet, which is drawn already, around a point in pixels."""
    wished = canvas.scale
    scale = min(wished, _largest(canvas))
    with canvas.at(scale), canvas.moving():
        place = pygame.Rect(0, 0, canvas.u(2 * DISC), canvas.u(2 * DISC))
        place.center = middle
        _draw_disc(canvas, screen, place, wished / scale)


def _draw_disc(
    canvas: Canvas, screen: CountdownScreen, place: pygame.Rect, enlarged: float
) -> None:
    u = canvas.u
    words = canvas.say("Get ready")
    size = u(WORDS_SIZE)
    # The disc is smaller than wished for, its words need not be: as large as the circle allows.
    while size < u(WORDS_SIZE * enlarged) and (
        canvas.text_width(words, size + 1, "semibold") <= u(CHORD)
    ):
        size += 1
    canvas.box(place, u(DISC), palette.INK, palette.CARD, u(5))
    canvas.write(
        str(screen.seconds_left), place.centerx, place.centery - u(10), u(90), weight="bold",
        colour=palette.CARD, align="centre", tabular=True,
    )  # fmt: skip
    canvas.write(
        words, place.centerx, place.centery + u(54) - (size - u(WORDS_SIZE)) // 2, size,
        weight="semibold", colour=palette.CARD, align="centre", width=place.width - u(24),
    )  # fmt: skip


def _button(canvas: Canvas) -> pygame.Rect:
    right = canvas.size[0] - chrome.content_margin(canvas)
    return chrome.button_rect(
        canvas, canvas.say("to go on"), right, chrome.footer_rect(canvas).centery
    )


def break_targets(canvas: Canvas, screen: BreakScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked in a break: going on, once that is possible."""
    return [] if screen.wait_seconds else [("confirm", _button(canvas))]


def draw_break(canvas: Canvas, screen: BreakScreen) -> None:
    """Draw the time left as a ring around it."""
    u = canvas.u
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, canvas.say("Break"), "")
    x = canvas.size[0] // 2
    middle = (chrome.header_height(canvas) + chrome.footer_rect(canvas).top) // 2
    if middle - u(REST_TOP) < chrome.header_height(canvas) or (
        middle + u(REST_BOTTOM) > chrome.footer_rect(canvas).top
    ):
        canvas.no_room("the break")
    canvas.write(
        canvas.say("Take a break"), x, middle - u(190), u(44), weight="bold", align="centre"
    )
    canvas.write(canvas.say("Rest your eyes and hands."), x, middle - u(138), u(22),
                 colour=palette.SECONDARY, align="centre")  # fmt: skip
    radius, thick = u(104), u(14)
    left = screen.seconds_left / max(1, screen.seconds_total)
    ring = pygame.Rect(0, 0, 2 * radius, 2 * radius)
    ring.center = (x, middle + u(20))

    def paint(surface: pygame.Surface, k: float) -> None:
        area = surface.get_rect()
        pygame.draw.circle(surface, palette.LINE, area.center, area.width // 2)
        top = math.pi / 2
        if left >= 1:
            pygame.draw.circle(surface, palette.BLUE, area.center, area.width // 2)
        elif left > 0:
            points: list[tuple[float, float]] = [area.center]
            for step in range(65):
                angle = top - 2 * math.pi * (1 - left) - 2 * math.pi * left * step / 64
                points.append(
                    (
                        area.centerx + math.cos(angle) * area.width / 2,
                        area.centery - math.sin(angle) * area.width / 2,
                    )
                )
            pygame.draw.polygon(surface, palette.BLUE, points)
        pygame.draw.circle(surface, palette.PAGE, area.center, area.width // 2 - round(thick * k))

    sprite = canvas.sprite(("rest", radius, screen.seconds_left, screen.seconds_total),
                           ring.width, ring.height, paint)  # fmt: skip
    canvas.surface.blit(sprite, ring.topleft, special_flags=pygame.BLEND_PREMULTIPLIED)
    minutes, seconds = divmod(screen.seconds_left, 60)
    canvas.write(f"{minutes}:{seconds:02d}", ring.centerx, ring.centery, u(52), weight="bold",
                 align="centre", tabular=True)  # fmt: skip
    words = (
        canvas.say("You can go on in {seconds} s.", seconds=screen.wait_seconds)
        if screen.wait_seconds
        else canvas.say("Go on whenever you are ready.")
    )
    canvas.write(words, x, ring.bottom + u(40), u(22), align="centre")
    chrome.draw_footer_ground(canvas)
    chrome.draw_button(
        canvas, _button(canvas), canvas.say("to go on"), ready=not screen.wait_seconds
    )
