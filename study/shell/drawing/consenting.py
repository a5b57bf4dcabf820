"""Consent: the text, and two answers of equal size, neither preselected."""

from __future__ import annotations

import pygame

from study.screens import ConsentScreen
from study.shell.drawing import chrome, marks, page, palette
from study.shell.drawing.canvas import Canvas


def _answers(canvas: Canvas) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return (key, words) of agreeing and of declining."""
    return ("Y", canvas.say("I agree to take part")), ("N", canvas.say("I do not agree"))


def _places(canvas: Canvas) -> tuple[pygame.Rect, pygame.Rect, pygame.Rect]:
    """Return where agreeing, declining and confirming stand."""
    u = canvas.u
    footer = chrome.footer_rect(canvas)
    margin = chrome.content_margin(canvas)
    boxes = []
    left = margin
    for pair in _answers(canvas):
        width = chrome.keys_width(canvas, *pair, u(36), u(19)) + u(52)
        boxes.append(pygame.Rect(left, footer.centery - u(28), width, u(56)))
        left += width + u(16)
    right = canvas.size[0] - margin
    return (
        boxes[0],
        boxes[1],
        chrome.button_rect(canvas, canvas.say("to confirm"), right, footer.centery),
    )


def targets(canvas: Canvas, screen: ConsentScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked; confirming only once something is chosen."""
    agree, decline, confirm = _places(canvas)
    found = [("agree", agree), ("decline", decline)]
    return [*found, ("confirm", confirm)] if screen.chosen else found


def draw(canvas: Canvas, screen: ConsentScreen) -> None:
    """Draw the text and both answers."""
    u = canvas.u
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, canvas.say("Consent"), canvas.say("Nothing is recorded yet"))
    page.draw_text_page(canvas, screen.title, "", screen.paragraphs)
    footer = chrome.draw_footer_ground(canvas)
    agree, decline, confirm = _places(canvas)
    yes, no = _answers(canvas)
    for place, pair, chosen in (
        (agree, yes, screen.chosen == "agreed"),
        (decline, no, screen.chosen == "declined"),
    ):
        edge = palette.BLUE_DARK if chosen else palette.EDGE
        fill = palette.BLUE_TINT if chosen else palette.CARD
        canvas.box(place, u(8), fill, edge, u(3 if chosen else 1.6))
        chrome.draw_keys(canvas, *pair, place.left + u(12), footer.centery, u(36), u(19))
        if chosen:
            marks.tick(canvas, place.right - u(20), place.centery, u(20), palette.BLUE_DARK, u(4))
    chrome.draw_button(canvas, confirm, canvas.say("to confirm"), ready=bool(screen.chosen))
