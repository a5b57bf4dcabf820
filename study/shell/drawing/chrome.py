"""What the screens share: header, footer, key caps, the Enter button."""

from __future__ import annotations

import pygame

from study.messages import noted
from study.shell.drawing import marks, palette
from study.shell.drawing.canvas import Canvas

ARROWS = {"←": "left", "↑": "up", "→": "right", "↓": "down"}
ARROW_NAMES = frozenset(ARROWS.values())
KEY_WORDS = {
    "arrows": "← ↑ ↓ →",
    "-": "−",
    "backspace": noted("Backspace"),
    "space": noted("Space"),
    "escape": noted("Esc"),
    "return": noted("Enter"),
    "tab": noted("Tab"),
}
KEY_NAMES = frozenset({"Backspace", "Space", "Esc", "Enter", "Tab"})
ENTER = noted("Enter")
PLAIN = frozenset({"…", "–", "to", "or"})
"""Parts of a label that are words between key caps."""
COLUMN = 1040
"""Design pixels of width of what is read and answered: text, questions, points."""
ABOVE = 0.4
"""Share of the spare height above a title: the middle as the eye sees it, a little high."""
TALL_WINDOW = 860
"""Design pixels of height above which header and footer may be generous."""


def is_tall(canvas: Canvas) -> bool:
    """Return whether the window has room to spare in height."""
    return canvas.size[1] / canvas.scale > TALL_WINDOW


def header_height(canvas: Canvas) -> int:
    """Return the height of the strip at the top, pixels."""
    return canvas.u(64 if is_tall(canvas) else 54)


def footer_height(canvas: Canvas) -> int:
    """Return the height of the strip at the bottom of forms and pages, pixels."""
    return canvas.u(128 if is_tall(canvas) else 88)


def draw_header_ground(canvas: Canvas) -> int:
    """Draw the empty strip at the top; return the middle of its text, pixels."""
    height = header_height(canvas)
    width = canvas.size[0]
    canvas.surface.fill(palette.CARD, (0, 0, width, height))
    canvas.surface.fill(palette.LINE, (0, height - 1, width, 1))
    return height // 2


def draw_header(canvas: Canvas, left: str, right: str) -> None:
    """Draw the strip at the top with a text at either end."""
    y = draw_header_ground(canvas)
    margin, half = canvas.u(24), canvas.size[0] / 2 - canvas.u(32)
    canvas.write(left, margin, y, canvas.u(19), weight="semibold", width=half)
    canvas.write(
        right, canvas.size[0] - margin, y, canvas.u(19),
        colour=palette.SECONDARY, align="right", width=half,
    )  # fmt: skip


def footer_rect(canvas: Canvas) -> pygame.Rect:
    """Return the strip at the bottom of forms and pages."""
    height = footer_height(canvas)
    return pygame.Rect(0, canvas.size[1] - height, canvas.size[0], height)


def draw_footer_ground(canvas: Canvas) -> pygame.Rect:
    """Draw the empty strip at the bottom and return it."""
    place = footer_rect(canvas)
    canvas.surface.fill(palette.CARD, place)
    canvas.surface.fill(palette.LINE, (0, place.top, place.width, 1))
    return place


def block_top(canvas: Canvas, height: int) -> int:
    """Return where a title and what is under it begin, in the middle of the window or above it.

    Args:
        canvas: to draw on.
        height: of title and all under it, pixels.

    Returns:
        the top, pixels; right under the header where there is no room to spare.
    """
    spare = footer_rect(canvas).top - header_height(canvas) - height
    return header_height(canvas) + max(0, round(spare * ABOVE))


def content_margin(canvas: Canvas, widest: float = COLUMN) -> int:
    """Return the margin that centres content of at most ``widest`` design pixels."""
    return max(canvas.u(40), (canvas.size[0] - canvas.u(widest)) // 2)


def key_tokens(label: str) -> list[str]:
    """Split a label such as "← ↑ ↓ →" or "1–12 Tab" into key caps."""
    expanded = " ".join(KEY_WORDS.get(word.lower(), word) for word in label.split())
    return expanded.split()


def key_text(canvas: Canvas, token: str) -> str:
    """Return what is written on a key."""
    return canvas.say(token) if token in KEY_NAMES or token in PLAIN else token


def cap_width(canvas: Canvas, token: str, height: float) -> int:
    """Return the width of a key cap, pixels."""
    if token in ARROWS or token.lower() in ARROW_NAMES:
        return round(height * 0.96)
    text = key_text(canvas, token)
    if token in PLAIN:
        return canvas.text_width(text, height * 0.62) + round(height * 0.16)
    return max(round(height * 0.96), canvas.text_width(text, height * 0.52, "semibold")
               + round(height * 0.56))  # fmt: skip


def draw_cap(canvas: Canvas, token: str, x: float, y: float, height: float) -> int:
    """Draw a key cap from its left edge at x, its middle at y; return its width in pixels."""
    width = cap_width(canvas, token, height)
    if token in PLAIN:
        canvas.write(key_text(canvas, token), x + width / 2, y, height * 0.62,
                     colour=palette.SECONDARY, align="centre")  # fmt: skip
        return width
    place = pygame.Rect(round(x), round(y - height / 2), width, round(height))
    shade = max(2, round(height * 0.08))
    radius = height * 0.2
    canvas.box(place.move(0, shade), radius, palette.KEY_SHADE, palette.EDGE, canvas.u(1.3))
    canvas.box(place, radius, palette.CARD, palette.EDGE, canvas.u(1.3))
    direction = ARROWS.get(token, token.lower())
    if direction in ARROW_NAMES:
        marks.arrow(
            canvas, place.centerx, place.centery, height * 0.56, direction, palette.INK,
            max(1.6, height * 0.085),
        )  # fmt: skip
    else:
        canvas.write(key_text(canvas, token), place.centerx, place.centery, height * 0.52,
                     weight="semibold", align="centre")  # fmt: skip
    return width


def keys_width(canvas: Canvas, label: str, word: str, height: float, size: float) -> int:
    """Return the width of key caps followed by a word, pixels."""
    tokens = key_tokens(label)
    caps = sum(cap_width(canvas, token, height) for token in tokens)
    gaps = round(height * 0.12) * max(0, len(tokens) - 1)
    return caps + gaps + round(height * 0.3) + canvas.text_width(word, size)


def draw_keys(
    canvas: Canvas, label: str, word: str, x: float, y: float, height: float, size: float
) -> int:
    """Draw key caps followed by what they do; return the width in pixels."""
    start = x
    tokens = key_tokens(label)
    for token in tokens:
        x += draw_cap(canvas, token, x, y, height) + round(height * 0.12)
    x += round(height * 0.3) - (round(height * 0.12) if tokens else 0)
    x += canvas.write(word, x, y, size, colour=palette.SECONDARY).width
    return round(x - start)


def draw_hints(
    canvas: Canvas, hints: list[tuple[str, str]], tail: str, left: int, right: int, y: int
) -> None:
    """Draw key caps with what they do and a word after them, smaller if room is short.

    Args:
        canvas: to draw on.
        hints: (label, word) pairs.
        tail: words after the last.
        left: where they begin, pixels.
        right: where they must end, pixels.
        y: their middle, pixels.
    """
    scale = canvas.scale
    while True:
        with canvas.at(scale):
            u = canvas.u
            widths = [keys_width(canvas, *hint, u(36), u(19)) + u(26) for hint in hints]
            fits = sum(widths) + canvas.text_width(tail, u(19)) <= right - left
            if fits or scale < 0.5 * canvas.size[0] / 1280:
                x = left
                for (label, word), width in zip(hints, widths, strict=True):
                    draw_keys(canvas, label, word, x, y, u(36), u(19))
                    x += width
                canvas.write(tail, x, y, u(19), colour=palette.SECONDARY, width=right - x)
                return
        scale *= 0.95


def button_rect(canvas: Canvas, action: str, right: int, middle: int) -> pygame.Rect:
    """Return where the Enter button is, its right edge and middle given, pixels."""
    height = canvas.u(60)
    width = (
        canvas.u(18) + cap_width(canvas, ENTER, canvas.u(36)) + canvas.u(14)
        + canvas.text_width(action, canvas.u(21), "bold") + canvas.u(26)
    )  # fmt: skip
    return pygame.Rect(right - width, middle - height // 2, width, height)


def draw_button(
    canvas: Canvas, place: pygame.Rect, action: str, *, ready: bool = True, focus: bool = False
) -> None:
    """Draw the Enter button.

    Args:
        canvas: to draw on.
        place: from `button_rect`.
        action: what Enter does.
        ready: whether it does anything yet.
        focus: whether Tab has reached it.
    """
    if focus:
        edge = canvas.u(3)
        outer = place.inflate(canvas.u(14), canvas.u(14))
        canvas.box(outer, canvas.u(11), palette.CARD, palette.INK, edge)
    canvas.box(place, canvas.u(7), palette.BLUE if ready else palette.EDGE)
    height = canvas.u(36)
    width = cap_width(canvas, ENTER, height)
    cap = pygame.Rect(place.left + canvas.u(18), place.centery - height // 2, width, height)
    canvas.box(cap, canvas.u(6), palette.CARD)
    canvas.write(canvas.say(ENTER), cap.centerx, cap.centery, height * 0.52, weight="semibold",
                 align="centre")  # fmt: skip
    canvas.write(
        action, cap.right + canvas.u(14), place.centery, canvas.u(21),
        weight="bold", colour=palette.CARD,
    )  # fmt: skip
