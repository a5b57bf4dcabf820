"""Figures: maps are centred, peaks found, pictures decodable, marks apart, text escaped."""

from __future__ import annotations

import itertools
import re
import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.figures.heat_maps import LOW_HEALTH, heading_label, signed
from analysis.figures.label_places import Box, place_labels
from analysis.figures.paired_means import paired_means, spread_labels, swarm
from analysis.figures.palettes import DARK_PRGN, LIGHT_PRGN
from analysis.figures.png import indexed_png
from analysis.figures.score_maps import filled, score_map, shared_limit
from analysis.figures.svg import Drawing, Scale
from analysis.formatting import fraction, number, p_value
from analysis.statistics.cells import Cells
from study.events.task_description import MapGrid
from study.session import cues

GRID = MapGrid(
    xs=tuple(np.arange(0.5, 12.0)),
    ys=tuple(np.arange(0.5, 8.0)),
    headings=(0.0, 1.5),
    healths=(50.0, 100.0),
    free=("111111111111",) * 6 + ("111100000000",) * 2,
)


def hills(*places: tuple[float, float, float]) -> np.ndarray:
    x, y = np.meshgrid(GRID.xs, GRID.ys)
    surface = sum(h * np.exp(-((x - px) ** 2 + (y - py) ** 2) / 2) for px, py, h in places)
    return np.broadcast_to(surface, (2, 2, 8, 12)).ravel()


def test_peaks_are_found_where_the_hills_are() -> None:
    """The two hills are the peaks, the higher one first."""
    scores = score_map("P01", hills((2.5, 2.5, 3.0), (9.5, 3.5, 5.0)), GRID)
    assert [(peak.x, peak.y) for peak in scores.peaks] == [(9.5, 3.5), (2.5, 2.5)]


def test_cells_that_are_not_free_count_for_nothing() -> None:
    """A hill where no robot can be is neither peak nor part of the mean."""
    scores = score_map("P01", hills((2.5, 2.5, 3.0), (10.5, 7.5, 50.0)), GRID)
    assert scores.peaks[0].x == 2.5 or scores.peaks[0].y < 6
    assert np.isnan(scores.mean[7, 10])
    assert np.nanmean(scores.mean) == pytest.approx(0.0, abs=1e-12)


@given(st.floats(-1e3, 1e3))
def test_a_constant_added_to_scores_changes_no_map(constant: float) -> None:
    """A Luce scorer is identified up to a constant: maps do not depend on it."""
    flat = hills((2.5, 2.5, 3.0), (9.5, 3.5, 5.0))
    first, second = score_map("P", flat, GRID), score_map("P", flat + constant, GRID)
    np.testing.assert_allclose(second.mean, first.mean, atol=1e-9)
    assert shared_limit([second]) == pytest.approx(shared_limit([first]))


def test_missing_cells_take_the_nearest_value() -> None:
    """Filling leaves known cells alone and has no gap left."""
    values = np.array([[1.0, np.nan, np.nan], [2.0, 3.0, np.nan]])
    result = filled(values)
    assert np.isfinite(result).all()
    assert result[0, 0] == 1.0
    assert result[1, 2] == 3.0


def test_picture_decodes_to_its_pixels() -> None:
    """The PNG's compressed lines hold the indices, and every chunk its checksum."""
    pixels = np.arange(12, dtype=np.uint8).reshape(3, 4)
    png = indexed_png(pixels, LIGHT_PRGN)
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    chunks, place = {}, 8
    while place < len(png):
        (length,) = struct.unpack(">I", png[place : place + 4])
        kind, content = png[place + 4 : place + 8], png[place + 8 : place + 8 + length]
        (check,) = struct.unpack(">I", png[place + 8 + length : place + 12 + length])
        assert check == zlib.crc32(kind + content)
        chunks[kind] = content
        place += 12 + length
    lines = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8).reshape(3, 5)
    np.testing.assert_array_equal(lines[:, 1:], pixels)
    assert chunks[b"PLTE"] == LIGHT_PRGN.tobytes()


def test_picture_refuses_indices_beyond_the_palette() -> None:
    """An index without colour is an error."""
    with pytest.raises(ValueError, match="palette"):
        indexed_png(np.array([[200]], dtype=np.uint8), DARK_PRGN)


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=20))
def test_axis_holds_every_value(values: list[float]) -> None:
    """Every value falls between the ends of the axis, and ticks rise."""
    scale = Scale(values, 100, 0)
    assert all(-1e-6 <= scale(value) <= 100 + 1e-6 for value in values)
    assert scale.ticks == sorted(scale.ticks)


@given(st.lists(st.floats(0, 300), max_size=30))
def test_marks_of_a_swarm_do_not_overlap(ys: list[float]) -> None:
    """Any two marks are at least the gap apart."""
    shifts = swarm(ys, 8.0)
    marks = list(zip(shifts, ys, strict=True))
    for place, (x, y) in enumerate(marks):
        assert all(np.hypot(x - a, y - b) >= 8 - 1e-6 for a, b in marks[:place])


def test_labels_are_moved_apart() -> None:
    """Labels that would overlap move down, in order."""
    assert spread_labels([(10.0, "b"), (9.0, "a"), (40.0, "c")], 12) == [
        (9.0, "a"),
        (21.0, "b"),
        (40.0, "c"),
    ]


def test_three_conditions_are_drawn() -> None:
    """The figure of means takes any number of conditions."""
    means = np.array([[1.0, 2.0, 4.0], [2.0, 2.5, 3.0], [1.5, 3.0, 3.5]])
    cells = Cells(("a", "b", "c"), ("x", "y", "z"), means, np.ones((3, 3), dtype=np.int64))
    drawing = paired_means(
        "t", cells, ("X", "Y", "Z"), ("", "", ""), measure="Reward", unit="points"
    )
    assert drawing.markup().count("f-c2") >= 3


def test_text_of_a_drawing_is_escaped() -> None:
    """Names with markup stay text."""
    drawing = Drawing("n", 10, 10, "<title>")
    drawing.text((0, 0), "<b>")
    assert "<b>" not in drawing.markup()
    assert "<title>&lt;title&gt;" not in drawing.markup().replace(' id="figure-n-title"', "x")
    assert "&lt;b&gt;" in drawing.markup()


def test_numbers_are_written_by_the_rules() -> None:
    """True minus, no leading zero of p, no signed zero, arrows for headings."""
    assert number(-1.234) == "−1.23"
    assert number(-0.001) == "0.00"
    assert fraction(-0.5) == "−.50"
    assert fraction(1.0) == "1.00"
    assert p_value(0.0123) == ".012"
    assert p_value(0.00001) == "<\u00a0.001"
    assert signed(-0.02) == "0"
    assert signed(2.0) == "+2.0"
    assert heading_label(-np.pi / 2) == "↓ south"
    assert heading_label(0.3) == "17°"


def test_a_label_stands_at_the_right_where_that_is_free() -> None:
    """Without anything near, the text begins beside its mark."""
    (label,) = place_labels([(50.0, 50.0)], [30.0], [], Box(0, 0, 200, 100))
    assert label.anchor == "start"
    assert label.box.left > 50 + 8


@given(
    st.lists(st.tuples(st.floats(20, 280), st.floats(20, 180)), min_size=1, max_size=3),
    st.floats(60, 240),
)
def test_labels_cross_no_wall_if_a_place_is_free(
    marks: list[tuple[float, float]], wall: float
) -> None:
    """Labels keep inside the map and off its one wall wherever their marks are."""
    edge = Box(wall - 3, 0, wall + 3, 200)
    labels = place_labels(marks[:1], [34.0], [edge], Box(0, 0, 300, 200))
    for label in labels:
        assert label.box.overlap(edge) == 0
        assert label.box.overlap(Box(0, 0, 300, 200)) == pytest.approx(label.box.area)


def test_two_close_peaks_have_their_values_apart() -> None:
    """A value is written neither over another value nor over another ring."""
    marks = [(100.0, 100.0), (125.0, 102.0), (112.0, 124.0)]
    labels = place_labels(marks, [34.0] * 3, [], Box(0, 0, 300, 200))
    for place, label in enumerate(labels):
        assert all(label.box.overlap(other.box) == 0 for other in labels[place + 1 :])
        for other, (x, y) in enumerate(marks):
            if other != place:
                assert label.box.overlap(Box(x - 8, y - 8, x + 8, y + 8)) == 0


def test_ends_of_a_narrow_interval_leave_room_for_the_mean() -> None:
    """The three values beside the interval of the differences each have a line of their own."""
    people = tuple(f"P{place}" for place in range(5))
    means = np.array([[50.0, 60.0], [60.0, 70.05], [70.0, 80.0], [80.0, 90.05], [40.0, 50.0]])
    cells = Cells(people, ("a", "b"), means, np.full((5, 2), 8))
    labels, hints = ("A", "B"), ("", "")
    page = paired_means("x", cells, labels, hints, measure="M", unit="points").markup()
    lines = [
        float(y)
        for y, value in re.findall(r'<text class="[^"]*" x="[^"]*" y="([^"]*)"[^>]*>([^<]*)<', page)
        if value in ("+10.0", "+10.1")
    ]
    assert len(lines) == 3
    assert min(b - a for a, b in itertools.pairwise(sorted(lines))) > 12


@pytest.mark.parametrize(("people", "drawn"), [(2, False), (3, True)])
def test_no_interval_is_drawn_where_every_test_is_refused(people: int, drawn: bool) -> None:
    """Two participants have a mean, but no interval that somebody could take for a result."""
    means = np.array([[1.0, 2.0], [2.0, 2.5], [1.5, 3.0]])[:people]
    cells = Cells(("a", "b", "c")[:people], ("x", "y"), means, np.ones((people, 2), dtype=np.int64))
    page = paired_means("t", cells, ("X", "Y"), ("", ""), measure="M", unit="points").markup()
    assert ("95% CI" in page) == drawn


def test_low_health_is_what_participants_see() -> None:
    """Maps mark the health below which the session shows its cue."""
    assert LOW_HEALTH == cues.LOW_HEALTH
