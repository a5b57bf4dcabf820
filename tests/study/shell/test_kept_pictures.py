"""Pictures that are kept take no more room than they are given, however long a session lasts."""

from __future__ import annotations

import pygame
from hypothesis import given
from hypothesis import strategies as st

from study.shell.drawing import lettering
from study.shell.drawing.kept import Kept, size_of
from study.shell.drawing.lettering import clear_fonts, line_surface
from study.shell.drawing.sprites import ROOM, Sprites


def picture(side: int) -> pygame.Surface:
    return pygame.Surface((side, side), pygame.SRCALPHA)


@given(st.lists(st.tuples(st.integers(0, 30), st.integers(1, 24)), max_size=80))
def test_the_room_is_never_exceeded_and_the_newest_is_there(asked: list[tuple[int, int]]) -> None:
    """Against a plain list in the order of use, the oldest dropped while bytes are too many."""
    room = 6000
    kept = Kept(room)
    model: list[tuple[tuple[int, int], pygame.Surface]] = []
    for key in asked:
        known = dict(model).get(key)
        assert kept.get(key) is known
        if known is None:
            known = picture(key[1])
            kept.keep(key, known)
        model = [pair for pair in model if pair[0] != key] + [(key, known)]
        while sum(size_of(made) for _, made in model) > room and len(model) > 1:
            model.pop(0)
        assert kept.bytes == sum(size_of(made) for _, made in model)
        assert len(kept) == len(model)
    kept.clear()
    assert (kept.bytes, len(kept)) == (0, 0)


def test_a_shape_too_large_for_the_room_is_kept_alone() -> None:
    kept = Kept(10)
    small, large = picture(1), picture(40)
    kept.keep("small", small)
    kept.keep("large", large)
    assert kept.get("small") is None
    assert kept.get("large") is large


def test_an_hour_of_new_shapes_stays_within_the_room() -> None:
    """Every second of a break has a ring of its own."""
    sprites = Sprites()

    def paint(surface: pygame.Surface, _: float) -> None:
        surface.fill("white")

    for second in range(400):
        sprites.get(("ring", second), 200, 200, paint)
    assert 0 < sprites.bytes <= ROOM


def test_an_hour_of_running_numbers_keeps_their_characters_alone() -> None:
    """The clock has a line for each second, a robot that is stuck too; names of robots stay."""
    pygame.font.init()
    clear_fonts()
    for second in range(3600):
        line_surface(f"{second // 60}:{second % 60:02}", "bold", 20, (0, 0, 0), tabular=True)
    of_clock = len(lettering._LINES)
    assert of_clock == len("0123456789:")
    for second in range(1000, 1600):
        line_surface(f"STUCK {second} s", "bold", 20, (0, 0, 0))
    assert len(lettering._LINES) == of_clock
    assert line_surface("12", "bold", 20, (0, 0, 0)) is line_surface("12", "bold", 20, (0, 0, 0))
    words = [line_surface("health pack", "bold", 20, (0, 0, 0)) for _ in range(2)]
    assert words[0] is words[1]
    clear_fonts()
