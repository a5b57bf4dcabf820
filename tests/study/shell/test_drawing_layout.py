"""Nothing is clipped and nothing overlaps: all fleets, sizes, scales, and long words."""

from __future__ import annotations

import dataclasses
import re

import pygame
import pytest

import sample_screens as samples
from study.screens import ConsentScreen, CountdownScreen, Cue, PageScreen, Screen, View
from study.shell.drawing.drawn import Boxed, Written
from study.shell.drawing.fleet_places import NOBODY, layout
from study.shell.drawing.maps import MapView
from study.shell.drawing.renderer import SMALLEST_FIT, Renderer
from watched_drawing import Seen, fleets, watched

pytestmark = pytest.mark.usefixtures("fonts")

SIZES = [((1280, 720), 1.0), ((1280, 720), 2.0), ((1920, 1080), 1.5), ((2560, 1440), 2.0)]
EVERY_TIME = [((1280, 720), 1.0, "en"), ((1280, 720), 2.0, "pseudo")]
"""Where there is least room; the others are looked at in acceptance only."""
LOOKS = [
    pytest.param(
        *(look := (size, factor, locale)),
        id=f"{size[0]}x{size[1]}-{factor}-{locale}",
        marks=() if look in EVERY_TIME else pytest.mark.acceptance,
    )
    for size, factor in SIZES
    for locale in ("en", "pseudo")
]
SCREENS: dict[str, Screen] = {
    **fleets(),
    **{name: screen for name, screen in samples.samples().items() if not name.startswith("fleet_")},
}
KEY_SIGNS = re.compile(r"^(.|[0-9]+)$")
"""What stands on keys and robots is no word: single signs and numbers."""


def problems(size: tuple[int, int], renderer: Renderer, seen: list[Seen]) -> list[str]:
    """Return in words what is clipped or lies on something else."""
    found = [f"clipped: {text}" for text in renderer.overflows]
    bounds = pygame.Rect((0, 0), size)
    still = [item.drawn for item in seen if not item.drawn.moving]
    texts = [drawn for drawn in still if isinstance(drawn, Written)]
    boxes = [drawn for drawn in still if isinstance(drawn, Boxed)]
    found += [f"off the screen: {box.place}" for box in boxes if not bounds.contains(box.place)]
    for index, text in enumerate(texts):
        found += [
            f"{text.text!r} on {other.text!r}"
            for other in texts[index + 1 :]
            if text.place.colliderect(other.place)
        ]
        found += [
            f"{text.text!r} reaches over the edge of {box.place}"
            for box in boxes
            if text.place.colliderect(box.place) and not box.place.contains(text.place)
        ]
    return found


@pytest.mark.parametrize(("size", "factor", "locale"), LOOKS)
@pytest.mark.parametrize("name", SCREENS)
def test_nothing_is_clipped_or_overlaps(
    name: str, size: tuple[int, int], factor: float, locale: str
) -> None:
    """Every text lies within the screen and its box, and on no other text."""
    renderer, seen = watched(SCREENS[name], size, factor, locale)
    assert problems(size, renderer, seen) == []
    assert renderer.canvas.scale > SMALLEST_FIT


def test_the_check_can_fail() -> None:
    """A text on another, one over the edge of its box, and a clipped one are all reported."""
    size = (1280, 720)
    renderer, seen = watched(samples.ready(), size)
    written = next(item for item in seen if isinstance(item.drawn, Written))
    box = next(item for item in seen if isinstance(item.drawn, Boxed))
    half = dataclasses.replace(
        written.drawn, place=pygame.Rect(box.drawn.place.left - 10, box.drawn.place.top, 20, 10)
    )
    renderer.overflows.append("too long")
    found = " ".join(problems(size, renderer, [written, written, box, Seen(half, ())]))
    assert "clipped: too long" in found
    assert " on " in found
    assert "reaches over the edge" in found


@pytest.mark.parametrize("name", SCREENS)
def test_every_word_comes_from_the_catalogue(name: str) -> None:
    """In the pseudo-locale no plain letter is written, but for the signs on keys."""
    _, seen = watched(SCREENS[name], (1280, 720), 1.0, "pseudo")
    texts = {item.drawn.text for item in seen if isinstance(item.drawn, Written)}
    plain = {text for text in texts if re.search("[A-Za-z]", text) and not KEY_SIGNS.match(text)}
    assert plain == set()


def test_a_larger_scale_makes_larger_text_where_there_is_room() -> None:
    """At 2 a page of text is written larger than at 1, though it fits both times."""
    heights = []
    for factor in (1.0, 2.0):
        _, seen = watched(samples.ready(), (2560, 1440), factor)
        heights.append(max(i.drawn.place.height for i in seen if isinstance(i.drawn, Written)))
    assert heights[1] > 1.5 * heights[0]


def lines_of(text: str, seen: list[Seen]) -> list[pygame.Rect]:
    """Return where the lines of a text are written; no key, number or other short word is one."""
    written = [item.drawn for item in seen if isinstance(item.drawn, Written)]
    return [line.place for line in written if " " in line.text and line.text in text]


@pytest.mark.parametrize("name", ["page_text", "page_choose", "consent"])
def test_paragraphs_share_one_size(name: str) -> None:
    """Where there is little room none of them is written smaller than the others."""
    screen = SCREENS[name]
    assert isinstance(screen, PageScreen | ConsentScreen)
    _, seen = watched(screen, (1280, 720), 2.0)
    lines = lines_of(" ".join(screen.paragraphs), seen)
    assert len(lines) >= len(screen.paragraphs) > 1
    assert len({place.height for place in lines}) == 1


@pytest.mark.parametrize("cued", [False, True])
def test_a_sentence_in_a_plate_keeps_clear_of_what_is_above_and_below(cued: bool) -> None:
    """Of a cue's pill and of health, at any scale; and it does not move when a cue comes."""
    screen = dataclasses.replace(samples.assisted(), switched_ns=-1)
    cue = Cue("stuck", 7.0, samples.T_NS) if cued else None
    tiles = tuple(dataclasses.replace(tile, cue=cue) for tile in screen.tiles)
    renderer, seen = watched(dataclasses.replace(screen, tiles=tiles), (1280, 720), 2.0)
    lines = lines_of("The other 11 robots drive themselves.", seen)
    sentence = lines[0].unionall(lines[1:])
    gap = renderer.canvas.u(8)
    around = sentence.inflate(0, 2 * gap)
    boxes = [item.drawn.place for item in seen if isinstance(item.drawn, Boxed)]
    beside = [box for box in boxes if not box.contains(around)]
    assert [box for box in beside if box.colliderect(around)] == []
    _, uncued = watched(screen, (1280, 720), 2.0)
    assert sentence.topleft in {i.drawn.place.topleft for i in uncued}


def test_the_scale_stays_while_a_screen_is_looked_at() -> None:
    """An answer or a passing second never changes the size of what is written."""
    renderer, surface = Renderer((1280, 720), 2.0), pygame.Surface((1280, 720))
    scales = []
    for screen in (samples.survey(), samples.survey(values=(5, 4), focus=2), samples.survey()):
        renderer.draw(surface, screen, 0)
        scales.append(renderer.canvas.scale)
    assert scales[1] == scales[2]


@pytest.mark.parametrize("view", ["tiles", "enlarged"])
def test_a_picture_built_upon_the_last_equals_one_drawn_anew(view: str) -> None:
    """What is left standing from the picture before is what would be drawn again."""
    size = (1280, 720)
    start = dataclasses.replace(samples.fleet(12, operated=4), view=view)  # type: ignore[arg-type]
    steps = [
        samples.moved(start),
        start,
        dataclasses.replace(start, operated=7, switched_ns=samples.T_NS, timestep=148),
        dataclasses.replace(start, operated=7, seconds_left=30.0, timestep=149),
        dataclasses.replace(start, operated=-1, message="Choose a robot to drive", timestep=150),
        dataclasses.replace(start, operated=2, timestep=151, tiles=samples.tiles(12, cued=False)),
    ]
    kept, surface = Renderer(size), pygame.Surface(size)
    for number, step in enumerate(steps):
        now = samples.T_NS + number * 50_000_000
        kept.draw(surface, step, now)
        changed = kept.draw(surface, step, now + 30_000_000)
        assert changed is not None
        anew = Renderer(size)
        for before in steps[: number + 1]:
            picture = pygame.Surface(size)
            anew.draw(picture, before, now + 30_000_000)
        assert surface.get_buffer().raw == picture.get_buffer().raw


def test_nothing_is_drawn_where_nothing_changed() -> None:
    """A still screen shown again, and a fleet at the same moment, change no place."""
    surface, renderer = pygame.Surface((1280, 720)), Renderer((1280, 720))
    for screen in (samples.survey(), samples.fleet(12)):
        renderer.draw(surface, screen, samples.T_NS)
        assert renderer.draw(surface, screen, samples.T_NS) == []


LARGE = ((1280, 720), 2.0)


def words_seen(seen: list[Seen]) -> dict[str, pygame.Rect]:
    """Return where each line was written."""
    return {item.drawn.text: item.drawn.place for item in seen if isinstance(item.drawn, Written)}


@pytest.mark.parametrize("look", [LARGE, ((1280, 720), 1.0), ((1280, 960), 1.0)])
@pytest.mark.parametrize("rewards", [(-34.0,), (-50.0, 3.0, -49.0, 60.0)])
def test_points_number_and_axis_keep_apart(
    look: tuple[tuple[int, int], float], rewards: tuple[float, ...]
) -> None:
    """The points under a bar, its trial's number and the words under it have room between them."""
    screen = dataclasses.replace(
        samples.reveal(negative=True), trial_rewards=rewards, total=sum(rewards),
        scale_low=-50.0, scale_high=75.0,
    )  # fmt: skip
    renderer, seen = watched(screen, *look)
    least = renderer.canvas.u(6)
    written = [item.drawn for item in seen if isinstance(item.drawn, Written)]
    caption = next(text for text in written if text.text == "Points in each trial").place
    plot = [text for text in written if text.place.top > caption.bottom]
    for index, one in enumerate(plot):
        grown = one.place.inflate(0, 2 * least)
        assert [other.text for other in plot[index + 1 :] if grown.colliderect(other.place)] == []


@pytest.mark.parametrize("locale", ["en", "pseudo"])
@pytest.mark.parametrize("factor", [1.0, 1.5, 2.0])
def test_stopping_and_going_on_stand_apart(factor: float, locale: str) -> None:
    """Else one might be taken for the other."""
    for name in ("pause", "pause_erase", "pause_erase_sure", "pause_stop"):
        renderer, _ = watched(SCREENS[name], (1280, 720), factor, locale)
        places = dict(renderer.targets(SCREENS[name]))
        going_on = places.pop("continue")
        last = max(place.right for place in places.values())
        assert going_on.left - last >= renderer.canvas.u(16)


def test_words_in_the_countdown_grow_with_the_scale() -> None:
    """Its disc stays small over the tiles; its words need not."""
    heights = []
    for factor in (1.0, 2.0):
        _, seen = watched(SCREENS["countdown"], (1280, 720), factor)
        heights.append(words_seen(seen)["Get ready"].height)
    assert heights[1] >= 1.3 * heights[0]


@pytest.mark.parametrize("robots", [1, 2, 4, 12])
@pytest.mark.parametrize("view", ["tiles", "enlarged"])
@pytest.mark.parametrize("look", [LARGE, ((1280, 720), 1.0), ((1280, 960), 1.0)])
def test_the_countdown_hides_no_own_robot(
    robots: int, view: View, look: tuple[tuple[int, int], float]
) -> None:
    """Neither it nor its number, nor that none is driven."""
    for operated in sorted({-1 if robots > 1 else 0, 0, robots // 2, robots - 1}):
        fleet = dataclasses.replace(
            samples.fleet(robots, operated=operated), view=view, switched_ns=-1,
            message="" if operated >= 0 else "Choose a robot to drive",
        )  # fmt: skip
        renderer, seen = watched(CountdownScreen(3, fleet), *look)
        boxes = [item.drawn for item in seen if isinstance(item.drawn, Boxed)]
        disc = [box for box in boxes if box.moving][-1].place
        places = layout(renderer.canvas, fleet)
        shown = [places.large] if places.large else []
        shown += [places.tiles[operated]] if operated >= 0 else []
        for place in shown if operated >= 0 else []:
            tile = fleet.tiles[operated]
            at = MapView(fleet.scene, place.map).robot_point(tile.x, tile.y, driven=True)
            assert not disc.collidepoint(at)
            assert not disc.colliderect(place.plate)
        if operated < 0:
            written = words_seen(seen)
            said = {text: place for text, place in written.items() if not KEY_SIGNS.match(text)}
            said.pop("Get ready")
            nobody = {t: p for t, p in said.items() if t in NOBODY or t == fleet.message}
            assert nobody
            assert disc.collidelist(list(nobody.values())) < 0
