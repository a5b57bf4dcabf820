"""Screens of few words: waiting, keys that are tried, and the end."""

from __future__ import annotations

import math

import pygame

from study.screens import EndScreen, KeyTrialScreen, WaitScreen
from study.shell.drawing import chrome, marks, palette
from study.shell.drawing.canvas import Canvas

CARD_WIDTH = 820
SWEEP_SECONDS = 2.4


def _card(canvas: Canvas, height: int) -> pygame.Rect:
    """Draw a card in the middle of the window and return it without its margin."""
    canvas.surface.fill(palette.PAGE)
    place = pygame.Rect(0, 0, canvas.u(CARD_WIDTH), height)
    place.center = (canvas.size[0] // 2, canvas.size[1] // 2)
    canvas.box(place, canvas.u(10), palette.CARD, palette.LINE, canvas.u(1.4))
    return place.inflate(-2 * canvas.u(56), -2 * canvas.u(48))


def _words(canvas: Canvas, title: str, text: str) -> tuple[int, int]:
    """Return the heights of a title and of the text under it, pixels."""
    width = canvas.u(CARD_WIDTH) - 2 * canvas.u(56)
    return (
        canvas.paragraph_height(title, width, canvas.u(36), "bold"),
        canvas.paragraph_height(text, width, canvas.u(21)),
    )


def _write_words(canvas: Canvas, inside: pygame.Rect, title: str, text: str) -> int:
    """Write a title and text from the top of a card; return where they end, pixels."""
    title_height, text_height = _words(canvas, title, text)
    canvas.paragraph(
        title, pygame.Rect(inside.left, inside.top, inside.width, title_height), canvas.u(36),
        weight="bold",
    )  # fmt: skip
    top = inside.top + title_height + canvas.u(12)
    place = pygame.Rect(inside.left, top, inside.width, text_height)
    canvas.paragraph(text, place, canvas.u(21), colour=palette.SECONDARY)
    return top + text_height


def draw_wait(canvas: Canvas, screen: WaitScreen, now_ns: int) -> None:
    """Draw what is being waited for, with a bar if its progress is known."""
    heights = _words(canvas, screen.title, screen.text)
    inside = _card(canvas, sum(heights) + canvas.u(12 + 36 + 12) + 2 * canvas.u(48))
    bottom = _write_words(canvas, inside, screen.title, screen.text)
    bar = pygame.Rect(inside.left, bottom + canvas.u(36), inside.width, canvas.u(12))
    canvas.box(bar, canvas.u(6), palette.PLATE)
    if screen.progress >= 0:
        done = bar.copy()
        done.width = round(bar.width * min(1.0, screen.progress))
        if done.width >= canvas.u(12):
            canvas.box(done, canvas.u(6), palette.BLUE)
    else:
        swing = 0.5 - 0.5 * math.cos(2 * math.pi * now_ns / 1e9 / SWEEP_SECONDS)
        piece = pygame.Rect(bar.left, bar.top, bar.width // 4, bar.height)
        piece.left += round((bar.width - piece.width) * swing)
        canvas.box(piece, canvas.u(6), palette.BLUE)


def draw_key_trial(canvas: Canvas, screen: KeyTrialScreen) -> None:
    """Draw the keys to be held down, each with whether it has arrived."""
    u = canvas.u
    title = canvas.say("Hold both keys down together")
    text = canvas.say("Both must arrive at once. Without a key this ends after {seconds} s.",
                      seconds=f"{screen.seconds:g}")  # fmt: skip
    row = u(84)
    heights = _words(canvas, title, text)
    inside = _card(canvas, sum(heights) + u(12 + 28) + row * len(screen.wanted) + 2 * u(48))
    y = _write_words(canvas, inside, title, text) + u(28) + row // 2
    widest = max(chrome.cap_width(canvas, key, u(60)) for key, _ in screen.wanted)
    for key, arrived in screen.wanted:
        chrome.draw_cap(canvas, key, inside.left, y, u(60))
        canvas.write(
            canvas.say("arrived") if arrived else canvas.say("waited for"),
            inside.left + widest + u(28), y, u(24), weight="semibold" if arrived else "medium",
            colour=palette.GREEN_TEXT if arrived else palette.SECONDARY,
        )  # fmt: skip
        y += row


def _end_button(canvas: Canvas) -> pygame.Rect:
    footer = chrome.footer_rect(canvas)
    right = canvas.size[0] - chrome.content_margin(canvas)
    return chrome.button_rect(canvas, canvas.say("to close"), right, footer.centery)


def end_targets(canvas: Canvas, screen: EndScreen) -> list[tuple[str, pygame.Rect]]:  # noqa: ARG001
    """Return what can be clicked at the end: closing."""
    return [("confirm", _end_button(canvas))]


def draw_end(canvas: Canvas, screen: EndScreen) -> None:
    """Draw the last words."""
    heights = _words(canvas, screen.title, screen.text)
    mark = canvas.u(88)
    marked = mark + canvas.u(28) if screen.achieved else 0
    inside = _card(canvas, marked + canvas.u(12) + sum(heights) + 2 * canvas.u(48))
    if screen.achieved:
        x, y = inside.left + mark / 2, inside.top + mark / 2
        marks.disc(canvas, x, y, mark / 2, palette.GREEN_TEXT)
        marks.tick(canvas, x, y, mark * 0.6, palette.CARD, mark * 0.09)
    under = inside.move(0, marked)
    _write_words(canvas, under, screen.title, screen.text)
    chrome.draw_footer_ground(canvas)
    chrome.draw_button(canvas, _end_button(canvas), canvas.say("to close"))
