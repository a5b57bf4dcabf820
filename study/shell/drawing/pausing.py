"""The pause: going on, stopping and keeping the recording, stopping and erasing it."""

from __future__ import annotations

import pygame

from study.screens import PauseScreen
from study.shell.drawing import chrome, palette
from study.shell.drawing.canvas import Canvas

CARD_WIDTH = 860
MARGIN, EDGE = 56, 48
APART = 24
"""Design pixels between stopping and going on, lest one be taken for the other."""


def _words(canvas: Canvas, screen: PauseScreen) -> tuple[str, str]:
    say = canvas.say
    if screen.confirm_erase:
        return (
            say("Stop and erase?"),
            say("The session ends, and all that was recorded of you in this study is removed "
                "for good, from earlier sessions too."),
        )  # fmt: skip
    if screen.confirm_stop:
        return say("Stop the session?"), say("It ends here. What was recorded so far is kept.")
    if not screen.can_go_on:
        return (
            screen.reason, say("Everything stands still. The experimenter will go on with you.")
        )  # fmt: skip
    return (
        screen.reason or say("Paused"), say("Everything stands still. Go on when you are ready.")
    )  # fmt: skip


def _choices(canvas: Canvas, screen: PauseScreen) -> list[tuple[str, str, str]]:
    """Return (target, key, words) of what can be done besides going on."""
    say = canvas.say
    if screen.confirm_erase:
        return [("erase", "Y", say("yes, erase"))]
    if screen.confirm_stop:
        return [("stop", "Y", say("yes, stop"))]
    if not screen.can_erase:
        return [("stop", "Q", say("stop the session"))]
    return [("stop", "Q", say("stop and keep")), ("erase", "E", say("stop and erase"))]


def _action(canvas: Canvas, screen: PauseScreen) -> str:
    """Return what Enter does; empty if it does nothing."""
    asked = screen.confirm_stop or screen.confirm_erase
    if not screen.can_go_on:
        return canvas.say("to go back") if asked else ""
    return canvas.say("to go on instead") if asked else canvas.say("to go on")


def _inside(canvas: Canvas, screen: PauseScreen) -> tuple[pygame.Rect, int, int]:
    """Return the card without its margin, and the heights of its words, pixels."""
    u = canvas.u
    title, text = _words(canvas, screen)
    wide = max(u(CARD_WIDTH) - 2 * u(MARGIN), _keys_width(canvas, screen))
    width = min(wide, canvas.size[0] - u(48) - 2 * u(MARGIN))
    heights = (
        canvas.paragraph_height(title, width, u(36), "bold"),
        canvas.paragraph_height(text, width, u(21)),
    )
    place = pygame.Rect(0, 0, width, sum(heights) + u(12 + 44 + 60))
    place.center = (canvas.size[0] // 2, canvas.size[1] // 2)
    return place, *heights


def _choice_width(canvas: Canvas, key: str, words: str) -> int:
    u = canvas.u
    return chrome.keys_width(canvas, key, words, u(36), u(19)) + u(16)


def _keys_width(canvas: Canvas, screen: PauseScreen) -> int:
    """Return the width at which stopping and going on stand well apart, pixels."""
    u = canvas.u
    action = _action(canvas, screen)
    if not action:
        return 0
    choices = [_choice_width(canvas, key, words) for _, key, words in _choices(canvas, screen)]
    going_on = chrome.button_rect(canvas, action, 0, 0).width
    return sum(choices) + u(8) * (len(choices) - 2) + u(APART) + going_on


def targets(canvas: Canvas, screen: PauseScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked in a pause."""
    u = canvas.u
    inside, _, _ = _inside(canvas, screen)
    middle = inside.bottom - u(30)
    action = _action(canvas, screen)
    button = chrome.button_rect(canvas, action or canvas.say("to go on"), inside.right, middle)
    found = []
    left = inside.left - u(8)
    for target, key, words in _choices(canvas, screen):
        width = _choice_width(canvas, key, words)
        found.append((target, pygame.Rect(left, button.top, width, button.height)))
        left += width + u(8)
    return [*found, ("continue", button)] if action else found


def draw(canvas: Canvas, screen: PauseScreen) -> None:
    """Draw the pause: how to go on, and how to stop."""
    u = canvas.u
    canvas.surface.fill(palette.PAGE)
    inside, title_height, text_height = _inside(canvas, screen)
    card = inside.inflate(2 * u(MARGIN), 2 * u(EDGE))
    canvas.box(card, u(10), palette.CARD, palette.LINE, u(1.4))
    title, text = _words(canvas, screen)
    canvas.paragraph(title, pygame.Rect(inside.topleft, (inside.width, title_height)), u(36),
                     weight="bold")  # fmt: skip
    top = inside.top + title_height + u(12)
    canvas.paragraph(text, pygame.Rect(inside.left, top, inside.width, text_height), u(21),
                     colour=palette.SECONDARY)  # fmt: skip
    places = dict(targets(canvas, screen))
    if _keys_width(canvas, screen) > inside.width:
        canvas.no_room("how to stop")
    for target, key, words in _choices(canvas, screen):
        place = places[target]
        chrome.draw_keys(canvas, key, words, place.left + u(8), place.centery, u(36), u(19))
    if action := _action(canvas, screen):
        chrome.draw_button(canvas, places["continue"], action)
