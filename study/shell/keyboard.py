"""Names of keys: lower case, the same on every layout and for the keypad."""

from __future__ import annotations

import pygame

NAMED: dict[int, str] = {
    pygame.K_UP: "up",
    pygame.K_DOWN: "down",
    pygame.K_LEFT: "left",
    pygame.K_RIGHT: "right",
    pygame.K_TAB: "tab",
    pygame.K_RETURN: "return",
    pygame.K_KP_ENTER: "return",
    pygame.K_ESCAPE: "escape",
    pygame.K_BACKSPACE: "backspace",
    pygame.K_SPACE: "space",
    pygame.K_F12: "f12",
    pygame.K_KP_MINUS: "-",
    pygame.K_KP_EQUALS: "=",
}
KEYPAD: dict[int, str] = {getattr(pygame, f"KSCAN_KP_{digit}"): str(digit) for digit in range(10)}
NUMBER_ROW: dict[int, str] = {
    **{getattr(pygame, f"KSCAN_{digit}"): str(digit) for digit in range(10)},
    pygame.KSCAN_MINUS: "-",
    pygame.KSCAN_EQUALS: "=",
}
"""The row above the letters by place: its digits need Shift on some layouts (French)."""
LETTERS = range(pygame.K_a, pygame.K_z + 1)


def key_name(keycode: int, scancode: int) -> str:
    """Return a key's name: "up", "tab", "return", "1", "-", "a", ...

    Args:
        keycode: what the layout makes of the key, pygame's ``event.key``.
        scancode: where the key is, pygame's ``event.scancode``; 0 if unknown.

    Returns:
        The name; "" for keys that nothing is bound to.
    """
    if keycode in NAMED:
        return NAMED[keycode]
    if scancode in KEYPAD:
        return KEYPAD[scancode]
    if scancode in NUMBER_ROW:
        return NUMBER_ROW[scancode]
    if keycode in LETTERS:
        return chr(keycode)
    if scancode == pygame.KSCAN_UNKNOWN:
        return _by_code_alone(keycode)
    return ""


def _by_code_alone(keycode: int) -> str:
    """Name a key of an event that was made by a program and has no place."""
    if pygame.K_0 <= keycode <= pygame.K_9 or keycode in (pygame.K_MINUS, pygame.K_EQUALS):
        return chr(keycode)
    if pygame.K_KP_1 <= keycode <= pygame.K_KP_9:
        return str(keycode - pygame.K_KP_1 + 1)
    return "0" if keycode == pygame.K_KP_0 else ""
