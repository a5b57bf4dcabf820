"""Names of keys on every layout."""

from __future__ import annotations

import pygame
import pytest

from study.seat_settings import KEY_NAMES, KeyPart
from study.shell.fleet import EMERGENCY_KEY
from study.shell.keyboard import key_name


@pytest.mark.parametrize(
    ("keycode", "scancode", "name"),
    [
        (pygame.K_UP, pygame.KSCAN_UP, "up"),
        (pygame.K_TAB, pygame.KSCAN_TAB, "tab"),
        (pygame.K_RETURN, pygame.KSCAN_RETURN, "return"),
        (pygame.K_KP_ENTER, pygame.KSCAN_KP_ENTER, "return"),
        (pygame.K_ESCAPE, pygame.KSCAN_ESCAPE, "escape"),
        (pygame.K_BACKSPACE, pygame.KSCAN_BACKSPACE, "backspace"),
        (pygame.K_SPACE, pygame.KSCAN_SPACE, "space"),
        (pygame.K_q, pygame.KSCAN_Q, "q"),
        (pygame.K_KP_7, pygame.KSCAN_KP_7, "7"),
        (pygame.K_KP_0, pygame.KSCAN_KP_0, "0"),
        (pygame.K_MINUS, pygame.KSCAN_MINUS, "-"),
        (pygame.K_EQUALS, pygame.KSCAN_EQUALS, "="),
        (pygame.K_F12, pygame.KSCAN_F12, "f12"),
        (pygame.K_F1, pygame.KSCAN_F1, ""),
        (pygame.K_LSHIFT, pygame.KSCAN_LSHIFT, ""),
    ],
)
def test_names(keycode: int, scancode: int, name: str) -> None:
    """A key has its canonical name, the keypad those of the main keys, others none."""
    assert key_name(keycode, scancode) == name


@pytest.mark.parametrize(("place", "digit"), [(pygame.KSCAN_1, "1"), (pygame.KSCAN_0, "0")])
def test_number_row_counts_by_place(place: int, digit: str) -> None:
    """On a French layout, whose first key says "&", the number row still gives digits."""
    assert key_name(pygame.K_AMPERSAND, place) == digit


def test_letters_follow_the_layout() -> None:
    """On a French layout the key at Q's place is an A, and is named so."""
    assert key_name(pygame.K_a, pygame.KSCAN_Q) == "a"


def test_events_without_a_place_are_named_by_code() -> None:
    """An event made by a program may have no scancode."""
    codes = [pygame.K_0, pygame.K_9, pygame.K_MINUS, pygame.K_EQUALS, pygame.K_KP_0, pygame.K_KP_9]
    assert [key_name(code, 0) for code in codes] == ["0", "9", "-", "=", "0", "9"]
    assert key_name(pygame.K_F1, 0) == ""


def test_what_can_be_bound_is_what_the_window_tells_of() -> None:
    """Protocols are checked without pygame: by names that are those of its keys."""
    codes = [code for name, code in vars(pygame).items() if name.startswith("K_")]
    places = [code for name, code in vars(pygame).items() if name.startswith("KSCAN_")]
    told = {key_name(code, 0) for code in codes} | {key_name(0, place) for place in places}
    assert told - {"", EMERGENCY_KEY} == set(KEY_NAMES)


def test_every_default_binding_can_be_pressed() -> None:
    """Each key that a protocol binds by default is the name of some key."""
    codes = [
        *range(pygame.K_SPACE, pygame.K_DELETE), pygame.K_UP, pygame.K_DOWN, pygame.K_LEFT,
        pygame.K_RIGHT, pygame.K_TAB, pygame.K_RETURN, pygame.K_ESCAPE, pygame.K_BACKSPACE,
    ]  # fmt: skip
    names = {key_name(code, 0) for code in codes}
    keys = KeyPart()
    bound = {*keys.robots, *(v for v in keys.model_dump().values() if isinstance(v, str))}
    assert bound <= names
