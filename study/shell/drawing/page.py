"""A page to read: title, text, and an illustration where there is one."""

from __future__ import annotations

import pygame

from study.screens import PageScreen
from study.shell.drawing import chrome, figures, palette, points
from study.shell.drawing.canvas import Canvas

TEXT_WIDTH = 900
BODY = 22


def _button(canvas: Canvas, screen: PageScreen) -> pygame.Rect:
    right = canvas.size[0] - chrome.content_margin(canvas)
    return chrome.button_rect(canvas, screen.action, right, chrome.footer_rect(canvas).centery)


def _back(canvas: Canvas) -> pygame.Rect:
    footer = chrome.footer_rect(canvas)
    left = chrome.content_margin(canvas)
    width = chrome.keys_width(
        canvas, "Backspace", canvas.say("go back"), canvas.u(36), canvas.u(19)
    )
    return pygame.Rect(left, footer.centery - canvas.u(26), width + canvas.u(8), canvas.u(52))


def targets(canvas: Canvas, screen: PageScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked: going back and going on."""
    back = [("back", _back(canvas))] if screen.can_go_back else []
    return [*back, ("confirm", _button(canvas, screen))]


def draw(canvas: Canvas, screen: PageScreen) -> None:
    """Draw the page."""
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, screen.header_left, screen.header_right)
    _draw_footer(canvas, screen)
    figure = screen.figure if screen.scene is not None else ""
    if not figure and not screen.paragraphs:
        _draw_announcement(canvas, screen)
        return
    area = _draw_title(canvas, screen)
    if figure == "map":
        _draw_map_page(canvas, screen, area)
    elif figure == "choose":
        _draw_choose_page(canvas, screen, area)
    elif figure == "assisted":
        _draw_assisted_page(canvas, screen, area)
    else:
        area.width = min(area.width, canvas.u(TEXT_WIDTH))
        draw_text_card(canvas, area, screen.paragraphs, whole=False)


def _draw_footer(canvas: Canvas, screen: PageScreen) -> None:
    u = canvas.u
    footer = chrome.draw_footer_ground(canvas)
    button, back = _button(canvas, screen), _back(canvas)
    left = back.right if screen.can_go_back else back.left
    if screen.can_go_back:
        chrome.draw_keys(
            canvas, "Backspace", canvas.say("go back"), back.left, footer.centery, u(36), u(19)
        )
    if screen.next_hint:
        room = button.left - left - u(48)
        width = min(room, canvas.text_width(screen.next_hint, u(19)))
        middle = min(max(canvas.size[0] / 2, left + u(24) + width / 2),
                     button.left - u(24) - width / 2)  # fmt: skip
        canvas.write(screen.next_hint, middle, footer.centery, u(19), colour=palette.SECONDARY,
                     align="centre", width=room)  # fmt: skip
    chrome.draw_button(canvas, button, screen.action)


def _draw_title(canvas: Canvas, screen: PageScreen) -> pygame.Rect:
    """Draw title and subtitle; return the area left over."""
    u, tall = canvas.u, chrome.is_tall(canvas)
    margin = chrome.content_margin(canvas)
    width = canvas.size[0] - 2 * margin
    top = chrome.header_height(canvas)
    canvas.write(screen.title, margin, top + u(44 if tall else 34), u(36), weight="bold",
                 width=width)  # fmt: skip
    canvas.write(screen.subtitle, margin, top + u(83 if tall else 70), u(21),
                 colour=palette.SECONDARY, width=width)  # fmt: skip
    top += u(116 if tall else 96)
    bottom = chrome.footer_rect(canvas).top - u(24 if tall else 16)
    return pygame.Rect(margin, top, width, bottom - top)


def _draw_announcement(canvas: Canvas, screen: PageScreen) -> None:
    """Draw a page that has only a title and one sentence, in the middle of the window."""
    middle = (chrome.header_height(canvas) + chrome.footer_rect(canvas).top) // 2
    x, width = canvas.size[0] // 2, canvas.size[0] - canvas.u(160)
    canvas.write(screen.title, x, middle - canvas.u(28), canvas.u(52), weight="bold",
                 align="centre", width=width)  # fmt: skip
    canvas.write(screen.subtitle, x, middle + canvas.u(32), canvas.u(24),
                 colour=palette.SECONDARY, align="centre", width=width)  # fmt: skip


def draw_text_card(
    canvas: Canvas, place: pygame.Rect, paragraphs: tuple[str, ...], *, whole: bool = True
) -> None:
    """Draw paragraphs on a card.

    Args:
        canvas: to draw on.
        place: of the card.
        paragraphs: the text.
        whole: whether the card fills the place, or only what the text needs.
    """
    u = canvas.u
    pad = u(36 if place.width > u(560) else 26)
    width = place.width - 2 * pad
    size, gap = u(BODY), u(18)

    def needed(pixels: int) -> int:
        texts = sum(canvas.paragraph_height(text, width, pixels) for text in paragraphs)
        return texts + gap * max(0, len(paragraphs) - 1)

    while needed(size) + 2 * pad > place.height and size > u(17):
        size -= 1
    if not whole:
        place = pygame.Rect(place.topleft, (place.width, min(place.height, needed(size) + 2 * pad)))
    draw_card(canvas, place)
    y = place.top + pad
    for text in paragraphs:
        room = pygame.Rect(place.left + pad, y, width, place.bottom - pad // 2 - y)
        y += canvas.paragraph(text, room, size) + gap


def draw_card(canvas: Canvas, place: pygame.Rect) -> None:
    """Draw an empty card."""
    canvas.box(place, canvas.u(10), palette.CARD, palette.LINE, canvas.u(1.4))


def _draw_map_page(canvas: Canvas, screen: PageScreen, area: pygame.Rect) -> None:
    u = canvas.u
    gap = u(20 if chrome.is_tall(canvas) else 14)
    if screen.rewards:
        height = points.row_height(canvas)
        row = pygame.Rect(area.left, area.bottom - height, area.width, height)
        draw_card(canvas, row)
        points.draw(canvas, screen, row)
        area = pygame.Rect(area.topleft, (area.width, area.height - height - gap))
    left = pygame.Rect(area.topleft, (round(area.width * 0.59), area.height))
    right = pygame.Rect(left.right + gap, area.top, area.right - left.right - gap, area.height)
    draw_card(canvas, left)
    figures.draw_annotated_map(canvas, screen, left.inflate(-u(40), -u(36)))
    lower = screen.robots > 1 or screen.paragraphs
    keys = right.copy()
    if lower:
        keys.height = round((right.height - gap) * 0.52)
    draw_card(canvas, keys)
    figures.draw_arrow_keys(canvas, keys)
    if not lower:
        return
    rest = pygame.Rect(right.left, keys.bottom + gap, right.width, right.bottom - keys.bottom - gap)
    if screen.paragraphs:
        draw_text_card(canvas, rest, screen.paragraphs)
    else:
        draw_card(canvas, rest)
        figures.draw_choosing(canvas, screen, rest)


def _draw_choose_page(canvas: Canvas, screen: PageScreen, area: pygame.Rect) -> None:
    gap = canvas.u(20 if chrome.is_tall(canvas) else 14)
    share = 0.6 if screen.paragraphs else 1.0
    height = min(round(area.height * share), canvas.u(420))
    upper = pygame.Rect(area.topleft, (area.width, height))
    draw_card(canvas, upper)
    figures.draw_choosing(canvas, screen, upper)
    if screen.paragraphs:
        rest = pygame.Rect(
            area.left, upper.bottom + gap, area.width, area.bottom - upper.bottom - gap
        )
        draw_text_card(canvas, rest, screen.paragraphs, whole=False)


def _draw_assisted_page(canvas: Canvas, screen: PageScreen, area: pygame.Rect) -> None:
    gap = canvas.u(20 if chrome.is_tall(canvas) else 14)
    share = 0.58 if screen.paragraphs else 1.0
    left = pygame.Rect(area.topleft, (round(area.width * share), area.height))
    draw_card(canvas, left)
    figures.draw_switching(canvas, screen, left.inflate(-canvas.u(48), -canvas.u(44)))
    if screen.paragraphs:
        right = pygame.Rect(left.right + gap, area.top, area.right - left.right - gap, area.height)
        draw_text_card(canvas, right, screen.paragraphs)
