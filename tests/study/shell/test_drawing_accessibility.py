"""Every screen measured: contrast of text and marks, and colours for colour-blind eyes."""

from __future__ import annotations

from itertools import combinations

import pytest

import sample_screens as samples
from colour_vision import DEFICIENCIES, ciede2000, distance
from study.messages import messages_for
from study.screens import Cue, CueKind, Screen
from study.shell.drawing import cues, palette
from study.shell.drawing.drawn import Boxed, Written
from study.shell.drawing.palette import Colour, contrast
from watched_drawing import fleets, watched

pytestmark = pytest.mark.usefixtures("fonts")

SCREENS: dict[str, Screen] = {**fleets(), **samples.samples()}
TEXT, MARK = 4.5, 3.0
"""WCAG 2.2, success criteria 1.4.3 and 1.4.11."""
DECORATION = {palette.LINE}
"""Edges of cards, which say nothing."""
SHARE = 0.15
"""Share of a text's ground from which a colour counts; less is an edge that it touches."""


@pytest.mark.parametrize("name", SCREENS)
def test_text_has_the_contrast_that_reading_needs(name: str) -> None:
    """Each line against each colour that it is written on."""
    _, seen = watched(SCREENS[name], (1280, 720))
    weak = []
    for item in seen:
        if not isinstance(item.drawn, Written):
            continue
        # A number on a robot touches what is around the robot: its ground is what prevails.
        grounds = item.ground[:1] if item.drawn.moving else item.ground
        weak += [
            (item.drawn.text, item.drawn.colour, colour)
            for place, (colour, share) in enumerate(grounds)
            if (place == 0 or share >= SHARE) and contrast(item.drawn.colour, colour) < TEXT
        ]
    assert weak == []
    assert any(isinstance(item.drawn, Written) for item in seen)


@pytest.mark.parametrize("name", SCREENS)
def test_boxes_that_mean_something_stand_out(name: str) -> None:
    """A key, a button, an answer, a pill: its edge or its fill against what it lies on."""
    _, seen = watched(SCREENS[name], (1280, 720))
    weak = []
    for item in seen:
        box = item.drawn
        if not isinstance(box, Boxed) or box.edge is None or box.edge in DECORATION:
            continue
        ground = item.ground[0][0]
        if max(contrast(box.edge, ground), contrast(box.fill, ground)) < MARK:
            inside = contrast(box.edge, box.fill)
            if inside < MARK:
                weak.append((box.place, box.fill, box.edge, ground))
    assert weak == []


MARKS: dict[str, tuple[Colour, Colour]] = {
    "wall on floor": (palette.WALL, palette.FLOOR),
    "wall on the driven floor": (palette.WALL, palette.CARD),
    "robot on floor": (palette.AUTONOMOUS, palette.FLOOR),
    "driven robot on its floor": (palette.BLUE, palette.CARD),
    "driven frame on page": (palette.BLUE, palette.PAGE),
    "suggested dashes": (palette.ORANGE, palette.INK),
    "suggested frame on page": (palette.INK, palette.PAGE),
    "pack on floor": (palette.GREEN, palette.FLOOR),
    "hatch on its ground": (palette.HATCH, palette.HATCH_GROUND),
    "goal's ring": (palette.SECONDARY, palette.FLOOR),
    "health in its bar": (palette.GREEN, palette.CARD),
    "low health in its bar": (palette.VERMILLION, palette.CARD),
    "health's edge on a plate": (palette.INK, palette.PLATE),
    "trail on floor": (palette.TRAIL, palette.FLOOR),
    "ring of the dwell on white": (palette.BLUE, palette.CARD),
    "stuck ring": (palette.INK, palette.YELLOW),
    "damage's star": (palette.VERMILLION_TEXT, palette.VERMILLION_TINT),
    "goal's disc on floor": (palette.GREEN_TEXT, palette.FLOOR),
}


@pytest.mark.parametrize("mark", MARKS)
def test_marks_have_the_contrast_that_seeing_needs(mark: str) -> None:
    """Each drawn mark against what it is drawn on."""
    assert contrast(*MARKS[mark]) >= MARK


CATEGORIES: dict[str, tuple[Colour, ...]] = {
    "who drives": (palette.BLUE, palette.AUTONOMOUS, palette.ORANGE),
    "pills": (
        palette.INK, palette.GREEN_TEXT, palette.VERMILLION_TEXT, palette.YELLOW, palette.CARD,
    ),
    "health": (palette.GREEN, palette.VERMILLION),
    "map": (palette.FLOOR, palette.WALL, palette.HATCH, palette.GREEN),
}  # fmt: skip
CLEARLY_APART = 10.0
"""CIEDE2000; about 1 is just seen, side by side."""


@pytest.mark.parametrize("sight", ["none", *DEFICIENCIES])
@pytest.mark.parametrize("group", CATEGORIES)
def test_colours_that_tell_things_apart_do_so_for_every_eye(group: str, sight: str) -> None:
    """Colours of one group stay clearly apart under each simulated deficiency."""
    least = min(distance(a, b, sight) for a, b in combinations(CATEGORIES[group], 2))
    assert least >= CLEARLY_APART


def test_cues_differ_without_their_colour() -> None:
    """The tints of plates are too alike for colour-blind eyes: each cue has words of its own."""
    kinds: tuple[CueKind, ...] = (
        "held",
        "lost",
        "time_up",
        "goal",
        "damage",
        "stuck",
        "low",
        "pack",
    )
    words = {cues.pill_text(messages_for("en"), Cue(kind, 5.0, 0)) for kind in kinds}
    assert len(words) == len(kinds)
    assert set(cues.STYLES) == set(kinds)


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ((50.0, 2.6772, -79.7751), (50.0, 0.0, -82.7485), 2.0425),
        ((50.0, 2.5, 0.0), (61.0, -5.0, 29.0), 22.8977),
        ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
    ],
)
def test_distance_is_the_published_one(
    first: tuple[float, float, float], second: tuple[float, float, float], expected: float
) -> None:
    """Pairs of the test data of Sharma, Wu and Dalal (2005)."""
    assert ciede2000(first, second) == pytest.approx(expected, abs=1e-4)


def test_grey_stays_grey_under_every_deficiency() -> None:
    """The simulation leaves white, grey and black as they are."""
    for sight in DEFICIENCIES:
        for level in (0, 128, 255):
            assert distance((level,) * 3, (level,) * 3, sight) == 0
            grey: Colour = (level, level, level)
            from colour_vision import lab, seen_by

            seen, plain = lab(seen_by(grey, sight)), lab(seen_by(grey, "none"))
            assert ciede2000(seen, plain) < 0.5
