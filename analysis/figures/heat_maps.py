"""Learned scorers drawn over the task's map: colours below, walls and glyphs above."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy import ndimage

from analysis.figures.label_places import Box, place_labels
from analysis.figures.palettes import DARK_PRGN, LIGHT_PRGN
from analysis.figures.png import data_uri, indexed_png
from analysis.figures.score_maps import Floats, Peak, ScoreMap, filled
from analysis.figures.svg import Drawing
from study.events.scene import Scene
from study.events.task_description import MapGrid

WIDTH, GAP = 920.0, 26.0
LARGE_WIDTH = 336.0
SMALL_GAP = 10.0
LOW_HEALTH = 30.0
"""Below it participants see the cue of low health (`study.session.cues`); it is not recorded."""
HEADING_NAMES = (
    "→ east",
    "↗ north-east",
    "↑ north",
    "↖ north-west",
    "← west",
    "↙ south-west",
    "↓ south",
    "↘ south-east",
)
Place = Callable[[float, float], tuple[float, float]]
"""From metres on the map to pixels of the drawing."""

DIGIT_WIDTH = 7.6
"""Width of a figure in the bold type of peaks' values, px."""
FINER = 3
"""Pixels of a large map for each cell: printers do not smooth what screens do."""

HALF = (len(LIGHT_PRGN) - 1) // 2


def heat_map_row(name: str, scores: ScoreMap, scene: Scene, grid: MapGrid, limit: float) -> Drawing:
    """Draw one participant: the mean map, and small maps by heading and by health.

    Args:
        name: unique in the page.
        scores: the participant's maps.
        scene: what to draw over them.
        grid: where scores were computed.
        limit: value at which the colours end.
    """
    aspect = scene.height / scene.width
    # One level says that the task has no health.
    healths = grid.healths if len(grid.healths) > 1 else ()
    columns = max(len(grid.headings), len(healths), 1)
    left = LARGE_WIDTH + GAP
    small = (WIDTH - left - SMALL_GAP * (columns - 1)) / columns
    small_height = small * aspect
    rows = 2 if healths else 1
    height = max(LARGE_WIDTH * aspect, rows * (small_height + 22) - 4) + 4
    title = f"Scorer of {scores.participant} over the map; {_peaks_in_words(scores.peaks)}"
    drawing = Drawing(name, WIDTH, height, title)
    painter = _Painter(drawing, scene, grid, limit)
    painter.map("mean", scores.mean, (1, 1), LARGE_WIDTH - 2, scores.peaks)
    for place, heading in enumerate(grid.headings):
        x = left + place * (small + SMALL_GAP)
        drawing.text((x, 11), heading_label(heading), "f-quiet", size=11.5)
        painter.map(f"heading{place}", scores.by_heading[place], (x, 17), small, ())
    top = small_height + 17 + 8
    for place, health in enumerate(healths):
        x = left + place * (small + SMALL_GAP)
        low = health < LOW_HEALTH
        named = f"health {health:g}, low" if low else f"health {health:g}"
        drawing.text((x, top + 11), named, "f-warn bold" if low else "f-quiet", size=11.5)
        painter.map(f"health{place}", scores.by_health[place], (x, top + 17), small, ())
    return drawing


def colour_bar(name: str, limit: float) -> Drawing:
    """Draw the scale that all maps share."""
    drawing = Drawing(name, WIDTH, 34, f"Colours from {-limit:g} to {limit:g}")
    ramp = np.arange(len(LIGHT_PRGN), dtype=np.uint8)[None, :]
    _picture(drawing, ramp, (0, 0), LARGE_WIDTH, 12)
    ticks = 4
    for place in range(ticks + 1):
        value = limit * (2 * place / ticks - 1)
        x = LARGE_WIDTH * place / ticks
        anchor = "start" if place == 0 else "end" if place == ticks else "middle"
        drawing.text((x, 28), signed(value), "f-quiet", anchor, 11.5)
    note = "φ − mean φ, in log-odds of being chosen; every map shares this scale"
    drawing.text((LARGE_WIDTH + GAP, 12), note, "f-quiet", size=11.5)
    return drawing


def heading_label(heading: float) -> str:
    """Return a heading as arrow and word: 0 is east, a quarter turn is north."""
    degrees = math.degrees(heading) % 360
    eighth = round(degrees / 45)
    if abs(degrees - 45 * eighth) < 1:
        return HEADING_NAMES[eighth % 8]
    return f"{degrees:.0f}°"


def signed(value: float) -> str:
    """Write a value with one decimal and its sign, a true minus; zero has none."""
    text = f"{abs(value):.1f}"
    if float(text) == 0:
        return "0"
    return ("−" if value < 0 else "+") + text


def _peaks_in_words(peaks: Sequence[Peak]) -> str:
    if not peaks:
        return "no peak"
    shown = "; ".join(f"{signed(p.value)} at x {p.x:.1f} m, y {p.y:.1f} m" for p in peaks)
    return f"peaks {shown}"


class _Painter:
    """Draws maps of one scene into a drawing."""

    def __init__(self, drawing: Drawing, scene: Scene, grid: MapGrid, limit: float) -> None:
        self._drawing = drawing
        self._scene = scene
        self._grid = grid
        self._limit = limit

    def map(
        self,
        name: str,
        values: Floats,
        corner: tuple[float, float],
        width: float,
        peaks: Sequence[Peak],
    ) -> None:
        """Draw one map with its upper left corner at ``corner``."""
        drawing, scene = self._drawing, self._scene
        unit = width / scene.width
        large = width > 250

        def at(x: float, y: float) -> tuple[float, float]:
            return corner[0] + x * unit, corner[1] + (scene.height - y) * unit

        rooms = [r for r in scene.rectangles if r.role == "room"]
        clip = drawing.clip(
            name, [(*at(r.x, r.y + r.height), r.width * unit, r.height * unit) for r in rooms]
        )
        drawing.open_group(clip=clip)
        self._colours(values, at, unit, finer=FINER if large else 1)
        drawing.close_group()
        for mark in scene.rectangles:
            spot = at(mark.x, mark.y + mark.height)
            if mark.role == "hazard":
                drawing.rect(spot, mark.width * unit, mark.height * unit, "hatch s-map")
        for mark in scene.rectangles:
            spot = at(mark.x, mark.y + mark.height)
            if mark.role == "wall":
                drawing.rect(spot, max(mark.width * unit, 1), max(mark.height * unit, 1), "f-ink")
        for disc in scene.discs:
            if disc.role == "wall":
                drawing.circle(at(disc.x, disc.y), disc.radius * unit, "f-ink")
        if large:
            self._glyphs(at, unit)
        places = [at(peak.x, peak.y) for peak in peaks]
        for place in places:
            drawing.circle(place, 8, "none s-paper halo-ring")
            drawing.circle(place, 8, "none s-ink ring")
        texts = [signed(peak.value) for peak in peaks]
        frame = Box(*corner, corner[0] + width, corner[1] + scene.height * unit)
        widths = [DIGIT_WIDTH * len(text) for text in texts]
        labels = place_labels(places, widths, self._obstacles(at, unit), frame)
        for text, label in zip(texts, labels, strict=True):
            drawing.text((label.x, label.y), text, "f-ink bold halo", label.anchor, 12)

    def _obstacles(self, at: Place, unit: float) -> list[Box]:
        """Return walls, a little wider than drawn, and glyphs."""
        found = []
        for mark in self._scene.rectangles:
            if mark.role == "wall":
                x, y = at(mark.x, mark.y + mark.height)
                wide, high = max(mark.width * unit, 1), max(mark.height * unit, 1)
                found.append(Box(x - 2, y - 2, x + wide + 2, y + high + 2))
        for disc in self._scene.discs:
            x, y = at(disc.x, disc.y)
            if disc.role == "wall":
                reach = disc.radius * unit + 2
                found.append(Box(x - reach, y - reach, x + reach, y + reach))
                continue
            half = max(disc.radius * unit, 9) if disc.role == "goal" else 9
            found.append(Box(x - half, y - half, x + half, y + half))
        return found

    def _colours(self, values: Floats, at: Place, unit: float, finer: int) -> None:
        grid = self._grid
        dx = grid.xs[1] - grid.xs[0] if len(grid.xs) > 1 else self._scene.width
        dy = grid.ys[1] - grid.ys[0] if len(grid.ys) > 1 else self._scene.height
        smooth = ndimage.zoom(filled(values), finer, order=1, mode="nearest", grid_mode=True)
        share = np.clip(smooth / self._limit, -1, 1)
        pixels = np.rint(HALF + share * HALF).astype(np.uint8)[::-1]
        corner = at(grid.xs[0] - dx / 2, grid.ys[-1] + dy / 2)
        width, height = len(grid.xs) * dx * unit, len(grid.ys) * dy * unit
        _picture(self._drawing, pixels, corner, width, height)

    def _glyphs(self, at: Place, unit: float) -> None:
        drawing = self._drawing
        if self._scene.gates:
            finish = self._scene.gates[-1]
            inner, outer = at(finish.inner_x, finish.inner_y), at(finish.outer_x, finish.outer_y)
            drawing.line(inner, outer, "s-ink thin-dash")
        for disc in self._scene.discs:
            x, y = at(disc.x, disc.y)
            if disc.role == "health_pack":
                drawing.line((x - 5, y), (x + 5, y), "s-ink cross")
                drawing.line((x, y - 5), (x, y + 5), "s-ink cross")
            elif disc.role == "goal":
                drawing.circle((x, y), disc.radius * unit, "none s-ink thin-dash")
                drawing.text((x, y + 5), "g", "f-ink bold italic halo", "middle", 14)
            elif disc.role == "start":
                drawing.text((x, y + 5), "s", "f-ink bold italic halo", "middle", 14)


def _picture(
    drawing: Drawing,
    pixels: np.ndarray,
    corner: tuple[float, float],
    width: float,
    height: float,
) -> None:
    """Place the picture twice, in the light and the dark palette; the sheet shows one."""
    for palette, theme in ((LIGHT_PRGN, "light-only"), (DARK_PRGN, "dark-only")):
        uri = data_uri(indexed_png(pixels, palette))
        drawing.image(corner, width, height, uri, theme)
