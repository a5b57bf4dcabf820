"""A page to read: title, text, and an illustration where there is one."""

from __future__ import annotations

import pygame

from study.screens import PageScreen
from study.shell.drawing import chrome, figures, palette, points
from study.shell.drawing.canvas import Canvas

BODY = 22
LARGE_BODY = 26
SMALL_BODY = 17
"""Sizes of text in design pixels: on cards beside a figure at most, alone at most, and at least."""
GAP = 18
"""Design pixels between paragraphs."""
WIDE = 1200


def _figure(screen: PageScreen) -> str:
    return screen.figure if screen.scene is not None else ""


def _margin(canvas: Canvas, screen: PageScreen) -> int:
    """Return the margin of a page: illustrations take more width than text."""
    return chrome.content_margin(canvas, WIDE if _figure(screen) else chrome.COLUMN)


def _button(canvas: Canvas, screen: PageScreen) -> pygame.Rect:
    right = canvas.size[0] - _margin(canvas, screen)
    return chrome.button_rect(canvas, screen.action, right, chrome.footer_rect(canvas).centery)


def _back(canvas: Canvas, screen: PageScreen) -> pygame.Rect:
    footer = chrome.footer_rect(canvas)
    left = _margin(canvas, screen)
    width = chrome.keys_width(
        canvas, "Backspace", canvas.say("go back"), canvas.u(36), canvas.u(19)
    )
    return pygame.Rect(left, footer.centery - canvas.u(26), width + canvas.u(8), canvas.u(52))


def targets(canvas: Canvas, screen: PageScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked: going back and going on."""
    back = [("back", _back(canvas, screen))] if screen.can_go_back else []
    return [*back, ("confirm", _button(canvas, screen))]


def draw(canvas: Canvas, screen: PageScreen) -> None:
    """Draw the page."""
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, screen.header_left, screen.header_right)
    _draw_footer(canvas, screen)
    figure = _figure(screen)
    if not figure:
        _draw_words(canvas, screen)
        return
    area = _draw_title(canvas, screen)
    if figure == "map":
        _draw_map_page(canvas, screen, area)
    elif figure == "choose":
        _draw_choose_page(canvas, screen, area)
    else:
        _draw_assisted_page(canvas, screen, area)


def _draw_words(canvas: Canvas, screen: PageScreen) -> None:
    if screen.paragraphs:
        draw_text_page(canvas, screen.title, screen.subtitle, screen.paragraphs)
    else:
        _draw_announcement(canvas, screen)


def draw_text_page(canvas: Canvas, title: str, subtitle: str, paragraphs: tuple[str, ...]) -> None:
    """Draw a title and paragraphs on a card, in the middle of the window.

    Args:
        canvas: to draw on; header and footer are drawn by the caller.
        title: of the page.
        subtitle: sentence under it; may be empty.
        paragraphs: the text.
    """
    u, tall = canvas.u, chrome.is_tall(canvas)
    margin = chrome.content_margin(canvas)
    width = canvas.size[0] - 2 * margin
    head = u(116 if tall else 96) - (0 if subtitle else u(36))
    bottom = chrome.footer_rect(canvas).top - u(24 if tall else 16)
    room = bottom - chrome.header_height(canvas) - head
    size, height = _text_size(canvas, width, room, paragraphs)
    top = chrome.block_top(canvas, head + height + u(24 if tall else 16))
    _write_title(canvas, title, subtitle, pygame.Rect(margin, top, width, head))
    card = pygame.Rect(margin, top + head, width, height)
    _fill_card(canvas, card, paragraphs, size)


def _draw_footer(canvas: Canvas, screen: PageScreen) -> None:
    u = canvas.u
    footer = chrome.draw_footer_ground(canvas)
    button, back = _button(canvas, screen), _back(canvas, screen)
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
    margin = chrome.content_margin(canvas, WIDE)
    width = canvas.size[0] - 2 * margin
    top = chrome.header_height(canvas)
    head = u(116 if tall else 96)
    _write_title(canvas, screen.title, screen.subtitle, pygame.Rect(margin, top, width, head))
    top += head
    bottom = chrome.footer_rect(canvas).top - u(24 if tall else 16)
    return pygame.Rect(margin, top, width, bottom - top)


def _write_title(canvas: Canvas, title: str, subtitle: str, place: pygame.Rect) -> None:
    """Write a title and the sentence under it, if there is one, from the top of a place."""
    u, tall = canvas.u, chrome.is_tall(canvas)
    canvas.write(title, place.left, place.top + u(44 if tall else 34), u(36), weight="bold",
                 width=place.width)  # fmt: skip
    if subtitle:
        canvas.write(subtitle, place.left, place.top + u(83 if tall else 70), u(21),
                     colour=palette.SECONDARY, width=place.width)  # fmt: skip


def _draw_announcement(canvas: Canvas, screen: PageScreen) -> None:
    """Draw a page that has only a title and one sentence, in the middle of the window."""
    middle = (chrome.header_height(canvas) + chrome.footer_rect(canvas).top) // 2
    x, width = canvas.size[0] // 2, canvas.size[0] - canvas.u(160)
    canvas.write(screen.title, x, middle - canvas.u(28), canvas.u(52), weight="bold",
                 align="centre", width=width)  # fmt: skip
    canvas.write(screen.subtitle, x, middle + canvas.u(32), canvas.u(24),
                 colour=palette.SECONDARY, align="centre", width=width)  # fmt: skip


def _padding(canvas: Canvas, width: int) -> int:
    return canvas.u(36 if width > canvas.u(560) else 26)


def _text_height(canvas: Canvas, width: int, size: int, paragraphs: tuple[str, ...]) -> int:
    """Return the height of paragraphs on a card of a width, pixels."""
    room = width - 2 * _padding(canvas, width)
    texts = sum(canvas.paragraph_height(text, room, size) for text in paragraphs)
    return texts + canvas.u(GAP) * max(0, len(paragraphs) - 1)


def _text_size(
    canvas: Canvas, width: int, height: int, paragraphs: tuple[str, ...], largest: int = LARGE_BODY
) -> tuple[int, int]:
    """Return the largest size at which all of a text fits a card, and the height of the card.

    Where there is little room what stands above and below the text gives way before its size.
    Text never gets small beside all else: where it would, the screen is tried at a smaller scale.

    Returns:
        The size of the text and the height of the card around it, pixels.
    """
    pad = 2 * _padding(canvas, width)
    for around in (pad, pad // 2):
        for size in range(canvas.u(largest), canvas.u(SMALL_BODY) - 1, -1):
            needed = _text_height(canvas, width, size, paragraphs) + around
            if needed <= height:
                return size, needed
    canvas.no_room(paragraphs[-1])
    return canvas.u(SMALL_BODY), height


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
    size, height = _text_size(canvas, place.width, place.height, paragraphs, BODY)
    if not whole:
        place = pygame.Rect(place.topleft, (place.width, height))
    _fill_card(canvas, place, paragraphs, size)


def _fill_card(canvas: Canvas, place: pygame.Rect, paragraphs: tuple[str, ...], size: int) -> None:
    pad = _padding(canvas, place.width)
    draw_card(canvas, place)
    spare = place.height - _text_height(canvas, place.width, size, paragraphs)
    y = place.top + max(pad // 2, min(pad, spare // 2))
    for text in paragraphs:
        # Each may take its own height, not what is left: all have the one size.
        room = pygame.Rect(place.left + pad, y, place.width - 2 * pad, place.height)
        y += canvas.paragraph(text, room, size) + canvas.u(GAP)


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
