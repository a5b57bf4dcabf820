"""Every screen at every supported size: nothing clipped, everything to be clicked is found."""

from __future__ import annotations

import dataclasses
import hashlib

import pygame
import pytest

import sample_screens as samples
from study.screens import FleetScreen, SurveyScreen
from study.shell.drawing.drawn import Written
from study.shell.drawing.fleet_places import tile_places
from study.shell.drawing.header import clock_text
from study.shell.drawing.lettering import text_width, wrap
from study.shell.drawing.renderer import Renderer
from study.shell.drawing.reveal import axis_ticks, number_text
from watched_drawing import show_until_rehearsed, watched

pytestmark = pytest.mark.usefixtures("fonts")

SIZES = [(1280, 720), (1280, 960), (1920, 1080), (2560, 1440)]
SCREENS = samples.samples()


def drawn(name: str, size: tuple[int, int]) -> tuple[pygame.Surface, Renderer]:
    surface, renderer = pygame.Surface(size), Renderer(size)
    renderer.draw(surface, SCREENS[name], samples.T_NS)
    return surface, renderer


@pytest.mark.parametrize("name", SCREENS)
@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def test_every_screen_fits(name: str, size: tuple[int, int]) -> None:
    """A screen draws at this size, in several colours, and no text is clipped."""
    surface, renderer = drawn(name, size)
    assert renderer.overflows == []
    small = pygame.transform.scale(surface, (160, 90))
    colours = {tuple(small.get_at((x, y))) for x in range(160) for y in range(90)}
    assert len(colours) > 2


def test_overflow_is_reported() -> None:
    """A text too long for its place is reported, so that the test above can fail."""
    _, renderer = drawn("page_ready", (1280, 720))
    surface = pygame.Surface((1280, 720))
    long = dataclasses.replace(samples.ready(), title="a title without end " * 12)
    renderer.draw(surface, long, 0)
    assert renderer.overflows == [long.title]


@pytest.mark.parametrize("name", SCREENS)
@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def test_targets_are_on_the_screen_and_hit(name: str, size: tuple[int, int]) -> None:
    """Every target lies on the screen and is what a click in its middle, or near it, hits."""
    renderer, screen = Renderer(size), SCREENS[name]
    bounds = pygame.Rect((0, 0), size)
    for target, place in renderer.targets(screen):
        assert bounds.contains(place), target
        # A question's middle is one of its answers; its upper left corner is its own.
        x, y = (place.left + 3, place.top + 3) if target.startswith("focus") else place.center
        assert renderer.hit(screen, x, y) == target


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
@pytest.mark.parametrize("name", [n for n in SCREENS if n.startswith("fleet")])
def test_every_robot_can_be_clicked(name: str, size: tuple[int, int]) -> None:
    """There is a tile for every robot shown, and no two overlap."""
    renderer, screen = Renderer(size), SCREENS[name]
    assert isinstance(screen, FleetScreen)
    places = dict(renderer.targets(screen))
    assert list(places) == [f"robot:{robot}" for robot in range(screen.robots)]
    rects = list(places.values())
    assert all(rect.collidelistall(rects) == [index] for index, rect in enumerate(rects))


def test_every_answer_and_the_button_can_be_clicked() -> None:
    """A survey offers each answer of each question, each question and Enter."""
    screen = SCREENS["survey_open"]
    assert isinstance(screen, SurveyScreen)
    found = {target for target, _ in Renderer((1280, 720)).targets(screen)}
    answers = {f"answer:{item.item}:{value}" for item in screen.items for value in range(1, 8)}
    assert found == answers | {"focus:q1", "focus:q2", "confirm"}


def test_page_goes_back_only_where_it_can() -> None:
    """The target to go back exists only on pages that have one before them."""
    renderer = Renderer((1280, 960))
    assert [name for name, _ in renderer.targets(SCREENS["page_text"])] == ["back", "confirm"]
    assert [name for name, _ in renderer.targets(SCREENS["page_ready"])] == ["confirm"]


def test_pause_offers_both_ways_out() -> None:
    """A pause can be ended and the session stopped, before and after asking again."""
    renderer = Renderer((1280, 720))
    for name in ("pause", "pause_stop"):
        assert {target for target, _ in renderer.targets(SCREENS[name])} == {"stop", "continue"}


def test_nothing_is_hit_beside_targets() -> None:
    """A click on the header hits nothing."""
    assert Renderer((1280, 960)).hit(SCREENS["fleet_12"], 5, 5) == ""


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def test_driven_tile_differs_in_more_than_hue(size: tuple[int, int]) -> None:
    """Seen without colour, a driven tile differs from the same tile undriven in many pixels."""
    screen = dataclasses.replace(samples.fleet(12, operated=4, cued=False))
    other = dataclasses.replace(screen, operated=-1)
    renderer, grey = Renderer(size), []
    place = tile_places(renderer.canvas, screen)[4].body
    for shown in (screen, other):
        surface = pygame.Surface(size)
        Renderer(size).draw(surface, shown, samples.T_NS)
        grey.append(pygame.transform.grayscale(surface.subsurface(place.inflate(8, 8))))
    width, height = grey[0].get_size()
    different = sum(
        abs(grey[0].get_at((x, y)).r - grey[1].get_at((x, y)).r) > 40
        for x in range(width)
        for y in range(height)
    )
    assert different > 0.1 * width * height


def test_cue_never_changes_a_frame() -> None:
    """The pixels around a tile are the same with and without a cue: frames mean control only."""
    size = (1280, 960)
    corners = []
    for cued in (True, False):
        surface, screen = pygame.Surface(size), samples.fleet(12, operated=4, cued=cued)
        renderer = Renderer(size)
        renderer.draw(surface, screen, samples.T_NS)
        rims = []
        for place in tile_places(renderer.canvas, screen):
            body = place.body
            rims.append([tuple(surface.get_at((x, body.top - 3))) for x in range(*_span(body))])
        corners.append(rims)
    assert corners[0] == corners[1]


def _span(rect: pygame.Rect) -> tuple[int, int]:
    return rect.left, rect.right


def test_repeated_parts_look_the_same() -> None:
    """A second frame, put together from remembered parts, equals the first."""
    for name in ("fleet_12", "assisted_landing"):
        surface, renderer = drawn(name, (1280, 720))
        again = pygame.Surface((1280, 720))
        renderer.draw(again, SCREENS[name], samples.T_NS)
        assert surface.get_buffer().raw == again.get_buffer().raw


def test_change_of_health_is_drawn() -> None:
    """A remembered tile is painted anew when its robot's health changes."""
    surface, renderer = drawn("fleet_4", (1280, 720))
    screen = SCREENS["fleet_4"]
    assert isinstance(screen, FleetScreen)
    hurt = dataclasses.replace(screen.tiles[0], health=12.0)
    after = pygame.Surface((1280, 720))
    renderer.draw(after, dataclasses.replace(screen, tiles=(hurt, *screen.tiles[1:])), samples.T_NS)
    plate = tile_places(renderer.canvas, screen)[0].plate
    before = surface.subsurface(plate).copy().get_buffer().raw
    assert before != after.subsurface(plate).copy().get_buffer().raw


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.0, "0:00"), (0.1, "0:01"), (41.6, "0:42"), (60.0, "1:00"), (605.0, "10:05"), (-3, "0:00")],
)
def test_clock(seconds: float, text: str) -> None:
    """Time left is minutes and seconds, where a started second counts."""
    assert clock_text(seconds) == text


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [(1384.2, 0, "1,384"), (-5.0, 0, "−5"), (-0.04, 1, "0.0"), (7.55, 1, "7.5"), (-0.6, 0, "−1")],
)
def test_numbers(value: float, decimals: int, text: str) -> None:
    """Numbers have a true minus, thousands in commas and no minus before zero."""
    assert number_text(value, decimals) == text


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 300.0), (-100.0, 300.0), (-7.0, 3.0), (0, 1), (0, 5000)]
)
def test_axis_encloses_what_it_shows(low: float, high: float) -> None:
    """The ticks enclose what is shown by less than a step, zero is one of them, they are few."""
    ticks = axis_ticks(low, high)
    assert 0.0 in ticks
    step = ticks[1] - ticks[0]
    assert min(ticks) <= low < min(ticks) + step
    assert max(ticks) - step < high <= max(ticks)
    assert 2 <= len(ticks) <= 7


@pytest.mark.parametrize("width", [60, 130, 200, 333, 648, 5000])
def test_wrapping_keeps_all_words_within_the_width(width: int) -> None:
    """The lines hold the text's words in order, and none is too long unless it is one word."""
    text = "Trying out set 1 of what you taught them. There is nothing to do for you."
    lines = wrap(text, "medium", 21, width)
    assert " ".join(lines) == text
    assert all(" " not in line or text_width(line, "medium", 21) <= width for line in lines)


def test_wrapping_leaves_no_word_alone_where_it_can() -> None:
    """A last line of a single word is avoided if that costs no further line."""
    text = "Trying out set 1 of what you taught them. There is nothing to do for you."
    width = text_width(text, "medium", 21) - 5
    lines = wrap(text, "medium", 21, width)
    assert len(lines) == 2
    assert " " in lines[-1]


def test_tabular_digits_are_equally_wide() -> None:
    """A clock of ones is as wide as one of eights, so that it does not jump."""
    widths = {text_width(text, "bold", 26, tabular=True) for text in ("1:11", "8:88")}
    assert len(widths) == 1


def test_what_was_drawn_of_a_view_is_forgotten_with_it() -> None:
    """After twelve tiles one large tile takes what it takes alone; within a view shapes stay."""
    twelve = SCREENS["fleet_12"]
    assert isinstance(twelve, FleetScreen)
    surface, renderer = drawn("fleet_12", SIZES[1])
    renderer.draw(surface, SCREENS["countdown"], samples.T_NS)
    of_tiles = renderer.canvas.sprites.bytes
    renderer.draw(surface, samples.moved(twelve), samples.T_NS + 125_000_000)
    assert renderer.canvas.sprites.bytes >= of_tiles > 0
    renderer.draw(surface, SCREENS["assisted_cue"], samples.T_NS)
    _, alone = drawn("assisted_cue", SIZES[1])
    assert renderer.canvas.sprites.bytes == alone.canvas.sprites.bytes


def test_rings_that_close_are_not_kept() -> None:
    """Each of them has a size of its own: a participant who is switched for an hour sees all."""
    landing = SCREENS["assisted_landing"]
    assert isinstance(landing, FleetScreen)
    surface, renderer = drawn("assisted_landing", SIZES[1])
    show_until_rehearsed(renderer, surface, landing, landing.switched_ns)
    first = renderer.canvas.sprites.bytes
    looks = set()
    for milliseconds in range(0, 300, 10):
        t_ns = landing.switched_ns + milliseconds * 1_000_000
        renderer.draw(surface, landing, t_ns)
        looks.add(hashlib.sha256(pygame.image.tobytes(surface, "RGB")).digest())
    assert len(looks) > 20
    assert renderer.canvas.sprites.bytes <= first + 100_000


def test_where_all_robots_are_seen_the_illustration_shows_several() -> None:
    """One of them driven; where only one is seen, that one."""
    numbers = {}
    for figure in ("assisted", "assisted_all"):
        screen = dataclasses.replace(samples.page("assisted"), figure=figure)
        renderer, seen = watched(screen, (1280, 720), 2.0)
        assert renderer.overflows == []
        words = [item.drawn.text for item in seen if isinstance(item.drawn, Written)]
        numbers[figure] = [word for word in words if word in ["1", "2", "3", "4", "7"]]
        assert [word for word in words if word.startswith("YOU")] != []
    assert set(numbers["assisted_all"]) == {"1", "2", "3", "4"}
    assert set(numbers["assisted"]) == {"7"}
