"""Colours of the participant's screens: Okabe and Ito's, safe for colour-blind eyes.

Each colour has one meaning. Text is never written in raw VERMILLION or GREEN; their darker
forms have the contrast that text needs.
"""

from __future__ import annotations

Colour = tuple[int, int, int]

INK: Colour = (0x17, 0x21, 0x2B)
SECONDARY: Colour = (0x46, 0x52, 0x5F)
PAGE: Colour = (0xE9, 0xED, 0xF1)
CARD: Colour = (0xFF, 0xFF, 0xFF)
LINE: Colour = (0xB4, 0xBE, 0xC8)
GRID: Colour = (0xD3, 0xDA, 0xE0)
EDGE: Colour = (0x5C, 0x68, 0x75)
KEY_SHADE: Colour = (0xA9, 0xB4, 0xBF)

FLOOR: Colour = (0xF6, 0xF8, 0xFA)
PLATE: Colour = (0xE2, 0xE7, 0xEB)
WALL: Colour = (0x33, 0x40, 0x4D)
AUTONOMOUS: Colour = (0x3B, 0x48, 0x55)
TRAIL: Colour = (0x6C, 0x77, 0x83)

BLUE: Colour = (0x00, 0x72, 0xB2)
BLUE_DARK: Colour = (0x00, 0x4E, 0x7A)
BLUE_TINT: Colour = (0xDC, 0xEC, 0xF6)

ORANGE: Colour = (0xE6, 0x9F, 0x00)
ORANGE_TINT: Colour = (0xFC, 0xEF, 0xD2)

VERMILLION: Colour = (0xD5, 0x5E, 0x00)
VERMILLION_TEXT: Colour = (0xA8, 0x43, 0x00)
VERMILLION_TINT: Colour = (0xFC, 0xE2, 0xD3)

GREEN: Colour = (0x00, 0x9E, 0x73)
GREEN_TEXT: Colour = (0x00, 0x6B, 0x4E)
GREEN_TINT: Colour = (0xD5, 0xEF, 0xE5)

YELLOW: Colour = (0xF0, 0xE4, 0x42)
YELLOW_TINT: Colour = (0xFA, 0xF6, 0xC6)

HATCH: Colour = (0x8B, 0x5A, 0x3C)
HATCH_GROUND: Colour = (0xE2, 0xD8, 0xD2)


def mixed(colour: Colour, ground: Colour, share: float) -> Colour:
    """Return a colour as it looks on a ground that shows through: of it, 0 to 1."""
    red, green, blue = (
        round(below + (above - below) * share) for above, below in zip(colour, ground, strict=True)
    )
    return red, green, blue


def luminance(colour: Colour) -> float:
    """Return the relative luminance of WCAG 2.2, 0 (black) to 1 (white)."""

    def linear(channel: int) -> float:
        value = channel / 255
        return value / 12.92 if value <= 0.04045 else float(((value + 0.055) / 1.055) ** 2.4)

    red, green, blue = (linear(channel) for channel in colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(first: Colour, second: Colour) -> float:
    """Return the contrast ratio of WCAG 2.2, 1 to 21; text needs at least 4.5."""
    lighter, darker = sorted((luminance(first), luminance(second)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)
