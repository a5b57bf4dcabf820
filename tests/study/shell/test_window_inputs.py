"""The window under SDL's dummy driver: events in, screens out."""

from __future__ import annotations

import dataclasses
import sys
import time
import types
from collections.abc import Iterator

import pygame
import pytest

import sample_screens as samples
from patience import PATIENCE_S
from study.errors import StudyError
from study.screens import Screen
from study.shell.drawing.renderer import Renderer
from study.shell.pygame_check import require_pygame_ce
from study.shell.raw_inputs import (
    RawClose,
    RawFocus,
    RawKey,
    RawPointer,
    RawText,
    RawWindow,
)
from study.shell.window import Window


@pytest.fixture(autouse=True)
def _no_display(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


@pytest.fixture
def window() -> Iterator[Window]:
    opened = Window((1280, 720))
    opened.poll()
    yield opened
    opened.close()


def post_key(key: int, *, down: bool) -> None:
    kind = pygame.KEYDOWN if down else pygame.KEYUP
    pygame.event.post(pygame.event.Event(kind, key=key, scancode=0, mod=0, unicode=""))


def test_keys_arrive_in_order_with_both_halves_of_a_tap(window: Window) -> None:
    """Down and up of a tap shorter than a frame both arrive, in the order of the queue."""
    for key, down in (
        (pygame.K_UP, True), (pygame.K_7, True), (pygame.K_7, False), (pygame.K_UP, False),
    ):  # fmt: skip
        post_key(key, down=down)
    seen = [(raw.key, raw.down) for raw in window.poll() if isinstance(raw, RawKey)]
    assert seen == [("up", True), ("7", True), ("7", False), ("up", False)]
    assert window.poll() == []


def test_stamp_and_gap_bound_the_event(window: Window) -> None:
    """An event is stamped at the poll, and its gap reaches back to the poll before."""
    before = time.perf_counter_ns()
    window.poll()
    time.sleep(0.01)
    post_key(pygame.K_SPACE, down=True)
    (raw,) = window.poll()
    assert isinstance(raw, RawKey)
    assert before <= raw.at_perf_ns <= time.perf_counter_ns()
    assert 10_000_000 <= raw.poll_gap_ns <= raw.at_perf_ns - before


def test_unbound_keys_and_motion_are_no_inputs(window: Window) -> None:
    """Function keys, other buttons and mouse motion are left out."""
    post_key(pygame.K_F5, down=True)
    for kind, fields in (
        (pygame.MOUSEMOTION, {"pos": (1, 1), "rel": (0, 0), "buttons": (0, 0, 0)}),
        (pygame.MOUSEBUTTONDOWN, {"pos": (1, 1), "button": pygame.BUTTON_RIGHT}),
    ):
        pygame.event.post(pygame.event.Event(kind, fields))
    assert window.poll() == []


def test_click_names_what_it_hits(window: Window) -> None:
    """A click on a tile of the screen shown carries the tile's robot."""
    window.show(samples.fleet(4, operated=1))
    targets = dict(Renderer(window.size).targets(samples.fleet(4, operated=1)))
    place = targets["robot:2"].center
    event = pygame.event.Event(pygame.MOUSEBUTTONDOWN, pos=place, button=pygame.BUTTON_LEFT)
    pygame.event.post(event)
    (raw,) = window.poll()
    assert isinstance(raw, RawPointer)
    assert (raw.x, raw.y, raw.target) == (*place, "robot:2")


def test_click_before_any_screen_hits_nothing(window: Window) -> None:
    """Without a screen a click has no target."""
    event = pygame.event.Event(pygame.MOUSEBUTTONDOWN, pos=(640, 360), button=1)
    pygame.event.post(event)
    (raw,) = window.poll()
    assert isinstance(raw, RawPointer)
    assert raw.target == ""


def test_focus_and_close_arrive(window: Window) -> None:
    """Losing and gaining the keyboard and closing are inputs of their own."""
    for kind in (pygame.WINDOWFOCUSLOST, pygame.WINDOWFOCUSGAINED, pygame.QUIT):
        pygame.event.post(pygame.event.Event(kind))
    lost, gained, closed = window.poll()
    assert isinstance(lost, RawFocus)
    assert isinstance(gained, RawFocus)
    assert (lost.focused, gained.focused) == (False, True)
    assert isinstance(closed, RawClose)


def test_wait_ends_with_a_key_and_keeps_it(window: Window) -> None:
    """A key ends the wait at once and is the first thing polled after it."""
    post_key(pygame.K_a, down=True)
    post_key(pygame.K_a, down=False)
    start = time.monotonic()
    window.wait(PATIENCE_S)
    assert time.monotonic() - start < PATIENCE_S / 2
    assert [raw.key for raw in window.poll() if isinstance(raw, RawKey)] == ["a", "a"]


@pytest.mark.parametrize("seconds", [0.0, 0.0004, 0.03, -1.0])
def test_wait_without_events_lasts_about_as_asked(window: Window, seconds: float) -> None:
    """An undisturbed wait returns by itself, also one shorter than a millisecond."""
    start = time.monotonic()
    window.wait(seconds)
    assert max(0.0, seconds) - 0.002 <= time.monotonic() - start < PATIENCE_S


def test_draws_what_is_shown(window: Window) -> None:
    """After showing a screen the picture changes."""
    surface = pygame.display.get_surface()
    assert surface is not None
    window.draw(0)
    before = surface.copy().get_buffer().raw
    window.show(samples.survey())
    window.draw(0)
    assert surface.copy().get_buffer().raw != before


def test_describes_itself(window: Window) -> None:
    """Driver, size and rate are those of the display; no window number without X11."""
    assert (window.driver, window.size, window.window_id) == ("dummy", (1280, 720), 0)
    assert window.refresh_hz > 0
    window.set_caption("Study P01")
    assert pygame.display.get_caption()[0] == "Study P01"


def test_no_audio_is_opened(window: Window) -> None:
    """Opening the window leaves the sound alone."""
    assert pygame.mixer.get_init() is None


def test_window_can_be_opened_again() -> None:
    """Fonts and display of a closed window leave nothing behind."""
    for _ in range(2):
        opened = Window((1280, 720))
        opened.show(samples.fleet(2, operated=0))
        opened.draw(0)
        opened.close()


def test_small_window_is_refused() -> None:
    """A size on which text would be clipped is refused with the smallest that works."""
    with pytest.raises(StudyError, match="800x600") as caught:
        Window((800, 600))
    assert "1280x720" in str(caught.value)


def test_other_pygame_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The package pygame is refused, and the message says how to mend it."""
    other = types.ModuleType("pygame")
    monkeypatch.setitem(sys.modules, "pygame", other)
    with pytest.raises(StudyError, match="pip install pygame-ce"):
        require_pygame_ce()


def test_missing_pygame_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is no pygame at all the message says what to install."""
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(StudyError, match="pygame-ce cannot be loaded"):
        require_pygame_ce()


def test_pygame_ce_is_accepted() -> None:
    """The pygame of this environment is pygame-ce."""
    require_pygame_ce()


def post_text(text: str) -> None:
    pygame.event.post(pygame.event.Event(pygame.TEXTINPUT, text=text))


def test_characters_arrive_only_while_a_question_takes_words(window: Window) -> None:
    """The same keys are no text before a scale or a number."""
    form = samples.about_you()
    window.show(form)
    post_text("7")
    assert [raw for raw in window.poll() if isinstance(raw, RawText)] == []
    window.show(dataclasses.replace(form, focus=2))
    post_text("é")
    assert [raw.text for raw in window.poll() if isinstance(raw, RawText)] == ["é"]


def test_minimising_and_restoring_arrive(window: Window) -> None:
    """Each with the window's size; an event of the size that it has already is no change."""
    for kind in (pygame.WINDOWSIZECHANGED, pygame.WINDOWMINIMIZED, pygame.WINDOWRESTORED):
        pygame.event.post(pygame.event.Event(kind, x=1280, y=720))
    changes = [raw for raw in window.poll() if isinstance(raw, RawWindow)]
    assert [(raw.change, raw.width, raw.height) for raw in changes] == [
        ("minimised", 1280, 720), ("restored", 1280, 720)
    ]  # fmt: skip


def test_what_is_clicked_on_the_new_screens(window: Window) -> None:
    """Answers of consent and of a choice, the break's button once it does something."""
    surface_screens: dict[str, Screen] = {
        "agree": samples.consent(),
        "decline": samples.consent(),
        "answer:games:3": samples.about_you(),
        "focus:age": samples.about_you(),
        "digit:age:7": samples.about_you(),
        "delete:age": samples.about_you(),
        "answer:mental:55": samples.load_index(),
        "erase": samples.samples()["pause_erase"],
        "confirm": samples.samples()["break_may"],
    }
    for target, screen in surface_screens.items():
        window.show(screen)
        window.draw(0)
        place = dict(Renderer(window.size).targets(screen))[target]
        post_click(place.left + 2 if target == "focus:age" else place.centerx, place.centery)
        (raw,) = [raw for raw in window.poll() if isinstance(raw, RawPointer)]
        assert raw.target == target
    waiting = samples.samples()["break_must"]
    assert Renderer(window.size).targets(waiting) == []
    assert "confirm" not in dict(Renderer(window.size).targets(samples.consent()))
    assert "confirm" in dict(Renderer(window.size).targets(samples.consent("agreed")))


def post_click(x: int, y: int) -> None:
    pygame.event.post(
        pygame.event.Event(pygame.MOUSEBUTTONDOWN, pos=(x, y), button=pygame.BUTTON_LEFT)
    )


def test_a_painted_picture_is_shown_when_presented(
    window: Window, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Painting leaves the display alone; presenting shows it once; a resize voids it."""
    shown: list[str] = []
    monkeypatch.setattr(pygame.display, "flip", lambda: shown.append("all"))
    monkeypatch.setattr(pygame.display, "update", lambda _: shown.append("parts"))
    window.show(samples.fleet(4, operated=0))
    window.paint(0)
    assert shown == []
    window.present()
    window.present()
    assert shown == ["all"]

    screen = samples.fleet(4, operated=0)
    moved = dataclasses.replace(screen.tiles[1], x=screen.tiles[1].x + 1.0)
    window.show(dataclasses.replace(screen, tiles=(screen.tiles[0], moved, *screen.tiles[2:])))
    window.paint(0)
    assert shown == ["all"]
    window.present()
    assert shown == ["all", "parts"]

    window.paint(0)
    pygame.display.set_mode((1300, 800))
    pygame.event.post(pygame.event.Event(pygame.WINDOWSIZECHANGED, x=1300, y=800))
    window.poll()
    window.present()
    assert shown == ["all", "parts"]
    window.paint(0)
    window.present()
    assert shown == ["all", "parts", "all"]
